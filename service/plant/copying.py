"""The files of a robot in the folder of its demo, so that its log can be opened there, and elsewhere."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tauten.model.load import shipped_folder
from tauten.model.schema import read_toml

SUFFIXES = ("", ".basis", ".states", ".toml")  # that the name of a file may be without


def copy_robot(file: Path, basis: str | None, folder: Path) -> None:
    """Copy a robot file and what it names: meshes, surfaces, bases, parts, the error of its mesh.

    Shipped robots are known by their names and are not copied. A file that does not stand below the robot
    file is copied beside it, and the copy of the robot file names it so.

    Args:
        file: the robot file.
        basis: another contact basis than the file's; None: the file's.
        folder: to copy into.
    """
    source = file.resolve()
    if source.parent != shipped_folder().resolve():
        _copy(source, folder.resolve(), set())
    if basis is not None:
        chosen = next((path for path in _candidates(file.parent, basis) if path.is_file()), None)
        if chosen is not None and chosen.resolve().parent != shipped_folder().resolve():
            _copy_file(chosen, folder / chosen.name)


def _copy(file: Path, folder: Path, done: set[Path]) -> None:
    """Copy a robot file and what it names into a folder; each once."""
    if file in done:
        return
    done.add(file)
    text, contents = file.read_text(encoding="utf-8"), read_toml(file)
    names = {name for name in _texts(contents) if name and "\n" not in name and len(name) < 1024}
    for name in (*sorted(names), file.stem, f"{file.stem}.mesh.json"):
        for path in _candidates(file.parent, name):
            if not path.is_file() or path.resolve() == file:
                continue
            found, inside = path.resolve(), Path(name)
            if found.suffix == ".toml":
                if found.parent != shipped_folder().resolve():
                    _copy(found, folder / inside.parent if _is_below(inside) else folder, done)
            else:
                place = folder / inside.parent if _is_below(inside) else folder
                _copy_file(found, place / path.name)
            if not _is_below(inside) and name in names:
                text = text.replace(f'"{name}"', f'"{inside.name}"')
    _write(text, file, folder / file.name)


def _texts(contents: Any) -> Iterator[str]:
    """All texts within tables and lists."""
    if isinstance(contents, str):
        yield contents
    elif isinstance(contents, dict):
        for value in contents.values():
            yield from _texts(value)
    elif isinstance(contents, list):
        for value in contents:
            yield from _texts(value)


def _candidates(folder: Path, name: str) -> list[Path]:
    """The paths of files that a text in a robot file may name."""
    return [folder / f"{name}{suffix}" for suffix in SUFFIXES]


def _is_below(path: Path) -> bool:
    return not path.is_absolute() and ".." not in path.parts


def _copy_file(source: Path, target: Path) -> None:
    if source.resolve() == target.resolve():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def _write(text: str, source: Path, target: Path) -> None:
    if source.resolve() == target.resolve():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(text, encoding="utf-8")
