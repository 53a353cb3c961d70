"""Nonsense of all scales: no exception, hang or NaN, and no claim that does not hold."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from support.qpcc_checks import EXACT, worst

from benchmarks.qpcc import nonsense
from tauten.controller.qpcc import (
    Qpcc,
    QpccSettings,
    Solution,
    Start,
    Status,
    available_backends,
    certify,
    solve_qpcc,
    warm_solver,
)

HANG = 5.0  # s of processor time


@pytest.fixture(scope="module", autouse=True)
def kernels() -> None:
    """Compiled before a clock runs."""
    for solver in available_backends():
        warm_solver(solver)


def check(problem: Qpcc, solution: Solution) -> None:
    assert np.isfinite(solution.lam_a).all()
    assert np.isfinite(solution.beta).all()
    assert solution.piece.shape == problem.m.shape
    if solution.status.usable:
        assert np.all((solution.lam_a >= problem.lb) & (solution.lam_a <= problem.ub))
        assert np.all(solution.beta >= 0.0)
        assert np.isfinite(solution.objective)
        assert max(solution.certificate.primal, solution.certificate.complementarity) <= EXACT
        judged = certify(problem, solution.lam_a, solution.beta)
        # unscaling and scaling again rounds twice
        assert max(judged.primal, judged.complementarity) <= 2.0 * EXACT
    if solution.status.ok:
        assert worst(solution.certificate) <= EXACT
    if solution.status is Status.INFEASIBLE:
        assert solution.conflict


def fuzz(seeds: range, settings: QpccSettings) -> dict[Status, int]:
    counts = dict.fromkeys(Status, 0)
    for seed in seeds:
        rng = np.random.default_rng(seed)
        problem = nonsense(rng)
        n_a, k = len(problem.lb), len(problem.m)
        start = Start(rng.normal(size=n_a) * 10.0 ** rng.uniform(-12, 12), rng.random(k) < 0.5)
        begin = process_time()  # not the real clock
        solution = solve_qpcc(problem, start if seed % 2 else None, settings)
        assert process_time() - begin < HANG
        try:
            check(problem, solution)
        except AssertionError as error:
            raise AssertionError(f"seed {seed}") from error
        counts[solution.status] += 1
    return counts


@pytest.mark.long
def test_three_hundred() -> None:
    counts = fuzz(range(300), QpccSettings())
    assert counts[Status.OK] > 60  # not all of it is nonsense
    assert counts[Status.INFEASIBLE] > 60
    assert counts[Status.NOT_FINITE] > 0


@pytest.mark.long
@pytest.mark.parametrize("solver", [name for name in available_backends() if name != "daqp"])
def test_sixty_with_other_back_ends(solver: str) -> None:
    fuzz(range(1000, 1060), QpccSettings(solver=solver))


def test_sixty_with_a_second_start_always() -> None:
    fuzz(range(2000, 2060), QpccSettings(second_start="always"))


@pytest.mark.slow
def test_ten_thousand() -> None:
    counts = fuzz(range(10_000, 20_000), QpccSettings())
    assert counts[Status.OK] > 2000
