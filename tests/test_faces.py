"""What folders export: a name that nobody imports from a folder is no part of its face."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from reference_pages import PYTHON
from test_architecture import ORDER, PACKAGES, ROOT

IMPORT = re.compile(r"from ((?:tauten|benchmarks)[\w.]*) import (\([^)]*\)|[^\n]*)")
DOTTED = re.compile(r"\b((?:tauten|benchmarks)(?:\.\w+)*)\.(\w+)")
ALIAS = re.compile(r"from (tauten[\w.]*) import (\w+) as (\w+)")


def module_of(folder: str) -> str:
    """The name that a folder is imported by."""
    return f"tauten.{folder}" if folder.split(".")[0] in PACKAGES else folder


def readers() -> Iterator[Path]:
    """All files that may import something: modules, tests, pages, examples."""
    for folder in (*PACKAGES, "benchmarks", "tests", "docs", "examples"):
        yield from (ROOT / folder).rglob("*.py")
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
        if page.name != "CHANGELOG.md" and not {"reference", "_build"} & set(page.parts):
            yield page


@cache
def imported() -> dict[str, set[str]]:
    """Names that are imported from each module by files outside its folder; in strings and pages too."""
    found: defaultdict[str, set[str]] = defaultdict(set)
    for path in readers():
        own = module_of(".".join(path.relative_to(ROOT).parent.parts))
        text = path.read_text(encoding="utf-8")
        named = [(module, re.findall(r"\w+", names)) for module, names in IMPORT.findall(text)]
        named += [(module, [name]) for module, name in DOTTED.findall(text)]
        for module, name, alias in ALIAS.findall(text):
            named.append((f"{module}.{name}", re.findall(rf"\b{alias}\.(\w+)", text)))
        for module, names in named:
            if module != own:
                found[module].update(names)
    return found


def exported(folder: str) -> list[str]:
    """What the face of a folder lists."""
    text = (ROOT / folder.replace(".", "/") / "__init__.py").read_text(encoding="utf-8")
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            names: list[str] = ast.literal_eval(node.value)
            return names
    return []


def is_documented_type(folder: str, name: str) -> bool:
    """Whether users meet a name in the reference without importing it: the type of what they are given."""
    return module_of(folder) in PYTHON and name[0].isupper() and not name.isupper()


@pytest.mark.parametrize("folder", ORDER)
def test_somebody_imports_what_a_folder_exports(folder: str) -> None:
    used = imported()[module_of(folder)]
    idle = [
        name
        for name in exported(folder)
        if name not in used and not is_documented_type(folder, name)
    ]
    assert idle == []


@pytest.mark.parametrize("folder", ORDER)
def test_a_face_lists_its_names_once(folder: str) -> None:
    names = exported(folder)
    assert len(names) == len(set(names))
