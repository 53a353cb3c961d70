"""Paths for testing a basis, and the sensitivity of the full-order robot on them."""

from __future__ import annotations

import numpy as np

from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.reduction.campaign import MAX_ITERATIONS, TOLERANCE, Design, Run, Snapshots

FORCES = (0.1, 0.5)  # on the effectors, from six sides [N]
_PERTURBATION = 1e-6  # relative, and of the forces [N]
_DIRECTIONS = ("+x", "-x", "+y", "-y", "+z", "-z")


def held_out_design(robot: Robot, steps: int) -> tuple[Design, tuple[str, ...]]:
    """Gravity from other sides, forces on the effectors, pull and release; all cables together.

    Args:
        robot: the robot.
        steps: of each path.

    Returns:
        The design and a name for each of its runs.
    """
    down = robot.gravity
    size = np.linalg.norm(down)
    rising = np.arange(1, steps + 1) / steps
    nothing = np.zeros(3)
    paths = [(f"gravity {name}", rising, size * axis, nothing) for name, axis in _axes(down)]
    diagonal = np.ones(3) - 2.0 * (down < 0.0)  # has a component along gravity on every axis
    paths.append(("gravity diagonal", rising, size * diagonal / np.sqrt(3.0), nothing))
    for force in FORCES:
        for name, axis in zip(_DIRECTIONS, _sides(), strict=True):
            paths.append((f"{force} N {name}", rising, down, force * axis))
    there = rising[1::2]
    paths.append(("pull and release", np.concatenate([there, there[-2::-1]]), down, nothing))
    runs = tuple(_run(robot, share, gravity, force) for _, share, gravity, force in paths)
    return Design(f"held out: {len(runs)} runs of {steps} steps", runs), tuple(p[0] for p in paths)


def _sides() -> Array:
    """The six directions of `_DIRECTIONS`: (6, 3)."""
    return np.stack([sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)])


def _axes(down: Array) -> list[tuple[str, Array]]:
    """The directions of gravity that are not the robot's own."""
    own = down / max(float(np.linalg.norm(down)), 1e-12)
    pairs = zip(_DIRECTIONS, _sides(), strict=True)
    return [(name, axis) for name, axis in pairs if axis @ own < 0.99]


def _run(robot: Robot, share: Array, gravity: Array, force: Array) -> Run:
    s = len(share)
    return Run(
        position=np.outer(robot.limits.farthest_position, share),
        gravity=np.tile(gravity[:, None], s),
        effector_force=np.tile(np.tile(force, len(robot.effector_names))[:, None], s),
    )


def sensitivity(robot: Robot, snapshots: Snapshots) -> Array:
    """Distances of the effectors from the stored equilibria when the full-order run is perturbed.

    Pulls and gravity are scaled by 1 + `_PERTURBATION`, and a random force of about 1e-6 N acts on every
    effector, a different one at every equilibrium. A large distance means that the robot buckles or snaps
    there, so that its path is not unique and cannot be compared with that of a reduced model.

    Args:
        robot: the robot.
        snapshots: equilibria with full contact, runs one after the other.

    Returns:
        (s,) [m]; NaN where either run did not converge.
    """
    rng = np.random.default_rng(0)
    simulator = Simulator(robot, contact="full")
    apart = np.full(len(snapshots), np.nan)
    for i in range(len(snapshots)):
        if i == 0 or snapshots.run[i] != snapshots.run[i - 1]:
            simulator.reset()
        noise = _PERTURBATION * rng.standard_normal(len(snapshots.effector_force))
        force = snapshots.effector_force[:, i] + noise
        simulator.load((1.0 + _PERTURBATION) * snapshots.gravity[:, i], force)
        position = (1.0 + _PERTURBATION) * snapshots.position[:, i]
        report = simulator.settle(position, None, TOLERANCE, MAX_ITERATIONS)
        if report.converged and snapshots.converged[i]:
            moved = simulator.effector - snapshots.effector[:, i].reshape(-1, 3)  # (p, 3)
            apart[i] = np.linalg.norm(moved, axis=1).max()
    return apart
