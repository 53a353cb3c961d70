"""Compiled kernels that are shipped with tauten: one compressed file for each Python, numba and system.

The file is unpacked once, into a folder beside the user's own kernels. A kernel whose sources have changed is
not found there, because names contain digests, and is compiled. `python -m benchmarks pack-kernels` makes
the file.
"""

from __future__ import annotations

import hashlib
import io
import logging
import os
import platform
import shutil
import sys
import tarfile
import time
import uuid
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numba

from tauten.model.kernels.files import cache_folder, checked, read_checked, written_by_others

SEED = "TAUTEN_KERNEL_SEED"  # a file to use instead of the shipped one, or "off"
OFF = "off"
SUFFIX = ".tar.xz"
SHIPPED = Path(__file__).with_name("shipped")
_LOG = logging.getLogger(__name__)
_UNUSED = 30 * 86_400.0  # s; an older unpacked seed is removed when a new one is unpacked
_MODE = 0o644


@dataclass(frozen=True, slots=True)
class Seed:
    """Files with machine code, only to be read: in a folder, or in memory by their names."""

    folder: Path | None
    contents: Mapping[str, bytes]

    def read(self, name: str) -> bytes:
        """The content of a file.

        Raises:
            OSError: there is no such file, others can write it, or it was damaged.
        """
        if self.folder is not None:
            return read_checked(self.folder / name)
        if name not in self.contents:
            raise FileNotFoundError(name)
        return checked(self.contents[name], name)

    def names(self) -> set[str]:
        """Names of all files."""
        if self.folder is not None:
            return {path.name for path in self.folder.iterdir()}
        return set(self.contents)


def seed_name() -> str:
    """Name of the file for this Python, this numba and this system."""
    python = f"py{sys.version_info[0]}{sys.version_info[1]}"
    system, machine = platform.system().lower(), platform.machine().lower()
    return f"{python}-numba{numba.__version__}-{system}-{machine}{SUFFIX}"


def seed_file() -> Path | None:
    """The file with the kernels for this Python, numba and system; None where none is wanted."""
    given = os.environ.get(SEED)
    if given == OFF:
        return None
    return Path(given) if given else SHIPPED / seed_name()


def open_seed() -> Seed | None:
    """The kernels that are shipped for this Python, numba and system; None where there are none.

    A file that cannot be read or unpacked is left out, with one sentence in the log.
    """
    return _open(seed_file(), cache_folder())


@cache
def _open(file: Path | None, parent: Path) -> Seed | None:
    if file is None or not file.is_file():
        return None
    try:
        return unpacked(file.read_bytes(), parent)
    except (OSError, ValueError) as error:
        _LOG.warning("%s is not used, its kernels are compiled instead: %s", file, error)
        return None


def unpacked(archive: bytes, parent: Path) -> Seed:
    """The files of an archive, in a folder below this one where that can be written, otherwise in memory.

    Raises:
        ValueError: it is no such archive.
    """
    folder = parent / f"seed-{hashlib.sha256(archive).hexdigest()[:16]}"
    if folder.is_dir() and not written_by_others(folder.stat()):
        return Seed(folder, {})
    contents = unpack(archive)
    try:
        _write_folder(folder, contents)
    except OSError:
        return Seed(None, contents)
    return Seed(folder, {})


def _write_folder(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write files into a new folder: whole or not at all, also where several processes do so at once.

    Raises:
        OSError: it cannot be written, or others can write it.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    _remove_unused_seeds(folder.parent)
    temporary = folder.with_name(f"{folder.name}.tmp.{uuid.uuid4().hex[:16]}")
    temporary.mkdir(mode=0o755)
    try:
        for name, content in contents.items():
            path = temporary / name
            path.write_bytes(content)
            path.chmod(_MODE)
        if not folder.is_dir():  # otherwise another process was faster
            temporary.rename(folder)
    except OSError:
        if not folder.is_dir():
            raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    if written_by_others(folder.stat()):
        raise PermissionError(f"{folder}: others can write it")


def _remove_unused_seeds(parent: Path) -> None:
    """Remove what was unpacked long ago; what is still needed is unpacked again."""
    for path in parent.glob("seed-*"):
        try:
            old = time.time() - path.stat().st_mtime > _UNUSED
        except OSError:  # removed by another process
            continue
        if old:
            shutil.rmtree(path, ignore_errors=True)


def pack(files: Iterable[tuple[str, bytes]]) -> bytes:
    """An archive of files with these names and contents; equal files give equal archives."""
    import lzma  # some builds of Python lack it

    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.GNU_FORMAT) as archive:
        for name, content in sorted(files):
            entry = tarfile.TarInfo(name)
            entry.size, entry.mode = len(content), _MODE
            archive.addfile(entry, io.BytesIO(content))
    return lzma.compress(buffer.getvalue(), preset=9 | lzma.PRESET_EXTREME)


def unpack(archive: bytes) -> dict[str, bytes]:
    """Names and contents of the files of `pack`.

    Raises:
        ValueError: it is no such archive, or this Python cannot unpack it.
    """
    try:
        import lzma

        found: dict[str, bytes] = {}
        with tarfile.open(fileobj=io.BytesIO(lzma.decompress(archive)), mode="r:") as tar:
            for entry in tar:
                content = tar.extractfile(entry) if entry.isreg() else None
                if content is None or Path(entry.name).name != entry.name:
                    raise ValueError(f"{entry.name!r} is no file of kernels")
                found[entry.name] = content.read()
    except ImportError as error:
        raise ValueError("this Python was built without lzma") from error
    except (lzma.LZMAError, tarfile.TarError, EOFError) as error:
        raise ValueError(f"damaged ({error})") from error
    return found
