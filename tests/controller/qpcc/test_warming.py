"""After warming up no decision, however rare its way, waits for a kernel."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tauten.controller.qpcc import warm_solver

ROOT = Path(__file__).resolve().parents[3]
HARSH = """
import sys
import numpy as np
from numba.core.dispatcher import Dispatcher
from tauten.controller.qpcc.problem import Start
from tauten.controller.qpcc.solve import QpccSettings, solve_qpcc
from benchmarks.qpcc.random_problems import degenerate, known_stationary
from tauten.controller.qpcc.warming import warm_solver


def loaded():
    parts = [m for name, m in sys.modules.items() if name.startswith("tauten.controller")]
    kernels = {k for part in parts for k in vars(part).values() if isinstance(k, Dispatcher)}
    functions = {k.py_func: len(k.signatures) for k in kernels}
    return {f"{f.__module__}.{f.__name__}": count for f, count in functions.items()}


def solve_many(solver):
    rng, statuses = np.random.default_rng(3), set()
    for case in range(400):
        n_a, k = int(rng.integers(1, 4)), int(rng.integers(1, 7))
        problem = degenerate(rng, n_a, k) if case % 2 else known_stationary(rng, n_a, k, 1).problem
        piece = rng.random(k) < 0.5
        start = Start(rng.uniform(0.0, 2.0, n_a), piece)
        second = ("cold", "always", "never")[case % 3]
        settings = QpccSettings(solver, max_pivots=100 if case % 5 else 1, second_start=second)
        statuses.add(solve_qpcc(problem, start, settings).status.name)
    return statuses


solver = sys.argv[1]
warm_solver(solver)
degenerate(np.random.default_rng(0), 1, 2)  # what makes the problems is no part of solving them
before = loaded()
statuses = solve_many(solver)
after = loaded()
print(sorted(statuses), [name for name in after if after[name] != before[name]])
"""


@pytest.mark.long
@pytest.mark.parametrize("solver", ["daqp", pytest.param("osqp", marks=pytest.mark.slow)])
def test_no_kernel_is_left_to_load(solver: str) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", HARSH, solver], capture_output=True, text=True, timeout=300,
        cwd=ROOT, env={**os.environ, "OMP_NUM_THREADS": "1"}, check=True,
    )  # fmt: skip
    statuses, _, late = ended.stdout.strip().partition("] ")
    assert "OK" in statuses and "INFEASIBLE" in statuses  # rare ways were gone
    assert late == "[]"


def test_unknown_solvers_are_refused() -> None:
    with pytest.raises(ValueError, match="gurbi"):
        warm_solver("gurbi")
