"""Which folder may import from which: one table, and sizes that keep a folder readable."""

from __future__ import annotations

import ast
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# Imports between folders go down this table only: a folder imports from folders above its own line.
# A name without a folder below it stands for the modules directly inside.
ORDER = (
    "model.kernels",
    "model.numerics",
    "model.friction",
    "model.materials",
    "model.schema",
    "model.signals",
    "model",
    "model.mesh",
    "model.points",
    "model.actuators",
    "model.effectors",
    "model.contact",
    "model.body",
    "model.tetra",
    "model.beams",
    "model.constraints",
    "model.robot",
    "model.parts",
    "model.step",
    "model.simulation",
    "model.load",
    "model.robots",
    "reduction",
    "reduction.campaign",
    "reduction.contact",
    "reduction.state.tetra",
    "reduction.state.beams",
    "reduction.state",
    "controller.qpcc",
    "controller.friction",
    "controller.planning",
    "controller.damping",
    "controller",
    "service.link",
    "service.codec",
    "service.process",
    "service.check",
    "service.new",
    "service.wire",
    "service.log",
    "service",
    "service.node",
    "service.drive",
    "service.replay",
    "service.plant",
    "service.operate",
    "service.frames",
    "service.view.web",
    "service.view.picture",
    "service.view",
    "service.bench",
    "service.tables",
    "service.plots",
    "service.cli.terminal",
    "service.cli",
    "benchmarks.robots",
    "benchmarks.robots.gallery",
    "benchmarks.robots.grasping",
    "benchmarks.qpcc",
    "benchmarks.friction",
    "benchmarks.elements",
    "benchmarks.physics",
    "benchmarks.contact_basis",
    "benchmarks.steps",
    "benchmarks.manipulator",
    "benchmarks.view",
    "benchmarks.control",
    "benchmarks.kernels",
    "benchmarks.tables",
    "benchmarks.plots",
    "benchmarks.commands",
    "benchmarks",
)
MOST_MODULES = 15
MOST_LINES = 400
MOST_PARAMETERS = 8
DOCUMENTED = 3  # parameters of a public function from which on its docstring lists them,
NUMBERS = re.compile(
    r"Array|Ints|Bools|float|complex"
)  # if any has a shape or unit, which no annotation says
PACKAGES = (
    "model",
    "reduction",
    "controller",
    "service",
)  # what is installed, as parts of `tauten`
# `serve` is the process that a robot depends on: none of these is loaded by it.
LABORATORY = (
    "service.frames",
    "service.view.web",
    "service.view.picture",
    "service.view",
    "service.bench",
    "service.tables",
    "service.plots",
    "service.cli",
)

FILES = [
    path for package in (*PACKAGES, "benchmarks") for path in sorted((ROOT / package).rglob("*.py"))
]
# Faces and entry points stand above the modules of their folder.
MODULES = [path for path in FILES if path.name not in ("__init__.py", "__main__.py")]


@cache
def folder_of(path: Path) -> str:
    """The folder of a module, with dots."""
    return ".".join(path.relative_to(ROOT).parent.parts)


# `Simulator.of` loads all that a robot file names, which the folders below it read.
LATE = {("model/simulation/simulator.py", "tauten.controller.starting")}


@cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of a module."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imported_folders(path: Path) -> set[tuple[str, str]]:
    """Folders of the table that a module imports from, each with the name it imports from it."""
    found: set[tuple[str, str]] = set()
    tree, own = parsed(path), path.relative_to(ROOT).as_posix()
    early = {id(node) for node in tree.body}
    for node in ast.walk(tree):
        module = getattr(node, "module", None)
        if id(node) not in early and (own, module) in LATE:
            continue
        modules: list[str] = []
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            modules = [f"{node.module}.{alias.name}" for alias in node.names]
        for module in modules:
            if module.startswith(("tauten.", "benchmarks.")):
                name = module.removeprefix("tauten.")
                found.add((longest_folder(name), name))
    return found


@cache
def longest_folder(name: str) -> str:
    """The line of the table that a dotted name belongs to."""
    return max((folder for folder in ORDER if f"{name}.".startswith(f"{folder}.")), key=len)


def test_every_folder_stands_in_the_table() -> None:
    assert {folder_of(path) for path in FILES} == set(ORDER)


@pytest.mark.parametrize("folder", ORDER)
def test_imports_go_down_the_table_only(folder: str) -> None:
    allowed = ORDER[: ORDER.index(folder) + 1]
    upwards = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in MODULES
        if folder_of(path) == folder
        for target, name in imported_folders(path)
        if target not in allowed
    ]
    assert not upwards


def test_names_of_another_folder_come_from_its_face() -> None:
    past = []
    for path in MODULES:
        own = folder_of(path)
        for target, name in imported_folders(path):
            module = ROOT / f"{'/'.join(name.split('.')[:-1])}.py"
            # `service` has no face: whoever imports a folder of it would wait for all of it
            story = "." not in target and (own.split(".")[0] == target or target == "service")
            if target != own and module.is_file() and not story:
                past.append(f"{path.relative_to(ROOT)} imports {name}")
    assert not past


def test_the_node_does_not_import_benchmarks_plots_or_commands() -> None:
    found = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in FILES
        if folder_of(path) in ("service.node", "service.wire", "service.process", "service.log")
        for target, name in imported_folders(path)
        if target.startswith(LABORATORY)
    ]
    assert not found


@pytest.mark.parametrize("folder", ORDER)
def test_a_folder_has_few_modules(folder: str) -> None:
    modules = [path for path in MODULES if folder_of(path) == folder]
    assert len(modules) <= MOST_MODULES


def test_a_folder_of_tests_has_few_modules() -> None:
    folders = Counter(path.parent for path in (ROOT / "tests").rglob("*.py"))
    assert {str(path): count for path, count in folders.items() if count > MOST_MODULES} == {}


def test_a_module_is_short() -> None:
    lines = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for path in [*FILES, *sorted((ROOT / "tests").rglob("*.py"))]
    }
    assert {name: count for name, count in lines.items() if count > MOST_LINES} == {}


def functions(tree: ast.AST, public: bool = True) -> Iterator[tuple[ast.FunctionDef, bool]]:
    """Functions and methods below a node, each with whether its name and those around it are public."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            seen = public and not node.name.startswith("_")
            if isinstance(node, ast.FunctionDef):
                yield node, seen
            if isinstance(node, ast.ClassDef):
                yield from functions(node, seen)


def parameters(function: ast.FunctionDef) -> list[str]:
    """Names of the parameters, without self and cls."""
    found = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return [one.arg for one in found if one.arg not in ("self", "cls")]


# Commands of the command line document their options themselves.
COMMANDS = ("service.cli", "benchmarks.commands")


@pytest.mark.parametrize("folder", [folder for folder in ORDER if folder not in COMMANDS])
def test_functions_have_few_parameters_and_document_them(folder: str) -> None:
    found = [
        (f"{path.relative_to(ROOT)}: {one.name}", one, public)
        for path in MODULES
        if folder_of(path) == folder
        for one, public in functions(parsed(path))
    ]
    many = [name for name, one, _ in found if len(parameters(one)) > MOST_PARAMETERS]
    assert not many
    silent = [
        name
        for name, one, public in found
        if public
        and len(parameters(one)) >= DOCUMENTED
        and has_numbers(one)
        and not documents_arguments(one)
    ]
    assert not silent


def has_numbers(function: ast.FunctionDef) -> bool:
    """Whether a parameter is a number or an array of numbers."""
    found = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return any(one.annotation and NUMBERS.search(ast.unparse(one.annotation)) for one in found)


def documents_arguments(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether its docstring lists arguments, or names the class whose method of this name does."""
    text = ast.get_docstring(function) or ""
    classes = re.findall(r"[Ss]ee `(\w+)`", text)
    return "Args:" in text or any((one, function.name) in documented_methods() for one in classes)


@cache
def documented_methods() -> set[tuple[str, str]]:
    """Class and name of all methods whose docstrings list arguments."""
    classes = [
        one for path in MODULES for one in ast.walk(parsed(path)) if isinstance(one, ast.ClassDef)
    ]
    return {
        (one.name, method.name)
        for one in classes
        for method in one.body
        if isinstance(method, ast.FunctionDef) and "Args:" in (ast.get_docstring(method) or "")
    }


def test_a_class_name_has_one_meaning() -> None:
    names = Counter(
        node.name
        for path in MODULES
        for node in parsed(path).body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert [name for name, count in names.items() if count > 1] == []


def test_every_folder_of_the_package_is_installed() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert set(settings["tool"]["setuptools"]["packages"]) == {
        f"tauten.{name}" for name in ORDER if name.split(".")[0] in PACKAGES
    }
