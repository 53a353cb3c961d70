"""The example programs as modules, and their robot files with other values."""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path
from typing import Any

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
