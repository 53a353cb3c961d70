"""What tests of the QPCC layer share: recorded problems, and what every solution must satisfy."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.qpcc import Recorded, load_recorded
from tauten.controller.qpcc import Certificate, Qpcc, Solution, certify
from tauten.model.numerics import Array, solve_lcp

PROBLEMS = Path(__file__).resolve().parents[1] / "reference" / "qpcc"
EXACT = 1e-8  # the residuals a solution may have
RECORDED = ("finger_5", "finger_20", "three_cables_5", "three_cables_20")


@cache
def recorded(name: str) -> list[Recorded]:
    """The problems of one file."""
    return load_recorded(PROBLEMS / f"{name}.npz")


def worst(certificate: Certificate) -> float:
    """The largest residual."""
    return max(certificate.primal, certificate.complementarity, certificate.stationarity)


def violation(problem: Qpcc, lam_a: Array, beta: Array) -> float:
    """Largest violation of (2) and (3), in the problem's own units and without the solver's code."""
    z = np.concatenate([lam_a, beta])
    w, rows = problem.M @ z + problem.m, problem.G @ z
    sides = [
        problem.lb - lam_a,
        lam_a - problem.ub,
        problem.g_lo - rows,
        rows - problem.g_hi,
        -beta,
        -w,
        np.minimum(np.abs(beta), np.abs(w)),
    ]
    return float(max(side.max(initial=0.0) for side in sides))


def assert_solves(problem: Qpcc, solution: Solution, strongly: bool = True) -> None:
    """OK, the solver's own certificate exact and, unless weaker is asked for, the independent one too."""
    assert solution.status.ok, solution.status
    assert worst(solution.certificate) <= EXACT
    judged = certify(problem, solution.lam_a, solution.beta)
    assert max(judged.primal, judged.complementarity) <= EXACT
    if strongly:
        assert judged.stationarity <= EXACT
    value = problem.objective(solution.lam_a, solution.beta)
    z = np.abs(np.concatenate([solution.lam_a, solution.beta]))
    terms = z @ np.abs(problem.Q) @ z + np.abs(problem.c) @ z + abs(problem.constant)
    assert abs(solution.objective - value) <= 1e-11 * terms


def staying(problem: Qpcc, lam_a: Array) -> tuple[float, float]:
    """Objective and violation at tensions lam_a (n_a,) with the contact forces they cause."""
    n_a = len(lam_a)
    contact = solve_lcp(problem.M[:, n_a:], problem.m + problem.M[:, :n_a] @ lam_a)
    assert contact.converged
    beta = contact.lam
    return problem.objective(lam_a, beta), violation(problem, lam_a, beta)
