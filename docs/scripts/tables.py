"""Writes the tables of README.md and docs/performance.md from the JSON files in docs/results.

    python -m docs.scripts.tables

docs/performance.md names beside each table the command that writes its JSON file.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from tauten.service.bench import Comparison, StepBench
from tauten.service.tables import Numbers, steps_page

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "docs" / "results"
PAGES = (ROOT / "README.md", ROOT / "docs" / "performance.md")

R = TypeVar("R")


def text_of(name: str) -> str:
    """The JSON file of a result."""
    return (RESULTS / f"{name}.json").read_text(encoding="utf-8")


def read(name: str, kind: type[R]) -> R:
    """A result, as the command had it."""
    return TypeAdapter(kind).validate_json(text_of(name))


def machine_line(result: dict[str, Any]) -> str:
    """The machine of a measurement."""
    facts = result["machine"]
    processor = facts["processor"].replace("(R)", "").replace("(TM)", "")
    return f"{processor}, {facts['cores']} cores, BLAS on one thread, load {facts['load']:.1f}."


def steps() -> str:
    """Plain steps on three meshes, fastest factorisation and scipy's."""
    fast, plain = (steps_page(read(name, StepBench)) for name in ("steps", "steps_superlu"))
    (table,), (slow,) = fast.tables, plain.tables
    return replace(fast, parts=(replace(table, rows=(*table.rows, *slow.rows)),)).markdown()


def demo() -> str:
    """A minute of following targets."""
    report = json.loads(text_of("demo"))
    spreads = [
        ("control step", "step_ms"),
        ("decide", "decide_ms"),
        ("everything else the node does", "overhead_ms"),
        ("target to actuation", "latency_ms"),
    ]
    body = [
        [text, f"{report[key]['p50']:.2f} / {report[key]['p99']:.2f} / {report[key]['max']:.2f} ms"]
        for text, key in spreads
    ]
    body += [
        ["ticks, deadlines missed", f"{report['ticks']}, {report['missed']}"],
        ["rate requested / achieved", f"{report['rate_hz']:.1f} / {report['achieved_hz']:.2f} Hz"],
    ]
    for effector in ("model", "plant"):
        error = report[f"{effector}_error"]
        body.append(
            [
                f"tracking error of the {effector}, RMS / max",
                f"{error['rms_mm']:.2f} / {error['max_mm']:.2f} mm",
            ]
        )
    about = f"{report['duration_s']:.0f} s; median / p99 / max. {machine_line(report)}"
    table = Numbers("", ("", report["robot"]), tuple(map(tuple, body)))
    return f"{about}\n\n{table.markdown()}"


def contact() -> str:
    """The finger with and without contact."""
    found = read("compare", Comparison)
    (position, _), (effort, without) = found.pull_mm, found.tension_n
    return (
        f"At {position[0]:.0f} mm of pull {found.pushing} candidates push with "
        f"{found.contact_force_n:.1f} N together: the tip is {found.apart_mm[0]:.2f} mm from where "
        f"it would be without contact, and the cable needs {effort[0]:.2f} N "
        f"instead of {without[0]:.2f} N.\n"
    )


def numbers() -> str:
    """The numbers that README begins with."""
    demo, spread = json.loads(text_of("demo")), "{p50:.1f} / {p99:.1f} ms".format
    rows = (
        ("a control step of the finger with self-contact, median / p99", spread(**demo["step_ms"])),
        ("of which the decision", spread(**demo["decide_ms"])),
        (
            "from a target to its actuation, most of it waiting for the tick",
            spread(**demo["latency_ms"]),
        ),
        (
            f"deadlines missed in {demo['ticks']} ticks at {demo['rate_hz']:.0f} Hz",
            f"{demo['missed']}",
        ),
        (
            "from target to tip of the simulated robot, RMS / max",
            "{rms_mm:.2f} / {max_mm:.2f} mm".format(**demo["plant_error"]),
        ),
    )
    return f"{machine_line(demo)}\n\n{Numbers('', ('', ''), rows).markdown()}"


TABLES: dict[str, Callable[[], str]] = {
    "steps": steps,
    "demo": demo,
    "contact": contact,
    "numbers": numbers,
}


def filled(text: str) -> str:
    """The text with every marked block written again."""

    def block(match: re.Match[str]) -> str:
        return f"<!-- {match[1]} -->\n{TABLES[match[1]]()}<!-- end -->"

    return re.sub(r"<!-- (\w+) -->\n.*?<!-- end -->", block, text, flags=re.DOTALL)


def main() -> None:
    """Rewrite the pages."""
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
