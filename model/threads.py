"""Linear algebra on one thread, for problems too small for several.

Beside other work, several threads that wait for each other take many times as long as one. Sparse
factorisations have a number of threads of their own (`tauten.model.numerics.make_factorisation`); this is
about the dense algebra of NumPy and SciPy.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # enumerations of `signal` take 12 µs a call
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from types import FrameType
from typing import Any, ParamSpec, TypeVar

import scipy.linalg  # noqa: F401  (loads the library that SciPy and compiled kernels call)
from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class _Library:
    """A library that computes on several threads, whose number is read and set."""

    get: Callable[[], int]
    set: Callable[[int], None]


Numbers = list[tuple[_Library, int]]  # libraries, and how many threads each had
NAMES = "openblas_{}_num_threads", "openblas_{}_num_threads64_", "openblas_{}_num_threads_64"


class _Libraries:
    """The libraries of the process that compute on several threads.

    Those of OpenBLAS have one number for the whole process: it is 1 while any thread of Python wants that.
    Others have one for each thread of Python. Looking for libraries takes 0.7 ms, setting numbers some µs.
    """

    def __init__(self) -> None:
        self._lock, self._inside, self._modules = threading.Lock(), 0, 0
        self._shared: list[_Library] = []
        self._own: list[_Library] = []
        self._before: Numbers = []

    def enter(self) -> Numbers:
        """One thread from here on; returns what `leave` needs."""
        with self._lock:
            imported = len(sys.modules)
            if imported != self._modules:  # libraries may have come since the last time
                found = ThreadpoolController().lib_controllers
                self._shared = [_openblas(one) for one in found if one.internal_api == "openblas"]
                self._own = [
                    _Library(one.get_num_threads, one.set_num_threads)
                    for one in found
                    if one.internal_api != "openblas"
                ]
            if imported != self._modules or self._inside == 0:
                self._before += _limited(self._shared)
            self._modules, self._inside = imported, self._inside + 1
            return _limited(self._own)

    def leave(self, own: Numbers) -> None:
        """As before; shared libraries once all that entered have left."""
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                _restore(self._before)
                self._before = []
            _restore(own)


def _openblas(library: Any) -> _Library:
    """A library of OpenBLAS, asked and told directly, which takes a tenth of the time.

    threadpoolctl looks its functions up in every call, and lets one thread of Python set numbers from 3.8 on;
    here they take turns.
    """
    for prefix in ("", "scipy_"):
        for name in NAMES:
            ask = getattr(library.dynlib, prefix + name.format("get"), None)
            tell = getattr(library.dynlib, prefix + name.format("set"), None)
            if ask is not None and tell is not None:
                return _Library(ask, tell)

    def told(number: int) -> None:
        if hasattr(library, "clear_controlling_thread"):
            library.clear_controlling_thread(force=True)
        library.set_num_threads(number)

    return _Library(library.get_num_threads, told)


def _limited(libraries: list[_Library]) -> Numbers:
    """Set the libraries to one thread; returns those that had more."""
    many = []
    for library in libraries:
        threads = library.get()
        if threads and threads > 1:
            library.set(1)
            many.append((library, threads))
    return many


def _restore(numbers: Numbers) -> None:
    """Set libraries to these numbers of threads."""
    for library, threads in numbers:
        library.set(threads)


_LIBRARIES = _Libraries()  # the numbers of threads belong to the process, so this does too


class _Entered(threading.local):
    """How often this thread of Python has entered, under which number of modules, and if in a whole call.

    `interrupted` says whether a Ctrl-C waits for the end of that call.
    """

    times = 0
    modules = 0
    whole = False
    interrupted = False


_ENTERED = _Entered()


class OneBlasThread:
    """Dense linear algebra on one thread, whatever has been imported in which order.

    Also a decorator. It may be entered again inside, and by several threads of Python: the numbers from
    before return when the last one leaves.
    """

    def __init__(self, whole: bool = False) -> None:
        self._before: list[Numbers] = []
        self._whole = whole

    def __enter__(self) -> None:
        self._before.append(_LIBRARIES.enter())
        _ENTERED.times, _ENTERED.modules = _ENTERED.times + 1, len(sys.modules)

    def __exit__(self, *_: object) -> None:
        _ENTERED.times -= 1
        _LIBRARIES.leave(self._before.pop())

    def __call__(self, function: Callable[P, R]) -> Callable[P, R]:
        """The function on one thread; inside another one of this thread of Python nothing is to be done."""

        @wraps(function)
        def limited(*args: P.args, **kwargs: P.kwargs) -> R:
            called = whole if self._whole and not _ENTERED.whole else function
            if _ENTERED.times > 0 and _ENTERED.modules == len(sys.modules):
                return called(*args, **kwargs)
            with OneBlasThread():
                return called(*args, **kwargs)

        def whole(*args: P.args, **kwargs: P.kwargs) -> R:
            """The function, and after it the exception of a Ctrl-C that came in it."""
            usual = _signal.default_int_handler

            def later(number: int, frame: FrameType | None) -> None:
                if _ENTERED.interrupted:
                    usual(number, frame)
                _ENTERED.interrupted = True

            handled = _signal.getsignal(_signal.SIGINT) is usual
            try:
                handled = handled and _signal.signal(_signal.SIGINT, later) is usual
            except ValueError:  # not the main thread, in which no signal is handled
                handled = False
            _ENTERED.whole = True
            try:
                return function(*args, **kwargs)
            finally:
                _ENTERED.whole = False
                if handled:
                    _signal.signal(_signal.SIGINT, usual)
                if _ENTERED.interrupted:
                    raise_interrupt()

        return limited


def raise_interrupt() -> None:
    """Raise the exception of a Ctrl-C that waits: for long calls, between two of their steps."""
    if _ENTERED.interrupted:
        _ENTERED.interrupted = False
        raise KeyboardInterrupt


def one_blas_thread(whole: bool = False) -> OneBlasThread:
    """A context and decorator, see `OneBlasThread`.

    In a call of what is decorated with `whole` Ctrl-C waits for the end of the outermost of such calls, or
    for a `raise_interrupt` in it; a second one does not. Where its exception is raised while numba makes the
    result of a kernel, the process ends with a violation of its memory.
    """
    return OneBlasThread(whole)
