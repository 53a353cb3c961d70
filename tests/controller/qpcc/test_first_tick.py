"""Cables give way within limits in the first tick of a plan, however strongly they act on each other."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import nnls

from tauten.controller import winches
from tauten.controller.winches import Reach, take_tick
from tauten.model import Command
from tauten.model.numerics import Array

ROUNDING = 1e-7  # m
STIFF = 1e-6  # m/N, what a cable moves by its own tension at least


def cables_of(W: Array, free: Array, command: Command) -> Any:
    """What a linear robot does: 0 ≤ δ − position ⟂ λ ≥ 0 as a least-squares problem of SciPy.

    Args:
        W: (n, n) compliance of the cables [m/N].
        free: (n,) where they are without tension [m].
        command: position or tension of each.
    """
    wound = np.flatnonzero(np.isnan(command.effort))
    lam = np.where(np.isnan(command.effort), 0.0, command.effort)
    if len(wound) > 0:
        gap = (free + W @ lam)[wound] - command.position[wound]
        root = np.linalg.cholesky(W[np.ix_(wound, wound)])
        lam[wound] = nnls(root.T, -np.linalg.solve(root, gap))[0]
    return SimpleNamespace(effort=lam, delta=free + W @ lam, converged=True)


@pytest.mark.parametrize("n", [2, 4, 9])
def test_each_cable_is_at_one_end_of_its_staircase(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 300 random robots up to 27 ended with tensions and positions that no cable may have together."""
    rng = np.random.default_rng(n)
    for _ in range(300):
        rows = rng.standard_normal((n, n))
        rows[0] += 3.0 * rng.standard_normal(n)  # all cables pull one direction most
        W, free = 1e-3 * rows.T @ rows + STIFF * np.eye(n), 0.02 * rng.standard_normal(n)
        start = rng.uniform(-0.01, 0.01, n)
        lower, upper = start - 0.002, start + 0.002
        wanted, most = rng.uniform(lower, upper), rng.uniform(1.0, 12.0, n)
        step = SimpleNamespace(
            layout=SimpleNamespace(n_a=n, actuators=slice(0, n)),
            laws=SimpleNamespace(bilateral=np.zeros(n, np.bool_)),
        )
        limits = SimpleNamespace(
            effort_min=np.zeros(n),
            effort_max=most,
            position_min=-np.ones(n),
            position_max=np.ones(n),
        )
        monkeypatch.setattr(
            winches, "forward_step", lambda *given, W=W, free=free: cables_of(W, free, given[-1])
        )
        command, reach = Command(wanted, np.full(n, np.nan)), Reach(lower, upper)
        solved: Any = take_tick(step, None, None, command, reach, limits).solved  # type: ignore[arg-type]
        lam, delta, near = solved.effort, solved.delta, 1e-6 * most
        slack = (lam <= near) & (delta >= wanted - ROUNDING)
        wound = (np.abs(delta - wanted) <= ROUNDING) & (lam <= most + near)
        gives_way = (np.abs(lam - most) <= near) & (delta >= lower - ROUNDING) & (delta <= wanted)
        paid_out = (np.abs(delta - lower) <= ROUNDING) & (lam >= most - near)
        assert (slack | wound | gives_way | paid_out).all(), (lam, delta)
