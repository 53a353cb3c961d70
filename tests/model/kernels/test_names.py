"""Entries of the cache that several processes made work together."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.processes import start_script

KERNELS = """
import numpy as np

from tauten.model.numerics import kernel


@kernel
def doubled(x):
    return np.dot(2.0 * np.eye(len(x)), x)


@kernel
def total(x):
    return doubled(x).sum()
"""
CALLER = "print(total(np.ones(3)))"
CALLEE = "print(doubled(np.ones(3)))"


def run(folder: Path, *lines: str) -> list[str]:
    """Output of a program that uses these kernels, with a cache of its own."""
    (folder / "kernels_of_test.py").write_text(KERNELS)
    head = """import numpy as np
from kernels_of_test import doubled, total
from numba.core.bytecode import FunctionIdentity
"""
    (folder / "main.py").write_text(head + "\n".join(lines))
    variables = {
        "NUMBA_CACHE_DIR": str(folder / "cache"),
        "PYTHONHASHSEED": "0",  # the order of numba's options is in the names too
    }
    process = start_script(folder / "output.txt", folder / "main.py", **variables)
    assert process.process.wait(300.0) == 0, process.output.read_text()
    return process.output.read_text().splitlines()


@pytest.mark.long
def test_a_kernel_that_another_process_compiled_into_its_caller_is_called_from_python(
    tmp_path: Path,
) -> None:
    """The shipped file has callers whose callees are compiled where Python calls them first."""
    run(tmp_path, CALLEE, CALLER)
    for entry in (tmp_path / "cache").rglob("*doubled*"):
        entry.unlink()
    for _ in range(2):  # the callee is compiled anew, then both are loaded
        assert run(tmp_path, CALLER, CALLEE) == ["6.0", "[2. 2. 2.]"]


def test_a_forked_process_has_names_of_its_own(tmp_path: Path) -> None:
    """Node and plant of a demo are forks of one process, and compile at the same time."""
    found = run(
        tmp_path,
        "import os",
        "reading, writing = os.pipe()",
        "if os.fork() == 0:",
        "    os.write(writing, str(next(FunctionIdentity._unique_ids)).encode())",
        "    os._exit(0)",
        "os.wait()",
        "print(os.read(reading, 99).decode(), next(FunctionIdentity._unique_ids))",
    )
    child, parent = found[-1].split()
    assert abs(int(child) - int(parent)) > 1000
