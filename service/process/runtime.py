"""The interpreter and the libraries under a real-time loop: threads, garbage collection, versions."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

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
def short_switch_interval() -> Iterator[None]:
    """Other threads, such as the recorder's, hold the interpreter for 0.1 ms at most instead of 5 ms.

    A control step releases the interpreter in every kernel; a thread that takes it then returns it that soon.
    """
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


@contextmanager
def manual_garbage_collection() -> Iterator[None]:
    """Garbage is collected only when a loop calls `gc.collect`.

    Objects that exist at the start are left out of every collection.
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
    from tauten.reduction import package_version

    return {name: package_version(name) for name in _PACKAGES}
