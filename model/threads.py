"""Linear algebra on one thread, for problems too small for several.

Beside other work, several threads that wait for each other take many times as long as one. Sparse
factorisations have a number of threads of their own (`tauten.model.numerics.make_factorisation`); this is
about the dense algebra of NumPy and SciPy.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import scipy.linalg  # noqa: F401  (loads the library that SciPy and compiled kernels call)
from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")
Numbers = list[tuple[Any, int]]  # libraries, and how many threads each had


class _Libraries:
    """The libraries of the process that compute on several threads.

    Those of OpenBLAS have one number for the whole process: it is 1 while any thread of Python wants that.
    Others have one for each thread of Python. Looking for libraries takes 0.7 ms, setting numbers some µs.
    """

    def __init__(self) -> None:
        self._lock, self._inside, self._modules = threading.Lock(), 0, 0
        self._shared: list[Any] = []
        self._own: list[Any] = []
        self._before: Numbers = []

    def enter(self) -> Numbers:
        """One thread from here on; returns what `leave` needs."""
        with self._lock:
            imported = len(sys.modules)
            if imported != self._modules:  # libraries may have come since the last time
                found = ThreadpoolController().lib_controllers
                self._shared = [item for item in found if item.internal_api == "openblas"]
                self._own = [item for item in found if item.internal_api != "openblas"]
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


def _limited(libraries: list[Any]) -> Numbers:
    """Set the libraries to one thread; returns those that had more."""
    numbers = [(library, library.get_num_threads()) for library in libraries]
    many = [(library, threads) for library, threads in numbers if threads and threads > 1]
    _restore([(library, 1) for library, _ in many])
    return many


def _restore(numbers: Numbers) -> None:
    """Set libraries to these numbers of threads."""
    for library, threads in numbers:
        # threadpoolctl lets one thread of Python set them from 3.8 on; here they take turns
        if hasattr(library, "clear_controlling_thread"):
            library.clear_controlling_thread(force=True)
        library.set_num_threads(threads)


_LIBRARIES = _Libraries()  # the numbers of threads belong to the process, so this does too


class _Entered(threading.local):
    """How often this thread of Python has entered, and under which number of modules."""

    times = 0
    modules = 0


_ENTERED = _Entered()


class OneBlasThread:
    """Dense linear algebra on one thread, whatever has been imported in which order.

    Also a decorator. It may be entered again inside, and by several threads of Python: the numbers from
    before return when the last one leaves.
    """

    def __init__(self) -> None:
        self._before: list[Numbers] = []

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
            if _ENTERED.times > 0 and _ENTERED.modules == len(sys.modules):
                return function(*args, **kwargs)
            with OneBlasThread():
                return function(*args, **kwargs)

        return limited


def one_blas_thread() -> OneBlasThread:
    """A context and decorator, see `OneBlasThread`."""
    return OneBlasThread()
