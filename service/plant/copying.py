"""The files of a robot in the folder of its demo, so that its log can be opened there, and elsewhere."""

from __future__ import annotations

import hashlib
import json
import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tauten.model.load import is_shipped
from tauten.model.schema import RobotFileError, read_toml
from tauten.reduction import atomic_write

SUFFIXES = ("", ".basis", ".states", ".toml")  # that the name of a file may be without

_TEXT = re.compile(r"\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*'")  # of one line, in TOML

Copies = Mapping[Path, bytes]


def robot_copies(file: Path, basis: str | None, folder: Path) -> Copies:
    """Copies of a robot file and what it names: meshes, surfaces, bases, parts, error of its mesh; by path.

    Shipped robots are known by their names and are not copied. Files that do not stand below the robot file
    get a folder for each one that they are from, and the copy of the robot file names them so. The contact
    basis, which may be another than the file's, is also copied beside the robot file, where logs look for it.
    A robot in its own folder stays as it is, and nothing in the folder changes.

    Raises:
        RobotFileError: two files would be the same copy, or one is in the folder with other contents.
    """
    source, folder, copies = file.resolve(), folder.resolve(), dict[Path, bytes]()
    if not is_shipped(source):
        _Plan(folder, copies).add_robot(source, folder / source.name)
        basis = basis or read_toml(source).get("controller", {}).get("basis")
    if basis is not None:
        chosen = next((path for path in _candidates(file.parent, basis) if path.is_file()), None)
        if chosen is not None and not is_shipped(chosen):
            _add(copies, folder / chosen.name, chosen.read_bytes())
    for target, contents in copies.items():
        if target.exists() and not (target.is_file() and target.read_bytes() == contents):
            raise RobotFileError(
                f"{target}: is there with other contents than the robot's {target.name}: choose another "
                "--out, or move it away"
            )
    return copies


def write_copies(copies: Copies) -> None:
    """Write copies of files that are not there yet.

    Raises:
        OSError: one cannot be written; nothing is left of it.
    """
    for target, contents in copies.items():
        if not target.exists():
            with atomic_write(target) as file:
                file.write(contents)


@dataclass(frozen=True, slots=True)
class _Plan:
    """Copies in a folder."""

    folder: Path
    copies: dict[Path, bytes]

    def add_robot(self, file: Path, target: Path) -> None:
        """Add a robot file and what it names; each once."""
        if file == target:
            return
        text, contents = file.read_text(encoding="utf-8"), read_toml(file)
        names = {
            name for name in _texts(contents) if name and "\n" not in name and len(name) < 1024
        }
        renamed, parts = dict[str, str](), list[tuple[Path, Path]]()
        for name in (*sorted(names), file.stem, f"{file.stem}.mesh.json"):
            for path in _candidates(file.parent, name):
                if not path.is_file() or path.resolve() == file:
                    continue
                found, inside = path.resolve(), Path(name)
                if found.suffix == ".toml" and is_shipped(found):
                    renamed |= {} if _is_below(inside) else {name: found.stem}
                    continue
                if not _is_below(inside):
                    inside = Path(os.path.relpath(self._place(path), target.parent), inside.name)
                    renamed[name] = inside.as_posix()
                place = Path(os.path.normpath(target.parent / inside.parent / path.name))
                if found.suffix == ".toml":
                    parts.append((found, place))
                else:
                    _add(self.copies, place, found.read_bytes())
        is_new = target not in self.copies
        _add(self.copies, target, _renamed(file, text, contents, renamed).encode("utf-8"))
        if is_new:
            for part, place in parts:
                self.add_robot(part, place)

    def _place(self, path: Path) -> Path:
        """The folder for the copy of a file that does not stand below its robot file."""
        parent = str(path.parent.resolve())
        return self.folder / f"from-{hashlib.sha256(parent.encode()).hexdigest()[:8]}"


def _add(copies: dict[Path, bytes], target: Path, contents: bytes) -> None:
    if copies.setdefault(target, contents) != contents:
        raise RobotFileError(
            f"{target.name}: two files of the robot with this name would be the same copy {target}: "
            "rename one"
        )


def _renamed(file: Path, text: str, contents: dict[str, Any], names: Mapping[str, str]) -> str:
    """The text of a robot file that names other files."""

    def other(found: re.Match[str]) -> str:
        try:
            value = tomllib.loads(f"value = {found[0]}")["value"]
        except tomllib.TOMLDecodeError:  # in a comment, or part of a longer text
            return found[0]
        return json.dumps(names[value], ensure_ascii=False) if value in names else found[0]

    if not names:
        return text
    text = _TEXT.sub(other, text)
    try:
        same = set(_texts(tomllib.loads(text))) == {names.get(v, v) for v in _texts(contents)}
    except tomllib.TOMLDecodeError:
        same = False
    if not same:
        raise RobotFileError(
            f"{file}: its files cannot be copied: write {', '.join(sorted(names))} in plain quotes"
        )
    return text


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
