"""Arrays and a JSON header in one npz file: written whole or not at all, read without pickle."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.format import read_array, write_array
from numpy.typing import NDArray

_HEADER = "header.json"
_SHIPPED = "tauten.model.robots"


class UnknownFile(ValueError):
    """Neither a path nor the name of a shipped file; the text says what was looked for."""


class DamagedFile(ValueError):
    """A file that is not what was saved; the text says which file and what is wrong."""


@contextmanager
def located(name_or_path: str | Path, suffix: str, what: str) -> Iterator[Path]:
    """Where a file is: the path itself, or the file shipped for a robot of that name.

    Raises:
        UnknownFile: it is neither.
    """
    path = Path(name_or_path)
    if path.suffix == suffix or path.is_file():
        yield path
        return
    resources = [p for p in files(_SHIPPED).iterdir() if p.name.endswith(suffix)]
    shipped = {p.name.removesuffix(suffix): p for p in resources}
    if str(name_or_path) not in shipped:
        raise UnknownFile(
            f"no {what} {str(name_or_path)!r}: expected a path ending in {suffix} "
            f"or one of the shipped ones ({', '.join(sorted(shipped)) or 'none'})"
        )
    with as_file(shipped[str(name_or_path)]) as file:
        yield file


def write(
    path: Path, kind: str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> None:
    """Save atomically: a reader, or a run killed half way, sees the old file or the new one.

    The same content gives the same bytes; `unzip -p FILE header.json` shows the header.

    Args:
        path: file to write; its folder is made when missing.
        kind: what the file is, checked by `read`.
        header: goes into JSON.
        arrays: name to array.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"kind": kind, **header}, indent=1, ensure_ascii=False)
    descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "wb") as file:
            with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr(_member(_HEADER), text)
                for name, array in arrays.items():
                    with archive.open(_member(f"{name}.npy"), "w", force_zip64=True) as member:
                        write_array(member, np.asanyarray(array), allow_pickle=False)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(0o644)  # mkstemp keeps the file to its owner
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def read(path: Path, kind: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Header and arrays of a file of the given kind.

    Raises:
        FileNotFoundError: there is no such file.
        DamagedFile: it is cut short, altered, or of another kind.
    """
    content = path.open("rb")  # outside of `try`: a missing file is not a damaged one
    try:
        with content, zipfile.ZipFile(content) as archive:
            if (bad := archive.testzip()) is not None:
                raise ValueError(f"checksum of {bad} does not match")
            header = json.loads(archive.read(_HEADER))
            found = header.pop("kind")
            arrays = {
                name.removesuffix(".npy"): _array(archive, name)
                for name in archive.namelist()
                if name != _HEADER
            }
    except Exception as error:  # whatever a damaged archive makes its readers raise
        raise DamagedFile(f"{path}: this is no readable {kind} file ({error})") from error
    if found != kind:
        raise DamagedFile(f"{path}: this is a {found} file, expected a {kind} file")
    return header, arrays


def _member(name: str) -> zipfile.ZipInfo:
    """An archive member without the time of writing, which would differ from run to run."""
    info = zipfile.ZipInfo(name)
    info.compress_type = zipfile.ZIP_DEFLATED
    return info


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    with archive.open(name) as member:
        array: NDArray[Any] = read_array(member, allow_pickle=False)
        return array
