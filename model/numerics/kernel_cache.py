"""Machine code of kernels on disk, which outlives the clone and the environment that compiled it.

Numba keeps the machine code of a kernel beside its source, together with that of every kernel it calls,
and takes it for fresh while the kernel's own file is unchanged. Here it is in one folder of the user, under
a name that contains `sources_digest`. That covers the called kernels in other files, imported constants and
named tuples, the compiler's options and numba's version; numba's index of each file holds the
processor and the types of the arguments. So another clone or a new environment compiles only what differs.

A kernel that several processes need at once, as those of a demo after installation, is compiled by the first
of them, the others wait for its entry. Where the folder is larger than a limit, the files that were not
used for the longest time are removed.
"""

from __future__ import annotations

import hashlib
import io
import linecache
import logging
import os
import pickle
import stat
import sys
import time
import uuid
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TextIO, get_type_hints

import numba
import numpy as np
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    _CacheLocator,
)
from numba.core.dispatcher import Dispatcher
from numba.misc.appdirs import user_cache_dir

if sys.platform != "win32":
    import fcntl

_LOG = logging.getLogger(__name__)
_LONGEST_COMPILATION = 60.0  # s; then another process has been stopped, or failed to compile it
_GLANCE = 0.02  # s between two looks at whether another process has finished
_LARGEST_SIZE = 500_000_000  # bytes; the kernels of one version have about 50 MB
_NEW_FILE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
_DIGEST = 32  # bytes of a SHA-256
_DAY = 86_400.0  # s; how exactly the time of the last use is known


def kernel_folder() -> Path:
    """Where machine code is kept: in NUMBA_CACHE_DIR, otherwise in the user's folder for caches."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    return Path(given or user_cache_dir(), "tauten", "kernels")  # type: ignore[no-untyped-call]


class KernelLocator(_CacheLocator):
    """Numba's description of the place where one function is cached."""

    def __init__(self, file: str) -> None:
        """Cache a function of this file."""
        self._py_file = file  # named in numba's warning of a function that cannot be cached

    def get_cache_path(self) -> str:
        """The folder of all kernels."""
        return str(kernel_folder())

    def get_source_stamp(self) -> str:
        """Nothing: the names of files contain a digest of the sources."""
        return ""

    def get_disambiguator(self) -> str:
        """Nothing: the names of files contain a digest of the sources."""
        return ""

    def ensure_cache_path(self) -> None:
        """Make the folder.

        Raises:
            OSError: it cannot be made.
        """
        make_folder(Path(self.get_cache_path()))

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> KernelLocator:
        """The place of any function."""
        del py_func
        return cls(py_file)


class KernelCode(CompileResultCacheImpl):
    """Numba's conversion of machine code into bytes, with one place for all functions."""

    _locator_classes = [KernelLocator]  # type: ignore[list-item]  # noqa: RUF012


class KernelCacheFile(IndexDataCacheFile):
    """Numba's cache file, where an entry that cannot be read or must not be read counts as missing.

    That is a file without permission, one that others can write, one that was damaged, or an index with
    classes that no longer exist: it names the classes in the kernel's signatures by module.
    """

    def _load_index(self) -> dict[Any, str]:
        try:
            file = io.BytesIO(read_checked(Path(self._index_path)))
            version = pickle.load(file)
            stamp, overloads = pickle.load(file) if version == self._version else ("", {})
        except Exception:  # damaged pickles raise exceptions of many types
            return {}
        found: dict[Any, str] = overloads if stamp == self._source_stamp else {}
        return found

    def _load_data(self, name: str) -> Any:
        try:
            return pickle.loads(read_checked(Path(self._cache_path, name)))
        except Exception as error:  # numba takes an OSError for a missing entry
            raise FileNotFoundError(f"{name} cannot be read") from error

    def _save_index(self, overloads: dict[Any, str]) -> None:
        index = (self._source_stamp, overloads)
        content = pickle.dumps(self._version) + self._dump(index)  # type: ignore[no-untyped-call]
        write_checked(Path(self._index_path), content)

    def _save_data(self, name: str, data: Any) -> None:
        content = self._dump(data)  # type: ignore[no-untyped-call]
        write_checked(Path(self._cache_path, name), content)


def read_checked(path: Path) -> bytes:
    """The content of a file of `write_checked`.

    Raises:
        OSError: it cannot be read, others can write it, or it was damaged.
    """
    with path.open("rb") as file:
        if written_by_others(os.fstat(file.fileno())) or written_by_others(path.parent.stat()):
            raise PermissionError(f"{path}: others can write it")
        content = file.read()
    content, digest = content[:-_DIGEST], content[-_DIGEST:]
    if hashlib.sha256(content).digest() != digest:
        raise OSError(f"{path}: damaged")
    return content


def write_checked(path: Path, content: bytes) -> None:
    """Write a file and the digest of its content, which only the user can write; whole or not at all.

    Raises:
        OSError: it cannot be written, or others can write its folder.
    """
    if written_by_others(path.parent.stat()):
        raise PermissionError(f"{path.parent}: others can write it")
    temporary = path.with_name(f"{path.name}.tmp.{uuid.uuid4().hex[:16]}")
    try:
        with os.fdopen(os.open(temporary, _NEW_FILE, 0o644), "wb") as file:
            file.write(content + hashlib.sha256(content).digest())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def written_by_others(found: os.stat_result) -> bool:
    """Whether another user than this one and root owns a file or folder, or can write it."""
    if sys.platform == "win32":  # folders of a user are writable by this user alone
        return False
    strange = found.st_uid not in (os.geteuid(), 0)
    return strange or bool(found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


def make_folder(folder: Path) -> None:
    """Make a folder that only the user can write.

    Raises:
        OSError: it cannot be made, or is there and others can write it.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o755, exist_ok=True)
    if written_by_others(folder.stat()):
        raise PermissionError(f"{folder}: others can write it")


class KernelCache(FunctionCache):
    """Numba's cache of one function, in `kernel_folder`, with another criterion of freshness.

    Attributes:
        digest: SHA-256 over the sources that the function was compiled from.
    """

    _impl_class = KernelCode

    def __init__(self, function: Callable[..., Any], decorator: Callable[..., Any]) -> None:
        """Cache this function, compiled by this decorator."""
        super().__init__(function)  # type: ignore[no-untyped-call]
        self.digest = sources_digest(function, decorator)
        python = f"py{sys.version_info[0]}{sys.version_info[1]}"
        name = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        self._file_name = f"{name}-{self.digest[:20]}.{python}"
        self._cache_file = KernelCacheFile(  # type: ignore[no-untyped-call]
            cache_path=self._cache_path, filename_base=self._file_name, source_stamp=self.digest
        )
        self._lock: TextIO | None = None

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """The machine code of a signature; None where this process has to compile it."""
        found = super().load_overload(signature, target_context)  # type: ignore[no-untyped-call]
        if found is None and self._begin():
            # compiled by another process in the meantime, perhaps
            found = super().load_overload(signature, target_context)  # type: ignore[no-untyped-call]
            if found is not None:
                self._end()
        if found is not None:
            _mark_used(Path(self._cache_path), self._file_name)
        return found

    def save_overload(self, signature: Any, data: Any) -> None:
        """Save the machine code of a signature, where the folder permits that."""
        try:
            super().save_overload(signature, data)  # type: ignore[no-untyped-call]
            remove_unused(kernel_folder())
        except OSError:
            _warn_of_no_cache(kernel_folder())
        finally:
            self._end()

    def _begin(self) -> bool:
        """Wait until no other process compiles this function; False where that cannot be found out."""
        if sys.platform == "win32" or self._lock is not None:
            return False
        folder = Path(self._cache_path)
        try:
            make_folder(folder)
            file = (folder / f"{self._file_name}.lock").open("a")
        except OSError:
            _warn_of_no_cache(folder)
            return False
        end = time.monotonic() + _LONGEST_COMPILATION
        while True:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                if time.monotonic() > end:
                    file.close()
                    return False
                time.sleep(_GLANCE)
            else:
                self._lock = file
                return True

    def _end(self) -> None:
        if self._lock is not None:
            self._lock.close()
            self._lock = None


@cache
def _warn_of_no_cache(folder: Path) -> None:
    """Log, once in a process, that machine code cannot be kept."""
    try:
        others = written_by_others(folder.stat())
    except OSError:
        others = False
    _LOG.warning(
        "compiled kernels cannot be kept in %s%s, so that every start compiles them again: "
        "%sset NUMBA_CACHE_DIR to a folder that %s",
        folder,
        ", which other users can write" if others else "",
        f"chmod -R go-w {folder}, or " if others else "",
        "this user alone can write" if others else "can be written",
    )


def _mark_used(folder: Path, name: str) -> None:
    """Set the times of a kernel's files to now, at most once in a day."""
    index = folder / f"{name}.nbi"
    try:
        if time.time() - index.stat().st_mtime > _DAY:
            for file in folder.glob(f"{name}.*"):
                os.utime(file)
    except OSError:  # a folder without permission, or removed by another process
        return


@cache
def remove_unused(folder: Path, largest: int = _LARGEST_SIZE) -> None:
    """Remove the files that were used least recently where all have more bytes than this; once in a process.

    Any of them may be removed at any time: what is missing is compiled again.
    """
    files = []
    for entry in os.scandir(folder):
        try:
            found = entry.stat()
        except FileNotFoundError:  # removed by another process
            continue
        files.append((found.st_mtime, found.st_size, Path(entry.path)))
    size = sum(number for _, number, _ in files)
    if size <= largest:
        return
    for _, number, file in sorted(files):
        file.unlink(missing_ok=True)
        size -= number
        if size <= largest // 2:
            return


def sources_digest(function: Callable[..., Any], decorator: Callable[..., Any]) -> str:
    """SHA-256 over a function's own file and all that its module imports for kernels.

    Those are other kernels (by their modules' names and their own digests), named tuples (names and types
    of their fields) and constants, which numba compiles into the code. It
    has to be called where the function is defined: what its module defines later is part of its own file.

    Args:
        function: the function to compile.
        decorator: what compiles it; its file holds the compiler's options.
    """
    names: dict[str, Any] = function.__globals__
    hasher = hashlib.sha256(numba.__version__.encode())
    hasher.update(_source(decorator) + _source(function))
    for name in sorted(names):
        if not name.startswith("__"):
            hasher.update(f"{name} {_fingerprint(names[name], names['__name__'])}\n".encode())
    return hasher.hexdigest()


def _source(function: Callable[..., Any]) -> bytes:
    """The text of the file that defines a function, also from inside a zip archive."""
    lines = linecache.getlines(function.__code__.co_filename, function.__globals__)
    return "".join(lines).encode()


def _fingerprint(value: object, module: str) -> str:
    """What compiled code takes over from a global value; empty for what it cannot contain."""
    if isinstance(value, Dispatcher):
        known, function = getattr(value, "_cache", None), value.py_func
        source = known.digest if isinstance(known, KernelCache) else function.__code__.co_code
        # cached code refers to the kernels it calls by the names of their modules
        return f"{function.__module__}.{function.__qualname__} {source!r}"
    if isinstance(value, type):
        return _layout(value) if hasattr(value, "_fields") and value.__module__ != module else ""
    if isinstance(value, np.ndarray | np.generic):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, tuple):
        return f"({', '.join(_fingerprint(entry, module) for entry in value)})"
    return repr(value) if isinstance(value, bool | int | float | complex | str | bytes) else ""


@cache
def _layout(tuple_type: type) -> str:
    """Fields of a named tuple with their types, in order."""
    fields = get_type_hints(tuple_type).items()
    parts = (f"{name}: {_layout(t) if hasattr(t, '_fields') else t}" for name, t in fields)
    return f"{tuple_type.__name__}({', '.join(parts)})"
