"""Writes the tables of README.md from the JSON files in docs/results.

    python docs/tables.py

README.md names beside each table the command that writes its JSON file.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tauten.service.tables import Numbers

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"


def read(name: str) -> Any:
    """One result."""
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))


def table(head: list[str], body: list[list[str]]) -> str:
    """A Markdown table."""
    return Numbers("", tuple(head), tuple(map(tuple, body))).markdown().strip()


def spread(value: dict[str, float]) -> str:
    """Median and 99th percentile."""
    return f"{value['p50']:.2f} / {value['p99']:.2f}"


def machine_line(result: dict[str, Any]) -> str:
    """The machine of a measurement."""
    facts = result["machine"]
    processor = facts["processor"].replace("(R)", "").replace("(TM)", "")
    return f"{processor}, {facts['cores']} cores, BLAS on one thread, load {facts['load']:.1f}."


def finger() -> str:
    """Stages of a control step, and tip errors of the contact basis."""
    shipped = read("finger")
    sizes = shipped["sizes"]
    control = shipped["control"]
    head = ["median / p99 [ms]", *(f"contact {part['contact']}" for part in control)]
    stages = [*control[0]["stages_ms"], *control[0]["whole_ms"]]
    times = [{**part["stages_ms"], **part["whole_ms"]} for part in control]
    body = [[f"**{s}**" if s == "step" else s, *(spread(t[s]) for t in times)] for s in stages]
    about = (
        f"{sizes['nodes']} nodes, {sizes['elements']} tetrahedra, {sizes['candidates']} contact "
        f"candidates; {shipped['factorisation']}; {machine_line(shipped)}"
    )
    return "\n\n".join([about, table(head, body), tip_errors([shipped])])


def tip_errors(results: list[dict[str, Any]]) -> str:
    """Reduced against pointwise contact from rest to the largest pull."""
    head = ["tip error against pointwise contact, mean / max [mm]", "alone", "with enrichment"]
    body = []
    for result in results:
        errors = {e["enriched"]: e for e in result["tip_error"]}
        cells = [
            f"{errors[key]['mean_mm']:.3f} / {errors[key]['max_mm']:.3f}" for key in (False, True)
        ]
        body.append([f"k = {result['sizes']['modes']}", *cells])
    return table(head, body)


def steps() -> str:
    """Plain steps on three meshes, fastest factorisation and scipy's."""
    fast, plain = read("steps"), read("steps_superlu")
    name = fast["meshes"][0]["factorisation"]
    head = ["nodes / tetrahedra"]
    head += [f"{what}, {back}" for back in (name, "superlu") for what in ("forward", "inverse")]
    body = []
    for one, two in zip(fast["meshes"], plain["meshes"], strict=True):
        cells = [f"{one['sizes']['nodes']:,} / {one['sizes']['elements']:,}"]
        cells += [spread(mesh[key]) for mesh in (one, two) for key in ("forward_ms", "inverse_ms")]
        body.append(cells)
    return f"Median / p99 [ms], no contact. {machine_line(fast)}\n\n{table(head, body)}"


def demo() -> str:
    """A minute of following targets."""
    report = read("demo")
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
    return f"{about}\n\n{table(['', report['robot']], body)}"


def contact() -> str:
    """The finger with and without contact."""
    found = read("compare")
    return (
        f"At {found['pull_mm'][0][0]:.0f} mm of pull {found['pushing']} candidates push with "
        f"{found['contact_force_n']:.1f} N together: the tip is {found['apart_mm'][0]:.2f} mm from where "
        f"it would be without contact, and the cable needs {found['tension_n'][0][0]:.2f} N "
        f"instead of {found['tension_n'][1][0]:.2f} N."
    )


def gallery() -> str:
    """Robots of the gallery."""
    found = read("gallery")
    head = ["robot", "nodes", "actuators", "candidates", "k", "r", "full step [ms]",
            "reduced step [ms]", "tip, mean / max [mm]", "campaign [min]"]  # fmt: skip
    body = []
    for row in found["robots"]:
        reduced = row["reduced_ms"] is not None
        tip = f"{row['tip_mean_mm']:.3f} / {row['tip_max_mm']:.3f}" if reduced else "–"
        body.append([
            row["robot"], str(row["nodes"]), str(row["actuators"]), str(row["candidates"]),
            str(row["modes"] or "–"), str(row["state_modes"] or "–"), spread(row["full_ms"]),
            spread(row["reduced_ms"]) if reduced else "–", tip, f"{row['campaign_s'] / 60.0:.1f}",
        ])  # fmt: skip
    return f"Whole inverse steps, median / p99. {machine_line(found)}\n\n{table(head, body)}"


TABLES: dict[str, Callable[[], str]] = {
    "finger": finger,
    "steps": steps,
    "demo": demo,
    "contact": contact,
    "gallery": gallery,
}


def filled(text: str) -> str:
    """The text with every marked block written again."""

    def block(match: re.Match[str]) -> str:
        return f"<!-- {match[1]} -->\n{TABLES[match[1]]()}\n<!-- end -->"

    return re.sub(r"<!-- (\w+) -->\n.*?<!-- end -->", block, text, flags=re.DOTALL)


def main() -> None:
    """Rewrite README.md."""
    readme = ROOT / "README.md"
    readme.write_text(filled(readme.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
