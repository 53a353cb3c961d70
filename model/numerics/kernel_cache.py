"""A machine-code cache that notices a change in any source that a kernel was compiled from.

Numba caches the machine code of a kernel together with that of every kernel it calls, and takes it for
fresh while the kernel's own file is unchanged. Here it is fresh while `sources_digest` is unchanged, which
covers the called kernels in other files, imported constants and named tuples, the compiler's options
and numba's version. Entries of older sources are overwritten, so the cache does not grow.

A kernel that several processes need at once, as those of a demo after installation, is compiled by the first
of them, the others wait for its entry.
"""

from __future__ import annotations

import hashlib
import linecache
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from pickle import UnpicklingError
from typing import Any, TextIO, get_type_hints

import numba
import numpy as np
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher

if sys.platform != "win32":
    import fcntl

_LONGEST_COMPILATION = 60.0  # s; then another process has been stopped, or failed to compile it
_GLANCE = 0.02  # s between two looks at whether another process has finished


class KernelCacheFile(IndexDataCacheFile):
    """Numba's cache file, where an entry that cannot be read counts as missing.

    Its index names the classes in the kernel's signatures by module; after a module was renamed it cannot
    be unpickled.
    """

    def _load_index(self) -> dict[Any, str]:
        try:
            found: dict[Any, str] = super()._load_index()  # type: ignore[no-untyped-call]
        except (ImportError, AttributeError, EOFError, UnpicklingError):
            return {}
        return found


class KernelCache(FunctionCache):
    """Numba's cache of one function, in numba's own place, with another criterion of freshness.

    Attributes:
        digest: SHA-256 over the sources that the function was compiled from.
    """

    def __init__(self, function: Callable[..., Any], decorator: Callable[..., Any]) -> None:
        """Cache this function, compiled by this decorator."""
        super().__init__(function)  # type: ignore[no-untyped-call]
        self.digest = sources_digest(function, decorator)
        self._cache_file = KernelCacheFile(  # type: ignore[no-untyped-call]
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self.digest,
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
        return found

    def save_overload(self, signature: Any, data: Any) -> None:
        """Save the machine code of a signature."""
        try:
            super().save_overload(signature, data)  # type: ignore[no-untyped-call]
        finally:
            self._end()

    def _begin(self) -> bool:
        """Wait until no other process compiles this function; False where that cannot be found out."""
        if sys.platform == "win32" or self._lock is not None:
            return False
        try:
            self._impl.locator.ensure_cache_path()
            file = Path(self._cache_path, f"{self._impl.filename_base}.lock").open("a")  # noqa: SIM115, closed in _end
        except OSError:  # a folder without permission: nothing is cached there
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
