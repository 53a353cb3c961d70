"""What kernels are compiled for: the common level of instructions, where the processor has it."""

from __future__ import annotations

import os
import subprocess
import sys

import llvmlite.binding as llvm
import pytest

from tauten.model.kernels import target

HAS = dict.fromkeys(target.NEEDED, True)
REPORT = """
{before}
from tauten.model.kernels.target import compiled_machine, portable_machine
from tauten.model.numerics import dot
print(compiled_machine()[1], portable_machine() is not None)
"""


def test_a_processor_with_all_instructions_has_the_level() -> None:
    assert target.shared_level("x86_64", HAS) == target.shared_level("AMD64", HAS) == "x86-64-v3"
    assert target.shared_level("arm64", {}) == target.shared_level("aarch64", {}) == "generic"
    assert target.shared_level("riscv64", HAS) is None


@pytest.mark.parametrize("missing", target.NEEDED)
def test_one_without_an_instruction_has_not(missing: str) -> None:
    assert target.shared_level("x86_64", HAS | {missing: False}) is None


def machine(before: str = "", **variables: str) -> list[str]:
    """What a process compiles for, and whether portable code runs in it."""
    environment = {**os.environ, **variables}
    command = [sys.executable, "-c", REPORT.format(before=before)]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return found.stdout.split()


@pytest.mark.long
@pytest.mark.skipif(target.portable_level() is None, reason="this processor has no such level")
def test_processes_compile_for_the_level() -> None:
    level = target.portable_level()
    host = llvm.get_host_cpu_name()
    assert machine(NUMBA_CPU_NAME=host) == [host, "False"], "the user's choice"
    assert machine(NUMBA_CPU_NAME="") == [level, "True"], "the image of docker/Dockerfile"
    first = "import numba\nnumba.njit(lambda x: x)(1.0)"
    assert machine(first) == [host, "True"], "numba's compiler was made before"
    changed = "import tauten.model.numerics, os\nos.environ['NUMBA_OPT'] = '3'"
    assert machine(f"{changed}\n{first}") == [level, "True"], "its settings were read again"


@pytest.mark.slow
@pytest.mark.skipif(target.portable_level() is None, reason="this processor has no such level")
def test_features_that_the_user_chooses_are_for_this_processor() -> None:
    assert machine() == [target.portable_level(), "True"]
    assert machine(NUMBA_CPU_FEATURES="+sse2") == [llvm.get_host_cpu_name(), "False"]
