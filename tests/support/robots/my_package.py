"""docs/extend.md as an installed package: its code is the module, its entry points are those of the page."""

from __future__ import annotations

import importlib
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

PAGE = Path(__file__).resolve().parents[3] / "docs" / "extend.md"
MODULE = "my_package"
SPREAD = """
[[effectors]]
name = "grasp"
kind = "function"
measure = "spread"
points = [[0.1, 0.0, 0.01], [0.1, 0.02, 0.01], [0.08, 0.01, 0.015]]
"""
MUSCLE = """
[[transmissions]]
name = "muscle"
function = "mckibben"
points = [[0.0, 0.01, 0.002], [0.1, 0.01, 0.002]]
parameters = { fibre = 0.12, turns = 1.5 }
unit = "m3"
max_position = 1e-5
min_effort = 0.0
max_effort = 3e3
max_rate = 1e-4
"""


def blocks(language: str) -> list[str]:
    """The code blocks of the page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def tables() -> list[dict[str, list[dict[str, object]]]]:
    """The tables of robot files on the page, which are indented."""
    parts = re.findall(r"(?:^(?:    .*)?\n)+", PAGE.read_text(encoding="utf-8"), re.M)
    text = [re.sub(r"^    ", "", part, flags=re.M).strip() for part in parts]
    return [tomllib.loads(part) for part in text if part.startswith("[[")]


def write_package(
    folder: Path, module: str, code: str, groups: Mapping[str, Mapping[str, str]]
) -> None:
    """A module as an installed package, with entry points by group and name."""
    (folder / f"{module}.py").write_text(code, encoding="utf-8")
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    lines = []
    for group, entries in groups.items():
        lines += [f"[{group}]", *(f"{name} = {value}" for name, value in entries.items())]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n")


@contextmanager
def installed(folder: Path) -> Iterator[ModuleType]:
    """The module of the page, beside what pip writes for its entry points, while it can be imported."""
    code = "from __future__ import annotations\n\n" + "\n\n".join(blocks("python"))
    groups = tomllib.loads("\n".join(blocks("toml")))["project"]["entry-points"]
    write_package(folder, MODULE, code, groups)
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    before = sys.modules.pop(MODULE, None)
    try:
        yield importlib.import_module(MODULE)
    finally:
        sys.path.remove(str(folder))
        sys.modules.pop(MODULE, None)
        if before is not None:
            sys.modules[MODULE] = before
