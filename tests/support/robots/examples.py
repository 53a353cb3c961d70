"""The example programs as modules, their robot files with other values, and shipped robots, loaded once."""

from __future__ import annotations

import runpy
import shutil
from functools import cache
from pathlib import Path
from typing import Any

from tauten.model import Robot, load_robot
from tauten.service.setup import Setup, load_setup

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def example(name: str) -> dict[str, Any]:
    """The functions and constants of an example, which is not run."""
    return runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name=name)


def changed(folder: Path, file: str, *changes: tuple[str, str]) -> Path:
    """A robot file of the examples in another folder, with other text.

    Args:
        folder: into which the file goes, with all meshes and robot files of the examples that are not there.
        file: its name.
        changes: what is replaced by what; each occurs.
    """
    for path in [*EXAMPLES.glob("*.vtu"), *EXAMPLES.glob("*.toml")]:
        if not (folder / path.name).exists():
            shutil.copy(path, folder)
    text = (folder / file).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    (folder / file).write_text(text, encoding="utf-8")
    return folder / file


@cache
def shipped_robot(name: str) -> Robot:
    """As `load_robot` loads it, once in a process: that takes up to a second."""
    return load_robot(name)


@cache
def shipped_setup(name: str) -> Setup:
    """As it is served."""
    return load_setup(name)
