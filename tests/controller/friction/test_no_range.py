"""Efforts whose least and largest value are the same, beside contacts with friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tauten.controller.friction import FrictionInverse, FrictionSettings, solve_friction_inverse
from tauten.controller.qpcc import Qpcc

FIXED = 1  # number of the effort that has no range


def robot(seed: int, most: float, limit: float) -> FrictionInverse:
    """Three effectors, three efforts and five contacts with friction, on fourteen unknowns.

    Args:
        seed: of a generator.
        most: largest of the efforts; but for one that remains zero.
        limit: of the positions of the others.
    """
    rng = np.random.default_rng(seed)
    G_e, G, error = rng.normal(size=(3, 14)), rng.normal(size=(18, 14)), rng.normal(size=3)
    E = G_e @ G.T
    ends, positions = np.full(3, most), np.full(3, limit)
    ends[FIXED], positions[FIXED] = 0.0, np.inf
    program = Qpcc(
        Q=E.T @ E + 1e-4 * np.diag(np.arange(18) < 3),
        c=E.T @ error,
        lb=np.zeros(3),
        ub=ends,
        G=G[:3] @ G.T,
        g_lo=-positions,
        g_hi=positions,
        M=G[3:] @ G.T,
        m=0.3 * rng.normal(size=15),
        constant=0.5 * float(error @ error),
    )
    return FrictionInverse(program, rng.uniform(0.1, 0.8, size=5))


def without_fixed(problem: FrictionInverse) -> FrictionInverse:
    """The problem in which the effort without range is left out."""
    p = problem.program
    z, a = np.delete(np.arange(len(p.c)), FIXED), np.delete(np.arange(3), FIXED)
    program = Qpcc(
        p.Q[np.ix_(z, z)], p.c[z], p.lb[a], p.ub[a], p.G[np.ix_(a, z)], p.g_lo[a], p.g_hi[a],
        p.M[:, z], p.m, p.constant,
    )  # fmt: skip
    return replace(problem, program=program)


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize("limit", [np.inf, 0.3, 0.05])
def test_an_effort_that_cannot_change_is_decided_as_if_it_were_not_there(
    limit: float, warm: bool
) -> None:
    settings = FrictionSettings(warm=warm)
    for seed in (21, 24, 32, 34, 35):
        problem, lam = robot(seed, 3.0, limit), np.array([0.5, 0.0, 0.7])
        found = solve_friction_inverse(problem, lam, settings=settings)
        alone = solve_friction_inverse(
            without_fixed(problem), np.delete(lam, FIXED), settings=settings
        )
        assert found.status is alone.status, seed
        assert found.lam_a[FIXED] == 0.0, seed
        assert found.objective == pytest.approx(alone.objective, rel=1e-3), seed
