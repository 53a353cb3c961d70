"""The one numba decorator of the project: cached machine code, GIL released."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, ParamSpec, TypeVar, cast

import numba
from numba.core.dispatcher import Dispatcher

from tauten.model.kernels import KernelCache, names_of_this_process, portable_code

P = ParamSpec("P")
R = TypeVar("R")

# Sums may be reordered and fused, which doubles the speed of small loops; NaN and infinity keep
# their meaning, because a state that diverges must be noticed.
REORDER = {"reassoc", "contract", "arcp", "nsz"}
# A check for divisions by zero would keep a loop from becoming vector instructions.
DIVISIONS: Final = "numpy"
OPTIONS = f"{sorted(REORDER)} {DIVISIONS}"  # what of the options changes machine code

portable_code()  # before the first decorator makes numba's compiler
names_of_this_process()


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a hot loop: GIL released, machine code cached on disk (see `KernelCache`)."""
    compile_ = numba.njit(nogil=True, error_model=DIVISIONS, fastmath=REORDER)
    compiled: Any = compile_(function)
    is_compiled = isinstance(compiled, Dispatcher)  # NUMBA_DISABLE_JIT=1 returns the function
    if is_compiled:
        compiled._cache = KernelCache(function, OPTIONS)
    return cast("Callable[P, R]", compiled)
