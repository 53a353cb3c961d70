"""Machine code of kernels on disk, which outlives the clone and the environment that compiled it.

Numba keeps the machine code of a kernel beside its source, together with that of every kernel it calls,
and takes it for fresh while the kernel's own file is unchanged. Here it is in one folder of the user, under
a name that contains `sources_digest`; numba's index of each file holds the processor and the types of the
arguments. So another clone or a new environment compiles only what differs. What is shipped with tauten
(`tauten.model.kernels.seed`) is looked up first.

A kernel that several processes need at once, as those of a demo after installation, is compiled by the first
of them, the others wait for its entry. Where the folder is larger than a limit, the files that were not
used for the longest time are removed.
"""

from __future__ import annotations

import io
import logging
import os
import pickle
import sys
import time
from collections.abc import Callable
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TextIO

from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    _CacheLocator,
)

from tauten.model.kernels.files import (
    kernel_folder,
    make_folder,
    read_checked,
    write_checked,
    written_by_others,
)
from tauten.model.kernels.linking import rebuilt
from tauten.model.kernels.seed import Seed, open_seed
from tauten.model.kernels.sources import callees, full_name, layouts, sources_digest
from tauten.model.kernels.target import compiled_machine, portable_machine

if sys.platform != "win32":
    import fcntl

_LOG = logging.getLogger(__name__)
_LONGEST_COMPILATION = 60.0  # s; then another process has been stopped, or failed to compile it
_GLANCE = 0.02  # s between two looks at whether another process has finished
_LARGEST_SIZE = 500_000_000  # bytes; the kernels of one version have about 50 MB
_DAY = 86_400.0  # s; how exactly the time of the last use is known


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

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """The compiled kernel of bytes, also of those without what callers need (`without_ir`)."""
        return rebuilt(super().rebuild, target_context, payload)


class KernelCacheFile(IndexDataCacheFile):
    """Numba's cache file, where an entry that cannot be read or must not be read counts as missing.

    That is a file without permission, one that others can write, one that was damaged, or an index with
    classes that no longer exist: it names the classes in the kernel's signatures by module.
    """

    def entries(self) -> dict[Any, str]:
        """Name of the file of each entry: types of the arguments, machine, Python's code, layouts."""
        return self._load_index()

    def _load_index(self) -> dict[Any, str]:
        try:
            file = io.BytesIO(self._read(self._index_name))
            version = pickle.load(file)
            stamp, overloads = pickle.load(file) if version == self._version else ("", {})
        except Exception:  # damaged pickles raise exceptions of many types
            return {}
        found: dict[Any, str] = overloads if stamp == self._source_stamp else {}
        return found

    def entry(self, name: str) -> Any:
        """The content of the file of an entry, which does not count as its use.

        Raises:
            FileNotFoundError: it cannot be read.
        """
        try:
            return pickle.loads(self._read(name))
        except Exception as error:  # damaged pickles raise exceptions of many types
            raise FileNotFoundError(f"{name} cannot be read") from error

    def _load_data(self, name: str) -> Any:
        found = self.entry(name)  # numba takes an OSError for a missing entry
        for used in (name, self._index_name):
            _mark_used(Path(self._cache_path, used))
        return found

    def _read(self, name: str) -> bytes:
        """The content of a file.

        Raises:
            OSError: it cannot be read, must not be read, or was damaged.
        """
        return read_checked(Path(self._cache_path, name))

    def _save_index(self, overloads: dict[Any, str]) -> None:
        index = (self._source_stamp, overloads)
        content = pickle.dumps(self._version) + self._dump(index)  # type: ignore[no-untyped-call]
        write_checked(Path(self._index_path), content)

    def _save_data(self, name: str, data: Any) -> None:
        content = self._dump(data)  # type: ignore[no-untyped-call]
        write_checked(Path(self._cache_path, name), content)


class SeedFile(KernelCacheFile):
    """The entries of one function in a seed."""

    def __init__(self, seed: Seed, file_name: str, digest: str) -> None:
        """The entries of the function whose files are called so, compiled from sources with this digest."""
        super().__init__("", file_name, digest)  # type: ignore[no-untyped-call]
        self._seed = seed

    def _read(self, name: str) -> bytes:
        return self._seed.read(name)


class KernelCache(FunctionCache):
    """Numba's cache of one function, in `kernel_folder`, with another criterion of freshness."""

    _impl_class = KernelCode

    def __init__(self, function: Callable[..., Any], options: str) -> None:
        """Cache this function, compiled with these options."""
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._options = options
        self._lock: TextIO | None = None
        self._opened = False

    @cached_property
    def digest(self) -> str:
        """SHA-256 over the sources that the function is compiled from."""
        return sources_digest(self._py_func, self._options)

    @property
    def name(self) -> str:
        """Of the function, with its module."""
        return full_name(self._py_func)

    @property
    def callees(self) -> frozenset[str]:
        """Names of the functions that are compiled into it."""
        return callees(self._py_func)

    @cached_property
    def file_name(self) -> str:
        """How the names of this function's files begin."""
        python = f"py{sys.version_info[0]}{sys.version_info[1]}"
        function = self._py_func
        name = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        return f"{name}-{self.digest[:20]}.{python}"

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """The machine code of a signature; None where this process has to compile it."""
        self._open()
        found = self._load_shipped(signature, target_context)
        if found is None:
            found = super().load_overload(signature, target_context)  # type: ignore[no-untyped-call]
        if found is None and self._begin():
            # compiled by another process in the meantime, perhaps
            found = super().load_overload(signature, target_context)  # type: ignore[no-untyped-call]
            if found is not None:
                self._end()
        return found

    def save_overload(self, signature: Any, data: Any) -> None:
        """Save the machine code of a signature, where the folder permits that."""
        try:
            self._open()
            super().save_overload(signature, data)  # type: ignore[no-untyped-call]
            remove_unused(kernel_folder())
        except OSError:
            _warn_of_no_cache(kernel_folder())
        finally:
            self._end()

    def _open(self) -> None:
        """Find the files, when all that the function uses is defined."""
        if not self._opened:
            self._cache_file = self.file_in(Path(self._cache_path))
            self._opened = True

    def file_in(self, folder: Path) -> KernelCacheFile:
        """The entries of this function in a folder."""
        return KernelCacheFile(str(folder), self.file_name, self.digest)  # type: ignore[no-untyped-call]

    def _load_shipped(self, signature: Any, target_context: Any) -> Any:
        """The machine code of a signature from the seed; None where that does not have it."""
        machine, seed = portable_machine(), open_seed()
        if machine is None or seed is None:
            return None
        target_context.refresh()
        types, _, *code = self._index_key(signature, target_context.codegen())
        file = SeedFile(seed, self.file_name, self.digest)
        data = file.load((types, machine, *code))  # type: ignore[no-untyped-call]
        return None if data is None else self._impl.rebuild(target_context, data)

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        """Types of the arguments, machine, Python's code, and the fields of named tuples.

        Numba takes named tuples with one name for equal.
        """
        types, _, *code = super()._index_key(sig, codegen)  # type: ignore[no-untyped-call]
        return (types, compiled_machine(), *code, layouts(sig))

    def _begin(self) -> bool:
        """Wait until no other process compiles this function; False where that cannot be found out."""
        if sys.platform == "win32" or self._lock is not None:
            return False
        folder = Path(self._cache_path)
        try:
            make_folder(folder)
            file = (folder / f"{self.file_name}.lock").open("a")
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


def _mark_used(file: Path) -> None:
    """Set the time of a file to now, at most once in a day."""
    try:
        if time.time() - file.stat().st_mtime > _DAY:
            os.utime(file)
    except OSError:  # in a seed, in a folder without permission, or removed by another process
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
