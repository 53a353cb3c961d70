"""Problems recorded from robots: solved exactly, near the optimum, never worse than staying."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.qpcc_checks import EXACT, PROBLEMS, RECORDED, assert_solves, recorded, staying, worst

from benchmarks.qpcc import (
    branch_and_bound,
    enumerate_pieces,
    load_recorded,
    save_recorded,
    scip_optimum,
)
from tauten.controller.qpcc import QpccSettings, certify, solve_qpcc

SEARCH = 0.2  # s
ALWAYS = QpccSettings(second_start="always")


def test_files_stay_small_and_hold_some_hundreds() -> None:
    assert sum(file.stat().st_size for file in PROBLEMS.glob("*.npz")) < 1.5e6
    assert sum(len(recorded(name)) for name in RECORDED) >= 300


@pytest.mark.long
@pytest.mark.parametrize("name", RECORDED)
def test_every_solution_is_exact_or_says_that_it_is_not(name: str) -> None:
    for step in recorded(name):
        problem = step.problem()
        for warm in (None, step.start):
            solution = solve_qpcc(problem, warm)
            assert solution.status.usable
            judged = certify(problem, solution.lam_a, solution.beta)
            assert max(judged.primal, judged.complementarity) <= EXACT
            if solution.status.ok:
                assert worst(solution.certificate) <= EXACT


@pytest.mark.long
@pytest.mark.parametrize("name", RECORDED)
def test_nearly_all_are_within_a_percent_of_the_best_of_three_starts(name: str) -> None:
    """Whether there is a better one that none finds: `python -m benchmarks qpcc`."""
    cold_close = warm_close = 0
    steps = recorded(name)[::3]
    for step in steps:
        problem = step.problem()
        cold, warm = solve_qpcc(problem), solve_qpcc(problem, step.start)
        both = solve_qpcc(problem, step.start, ALWAYS)
        best = min(cold.objective, warm.objective, both.objective)
        cold_close += cold.objective <= 1.01 * best
        warm_close += warm.objective <= 1.01 * best
    assert cold_close >= 0.99 * len(steps)
    assert warm_close >= 0.99 * len(steps)


def test_the_proved_optimum_is_that_of_all_pieces() -> None:
    small = [step for step in recorded("finger_5") if step.n_c <= 7][:15]
    assert len(small) >= 5
    for step in small:
        problem = step.problem()
        lowest, _ = enumerate_pieces(problem)
        found = branch_and_bound(problem, step.start, SEARCH)
        assert found.objective == pytest.approx(lowest, rel=1e-6)
        assert found.proved


@pytest.mark.long
@pytest.mark.parametrize("name", RECORDED)
def test_the_best_known_is_that_of_scip(name: str) -> None:
    few = [step for step in recorded(name) if step.n_c <= 20][5:7]
    for step in few:
        problem = step.problem()
        objective, bound = scip_optimum(problem, seconds=5.0)
        found = branch_and_bound(problem, step.start, SEARCH)
        margin = 1e-6 * problem.constant  # its tolerances are absolute, on terms of this size
        assert bound - margin <= found.objective <= objective + margin
        assert found.bound <= objective + margin


@pytest.mark.parametrize("name", RECORDED)
def test_never_worse_than_the_tensions_before(name: str) -> None:
    compared = 0
    for step in recorded(name):
        problem = step.problem()
        objective, outside = staying(problem, step.start.lam_a)
        if outside > 1e-12:
            continue
        compared += 1
        assert solve_qpcc(problem, step.start).objective <= objective * (1.0 + 1e-9)
    assert compared > 0.2 * len(recorded(name))


def test_a_file_gives_back_what_was_recorded(tmp_path: Path) -> None:
    steps = recorded("finger_5")[:5]
    file = tmp_path / "some.npz"
    save_recorded(file, steps)
    for before, after in zip(steps, load_recorded(file), strict=True):
        np.testing.assert_array_equal(before.W, after.W)
        for first, second in zip(before.problem().arrays, after.problem().arrays, strict=True):
            np.testing.assert_array_equal(first, second)
        np.testing.assert_array_equal(before.start.piece, after.start.piece)


def test_other_files_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "other.npz"
    np.savez(file, W=np.eye(2))
    with pytest.raises(ValueError, match=r"other\.npz: no recorded inverse problems, .*'target'"):
        load_recorded(file)
    with pytest.raises(OSError, match="nowhere"):
        load_recorded(tmp_path / "nowhere.npz")


def test_targets_out_of_reach_end_at_the_limits() -> None:
    """The optimum of a far target presses on some limit: else there would be a better one."""
    for name in RECORDED:
        step = recorded(name)[0]
        far = replace(step, target=step.target + 10.0)
        problem = far.problem()
        solution = solve_qpcc(problem, far.start)
        assert_solves(problem, solution)
        z = np.concatenate([solution.lam_a, solution.beta])
        rows = problem.G @ z
        slack = np.concatenate(
            [
                (solution.lam_a - problem.lb) / problem.ub,
                (problem.ub - solution.lam_a) / problem.ub,
                (rows - problem.g_lo) / (problem.g_hi - problem.g_lo),
                (problem.g_hi - rows) / (problem.g_hi - problem.g_lo),
            ]
        )
        assert slack.min() <= 1e-7
