"""Postures of the manipulator's benchmark."""

from __future__ import annotations

import numpy as np

from benchmarks.robots import ArmShape, bending_tensions
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.reduction.campaign import Design, Run

BENT = 50.0  # pull of every section on the inner side [N]; ribs touch from about 30 N on
_ON_THE_WAY = 12
_WEAK, _STRONG = 30.0, 65.0  # sections of random postures are pulled with [N]


def bent_tensions() -> Array:
    """All sections bent towards +x, in the plane of the picture: (9,) [N]."""
    return bending_tensions(ArmShape(), np.zeros(3), np.full(3, BENT))


def arm_in_equilibrium(robot: Robot, effort: Array, contact: str = "full") -> Simulator:
    """A simulator in equilibrium under tensions, reached in steps.

    Args:
        robot: the arm.
        effort: (n_a,) [N].
        contact: "full" or "none".

    Raises:
        RuntimeError: there is none.
    """
    simulator = Simulator(robot, contact=contact)  # type: ignore[arg-type]
    for share in np.linspace(0.0, 1.0, _ON_THE_WAY + 1):
        report = simulator.settle(effort=share * effort)
    if not report.converged:
        raise RuntimeError(f"{robot.name} finds no equilibrium under {effort.round(1).tolist()} N")
    return simulator


def random_postures(robot: Robot, count: int, steps: int, seed: int) -> Design:
    """Every section bent in a direction and with a force of its own, both random.

    Args:
        robot: whose limits are kept.
        count: postures.
        steps: equilibria on the way to each.
        seed: of the random numbers.
    """
    rng, shape, runs = np.random.default_rng(seed), ArmShape(), []
    gravity = np.tile(robot.gravity[:, None], steps)
    for _ in range(count):
        angles, forces = rng.uniform(0.0, 2.0 * np.pi, 3), rng.uniform(_WEAK, _STRONG, 3)
        final = np.minimum(bending_tensions(shape, angles, forces), robot.limits.effort_max)
        rise = np.outer(final, np.arange(1, steps + 1) / steps)  # (n_a, s)
        runs.append(
            Run(
                np.full_like(rise, np.nan),
                gravity,
                np.zeros((3 * len(robot.effector_names), steps)),
                rise,
            )
        )
    return Design(f"{count} random postures, seed {seed}, in {steps} steps each", tuple(runs))
