"""Names of compiled functions, different in all processes.

Numba numbers the functions that a process compiles, 1, 2, ..., and these numbers are in the names of what
their machine code refers to. An entry of a kernel's cache contains the names of the kernels that it calls.
Where entries of two processes have a name in common, numba takes the Python objects of the first for those of
the second: that one fails when Python calls it, or the arrays that it returns have a wrong type.
"""

from __future__ import annotations

import itertools
import os
from typing import Any

from numba.core.bytecode import FunctionIdentity

NUMBERING = "by process"  # of functions; entries with other names are not used together with these
_BYTES = 6  # of the first number, which is random

identity: Any = FunctionIdentity


def names_of_this_process() -> None:
    """Let numba begin at a number of this process; children of a fork get their own."""
    identity._unique_ids = itertools.count(int.from_bytes(os.urandom(_BYTES), "little"))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=names_of_this_process)
