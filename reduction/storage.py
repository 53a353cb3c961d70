"""Arrays and a JSON header in one npz file: written whole or not at all, read without pickle."""

from __future__ import annotations

import hashlib
import json
import math
import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.lib.format import read_array, read_array_header_1_0, read_magic, write_array
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from tauten.reduction.whole_writes import atomic_write

T = TypeVar("T")

_HEADER = "header.json"
_SHIPPED = "tauten.model.robots"
# Decompressed sizes that are read: forces are mostly zero and compress well, but not a thousandfold.
_SMALL = 1 << 26  # [bytes] in any case
_RATIO = 100  # times the size of the file
_LONGEST_HEADER = 1 << 20  # [bytes]
_LONGEST_REASON = 200  # characters quoted of another library's message


class DamagedFile(ValueError):
    """A file with another content than was saved; the text names the file and the fault."""


@contextmanager
def located(
    name_or_path: str | Path, suffix: str, what: str, fault: type[ValueError]
) -> Iterator[Path]:
    """The file of a path, or the file shipped for a robot of that name, while it is read.

    Messages call such files `what`. The fault is raised where it is neither, where it cannot be read, and as
    by `whole`.
    """
    path = Path(name_or_path)
    shipped = {}
    if path.suffix != suffix and not path.is_file():
        resources = [p for p in files(_SHIPPED).iterdir() if p.name.endswith(suffix)]
        shipped = {p.name.removesuffix(suffix): p for p in resources}
        if str(name_or_path) not in shipped:
            raise fault(
                f"no {what} {str(name_or_path)!r}: expected a path ending in {suffix} "
                f"or one of the shipped ones ({', '.join(sorted(shipped)) or 'none'})"
            )
    try:
        with as_file(shipped.get(str(name_or_path), path)) as file, whole(file, what, fault):
            yield file
    except OSError as error:
        raise fault(f"{path}: no {what} can be read there ({error.strerror})") from error


@contextmanager
def whole(path: str | Path, what: str, fault: type[ValueError]) -> Iterator[None]:
    """While a file is read: where its content is not what was saved, a fault names file and reason."""
    try:
        yield
    except DamagedFile as error:
        raise fault(str(error)) from error
    except (KeyError, TypeError, ValueError) as error:
        raise fault(f"{path}: this {what} file is damaged ({error})") from error


def named(path: str | Path, suffix: str, what: str, fault: type[ValueError]) -> Path:
    """The path of a new file, whose name ends as it must, or the fault; messages call such files `what`."""
    path = Path(path)
    if path.suffix != suffix:
        raise fault(f"{path}: a {what} file ends in {suffix}")
    return path


def write(
    path: Path, kind: str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> None:
    """Save atomically: after an interruption, also a killed process, there is the old file or the new one.

    The same content gives the same bytes; `unzip -p FILE header.json` shows the header. The header gets an
    entry `digest`, the SHA-256 of the other entries and the arrays.

    Args:
        path: file to write; its folder is made when missing.
        kind: kind of file, checked by `read`.
        header: goes into JSON.
        arrays: name to array, any shapes and units.
    """
    arrays = {name: np.asanyarray(array) for name, array in arrays.items()}
    entries = json.loads(json.dumps({"kind": kind, **header}))
    entries["digest"] = _digest(entries, arrays)
    text = json.dumps(entries, indent=1, ensure_ascii=False)
    try:
        with (
            atomic_write(path) as file,
            zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive,
        ):
            archive.writestr(_member(_HEADER), text)
            for name, array in arrays.items():
                with archive.open(_member(f"{name}.npy"), "w", force_zip64=True) as member:
                    write_array(member, array, allow_pickle=False)
    except ValueError as error:  # zipfile's, where Ctrl-C comes while it opens or closes a member
        if isinstance(error.__context__, KeyboardInterrupt):
            raise error.__context__ from None
        raise


def read(
    path: Path, kind: str, expected: Mapping[str, str]
) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Header and arrays of a file of the given kind.

    Sizes are taken from the archive's directory and the arrays' headers and compared with each other and
    with the allowed size before anything is decompressed. The digest finds accidental changes; older
    files have none. It does not protect from an attacker, who can compute it too.

    Args:
        path: file to read.
        kind: what it has to be.
        expected: kinds of numpy data types of the arrays by name, such as {"Psi": "f", "flags": "b"}.

    Raises:
        FileNotFoundError: there is no such file.
        DamagedFile: it is cut short, altered, too large, or of another kind.
    """
    content = path.open("rb")  # outside of `try`: a missing file is not a damaged one
    try:
        with content, zipfile.ZipFile(content) as archive:
            _check_sizes(archive, os.fstat(content.fileno()).st_size)
            header = _header(archive)
            found = header.pop("kind")
            if found == kind:
                arrays = _arrays(archive, expected)
    except Exception as error:  # damaged archives raise exceptions of many types
        # some messages of zipfile quote the content of the file
        text = " ".join(str(error).split())[:_LONGEST_REASON] or type(error).__name__
        raise DamagedFile(f"{path}: this is no readable {kind} file ({text})") from error
    if found != kind:
        raise DamagedFile(f"{path}: this is a {found} file, expected a {kind} file")
    stored = header.pop("digest", None)
    if stored is not None and stored != _digest({"kind": kind, **header}, arrays):
        raise DamagedFile(
            f"{path}: this {kind} file was changed after it was saved (its digest does not match)"
        )
    return header, arrays


def parsed(record: type[T], entries: object) -> T:
    """A frozen dataclass from what JSON gave, every field checked against its type.

    Raises:
        ValueError: a field is missing or of another type; names the first one.
    """
    try:
        return TypeAdapter(record).validate_python(entries)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        field = ".".join(str(part) for part in first["loc"]) or record.__name__
        raise ValueError(f"{field}: {first['msg']}") from error


def _digest(entries: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> str:
    """SHA-256 of header entries and arrays, independent of the order of their names."""
    hasher = hashlib.sha256(json.dumps(entries, sort_keys=True).encode())
    for name in sorted(arrays):
        array = arrays[name]
        hasher.update(f"{name} {array.dtype.str} {array.shape}".encode())
        hasher.update(np.ascontiguousarray(array).tobytes())
    return hasher.hexdigest()


def _member(name: str) -> zipfile.ZipInfo:
    """An archive member without the time of writing, which would differ from run to run."""
    info = zipfile.ZipInfo(name)
    info.compress_type = zipfile.ZIP_DEFLATED
    return info


def _check_sizes(archive: zipfile.ZipFile, file_size: int) -> None:
    """Refuse what would decompress to much more than such a file holds."""
    members = archive.infolist()
    size, allowed = sum(info.file_size for info in members), max(_SMALL, _RATIO * file_size)
    if size > allowed:
        raise ValueError(
            f"its {file_size} bytes decompress to {size} bytes, allowed are {allowed} bytes"
        )
    if len({info.filename for info in members}) < len(members):
        raise ValueError("two entries have the same name")


def _header(archive: zipfile.ZipFile) -> dict[str, Any]:
    if archive.getinfo(_HEADER).file_size > _LONGEST_HEADER:
        raise ValueError(f"{_HEADER} has more than {_LONGEST_HEADER} bytes")
    header = json.loads(archive.read(_HEADER))
    if not isinstance(header, dict) or not isinstance(header.get("kind"), str):
        raise ValueError(f"{_HEADER} is no object with an entry kind")
    return header


def _arrays(archive: zipfile.ZipFile, expected: Mapping[str, str]) -> dict[str, NDArray[Any]]:
    found = {name.removesuffix(".npy") for name in archive.namelist() if name != _HEADER}
    if found != set(expected):
        raise ValueError(
            f"it holds the arrays {', '.join(sorted(found)) or 'none'}, "
            f"expected {', '.join(sorted(expected))}"
        )
    return {name: _array(archive, f"{name}.npy", expected[name]) for name in expected}


def _array(archive: zipfile.ZipFile, name: str, kind: str) -> NDArray[Any]:
    """One array, after its header has been compared with its size in the archive."""
    with archive.open(name) as member:
        version = read_magic(member)
        if version != (1, 0):
            raise ValueError(f"{name} has the npy version {version}, expected (1, 0)")
        shape, _, dtype = read_array_header_1_0(member)
        if dtype.kind != kind:
            raise ValueError(f"{name} has the data type {dtype}, expected kind {kind!r}")
        size = math.prod(shape) * dtype.itemsize
        left = archive.getinfo(name).file_size - member.tell()
        if size != left or min(shape, default=0) < 0:
            raise ValueError(f"{name} has the shape {shape} of {dtype}, but {left} bytes of data")
    with archive.open(name) as member:
        array: NDArray[Any] = read_array(member, allow_pickle=False)
        member.read(1)  # the end of the data, where the checksum is compared
        return array
