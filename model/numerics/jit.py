"""The one numba decorator of the project: cached machine code, GIL released."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")

# Sums may be reordered and fused, which doubles the speed of small loops; NaN and infinity keep
# their meaning, because a blown-up state must be noticed.
REORDER = {"reassoc", "contract", "arcp", "nsz"}


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a hot loop: machine code cached on disk, GIL released beside I/O."""
    # a check for divisions by zero would keep a loop from becoming vector instructions
    compile_ = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=REORDER)
    compiled: Callable[P, R] = compile_(function)
    return compiled
