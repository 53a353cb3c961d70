"""Writes the generated pages of the reference: robot file, commands, Python names, pages of the repository.

    python docs/scripts/reference_pages.py

`docs/conf.py` calls it in each build of the site.
"""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path

import typer
from robot_file_page import robot_file_page
from typer.core import TyperCommand, TyperGroup

from tauten.service.cli.app import app

ROOT = Path(__file__).resolve().parents[2]

# Folders whose names users import, in the order in which a reader needs them.
PYTHON = (
    "tauten.model",
    "tauten.model.load",
    "tauten.model.actuators",
    "tauten.model.effectors",
    "tauten.model.friction",
    "tauten.controller",
    "tauten.controller.qpcc",
    "tauten.reduction",
    "tauten.reduction.campaign",
    "tauten.reduction.contact",
    "tauten.reduction.state",
    "tauten.service.log",
    "tauten.service.wire",
    "tauten.service.drive",
)


def write_pages(folder: Path) -> None:
    """Write all generated pages into a folder; a page that did not change keeps its time."""
    folder.mkdir(exist_ok=True)
    pages = {
        "commands.md": commands_page(),
        "python.md": python_page(),
        "robot-file.md": robot_file_page(),
        "changelog.md": root_page("CHANGELOG.md"),
        "contributing.md": root_page("CONTRIBUTING.md"),
    }
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def root_page(name: str) -> str:
    """A page of the repository's first folder, with its links as seen from the reference."""
    text = (ROOT / name).read_text(encoding="utf-8")
    text = re.sub(r"\]\(docs/", "](../", text)
    return text.replace("](CHANGELOG.md)", "](changelog.md)").replace(
        "](CONTRIBUTING.md)", "](contributing.md)"
    )


def commands_page() -> str:
    """Every command of `tauten` with its arguments and options."""
    root = typer.main.get_command(app)
    assert isinstance(root, TyperGroup)
    lines = [
        "# Command line",
        "",
        "Written from the commands themselves; `tauten COMMAND --help` shows the same in a terminal.",
        "Exit code 0: done. 1: the command has found what it looks for, a difference or an error of a robot. "
        "2: bad input; one sentence on stderr names the file, the field and what is allowed.",
        "",
    ]
    lines += options_of(root, "tauten", typer.Context(root, info_name="tauten"), 2)
    return "\n".join(lines) + "\n"


def options_of(
    command: TyperCommand | TyperGroup, name: str, parent: typer.Context, level: int
) -> list[str]:
    """Lines about one command and the commands in it.

    Args:
        command: the command.
        name: as it is typed.
        parent: context of the command it belongs to.
        level: of its heading.
    """
    context = typer.Context(command, info_name=name.rsplit(" ", 1)[-1], parent=parent.parent)
    lines = [f"{'#' * level} `{name}`", "", sentence(command.help), ""]
    if isinstance(command, TyperGroup):
        lines += parameters(command, context)
        for key in sorted(command.commands):
            child = command.commands[key]
            assert isinstance(child, TyperCommand | TyperGroup)
            lines += options_of(child, f"{name} {key}", context, min(level + 1, 4))
        return lines
    usage = " ".join([name, *command.collect_usage_pieces(context)])
    return [*lines, "```text", usage, "```", "", *parameters(command, context)]


def parameters(command: TyperCommand | TyperGroup, context: typer.Context) -> list[str]:
    """A table of the arguments and options of a command; nothing where it has none."""
    rows = []
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record is None or record[0] == "--help":
            continue
        name, text = (re.sub(r"\s+", " ", part).replace("|", "\\|") for part in record)
        rows.append(f"| `{name}` | {sentence(text)} |")
    return ["| option | |", "| :-- | :-- |", *rows, ""] if rows else []


def sentence(text: str | None) -> str:
    """Help text on one line, without the mark-up of the terminal."""
    return re.sub(r"\s+", " ", re.sub(r"\[/?[a-z ]+\]", "", text or "")).strip()


def python_page() -> str:
    """The public names of the packages, a page for each class, from their docstrings."""
    lines = [
        "# Python",
        "",
        "[`Controller`](python/tauten.controller.Controller.rst) decides, "
        '[`Simulator`](python/tauten.model.Simulator.rst) simulates; `of("finger")` makes either '
        "from a robot file.",
        "Below are the public names of the folders that programs import from, each class on a page of its",
        "own; those of other folders are in `__all__` of their `__init__`. Arrays are numpy arrays of floats",
        "unless stated otherwise; shapes and units stand beside each name; [design](../design.md) explains",
        "the symbols.",
        "",
    ]
    shown: set[str] = set()
    for name in PYTHON:
        module = importlib.import_module(name)
        names = [one for one in module.__all__ if one not in shown]
        shown |= set(names)
        classes = sorted(one for one in names if inspect.isclass(getattr(module, one)))
        functions = sorted(one for one in names if inspect.isroutine(getattr(module, one)))
        lines += [f"## {name}", "", (inspect.getdoc(module) or "").partition("\n\n")[0], ""]
        lines += ["```{eval-rst}", f".. currentmodule:: {name}", ""]
        if classes:
            lines += [".. autosummary::", "   :toctree: python", "   :nosignatures:", ""]
            lines += [f"   {one}" for one in classes] + [""]
        for one in functions:
            lines += [f".. autofunction:: {one}"]
        lines += ["```", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    write_pages(ROOT / "docs" / "reference")
