"""The interpreter and the libraries under a real-time loop: threads, garbage collection, versions."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version

from threadpoolctl import threadpool_limits

_PACKAGES = (
    "tauten",
    "numpy",
    "scipy",
    "numba",
    "eclipse-zenoh",
    "rosbags",
    "mcap",
    "daqp",
    "proxsuite",
    "osqp",
    "pypardiso",
    "cvxopt",
)


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Linear algebra on one thread, for problems too small to share.

    Enter it with the robot loaded and before a controller or simulator is made: the libraries must be
    there to be told, and PARDISO breaks when the number of threads changes after its analysis.
    """
    with threadpool_limits(limits=1):
        yield


@contextmanager
def short_turns() -> Iterator[None]:
    """Other threads, the recorder's and the network's, hold the interpreter for 0.1 ms at most, not for 5.

    A control step lets go of the interpreter in every kernel; whoever takes it then gives it back that soon.
    """
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


@contextmanager
def collector_at_hand() -> Iterator[None]:
    """The garbage collector under a loop's control.

    What exists at the start is taken out of the collector's sight; the loop calls `gc.collect` when
    it has time to spare.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        gc.unfreeze()


def versions() -> dict[str, str]:
    """Versions of the packages that numbers depend on, of those that are installed."""
    found = {}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
