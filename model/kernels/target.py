"""The processors that kernels are compiled for: all that have a common level of instructions.

Machine code of the level `x86-64-v3` (AVX2, FMA: Intel from 2013, AMD from 2015 on) runs on every such
processor, so that it can be shipped, shared between computers, and gives the same bits on all of them. It is
as fast as code for one processor. Others get code of their own.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache
from typing import Any

import llvmlite.binding as llvm
import numba.core.config
from numba.core.registry import cpu_target

config: Any = numba.core.config  # fills itself from the environment
LEVEL = "x86-64-v3"
GENERIC = "generic"  # every processor with aarch64 instructions
NEEDED = ("avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2")


@cache
def portable_level() -> str | None:
    """The level of instructions that kernels are compiled for; None where that is this processor's own.

    None also where the user chose a processor with numba's variables (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES,
    NUMBA_ENABLE_AVX); an empty NUMBA_CPU_NAME, as an image sets it that is built without, chooses none.
    """
    if config.CPU_NAME or config.CPU_FEATURES is not None or not config.ENABLE_AVX:
        return None
    try:
        return shared_level(platform.machine(), llvm.get_host_cpu_features())
    except RuntimeError:  # the library does not know this processor
        return None


def shared_level(machine: str, features: Mapping[str, bool]) -> str | None:
    """The level that a processor shares with others of its kind; None where it lacks instructions."""
    if machine.lower() in ("aarch64", "arm64"):
        return GENERIC
    complete = all(features.get(name, False) for name in NEEDED)
    return LEVEL if complete and machine.lower() in ("x86_64", "amd64") else None


def portable_code() -> None:
    """Let numba compile for the level of instructions from here on, where this processor has it.

    Numba has one compiler for a process, with the settings from when it was made: a process that compiled
    something else before keeps to its own processor.
    """
    level = portable_level()
    if level is not None:
        config.CPU_NAME, config.CPU_FEATURES = level, ""
    elif not config.CPU_NAME:
        config.CPU_NAME = None
    compiled_machine()


@cache
def compiled_machine() -> tuple[str, str, str]:
    """What this process compiles for: system, processor or level, features of the processor.

    Numba's own tuple follows its settings, which a change of NUMBA variables of the environment resets; its
    compiler stays as it was made.
    """
    triple, name, features = cpu_target.target_context.codegen().magic_tuple()
    level = portable_level()
    if level is not None:
        name = level if features == "" else llvm.get_host_cpu_name()
    return triple, name, features


def portable_machine() -> tuple[str, str, str] | None:
    """The same for portable code; None where this processor does not run it, or the user chose another."""
    level = portable_level()
    return None if level is None else (llvm.get_process_triple(), level, "")
