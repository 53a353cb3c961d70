"""How the rooms may know each other: model ← reduction ← controller ← service."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ORDER = ("model", "reduction", "controller", "service")
FILES = [path for package in ORDER for path in sorted((ROOT / package).rglob("*.py"))]


def imported(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names.add(node.module or "")
    return names


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_one_way(path: Path) -> None:
    rank = ORDER.index(path.relative_to(ROOT).parts[0])
    for name in imported(path):
        top, *rest = name.split(".")
        assert top not in ORDER, f"{path}: bare import of {name}"
        if top == "tauten":
            assert ORDER.index(rest[0]) <= rank, f"{path} imports {name}"


def test_only_one_room_names_a_qp_library() -> None:
    libraries = {"daqp", "osqp", "proxsuite", "qpsolvers", "quadprog"}
    users = {
        path.name for path in FILES if libraries & {name.split(".")[0] for name in imported(path)}
    }
    assert users == {"qp.py"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_rooms_stay_small(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 300
    assert path.name != "utils.py"
