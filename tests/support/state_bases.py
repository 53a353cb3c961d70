"""State bases made by hand, for tests that need no campaign."""

from __future__ import annotations

import numpy as np

from tauten.model import Robot, State
from tauten.model.numerics import Array, Ints
from tauten.model.tetra import NodalBody
from tauten.reduction.state import ReducedBody, StateBasis, StateOrigin, reducible


def basis_of(robot: Robot, Phi: Array, elements: Ints, weights: Array) -> StateBasis:
    """A state basis without campaign and tip errors."""
    origin = StateOrigin(
        robot=robot.name, robot_digest=robot.digest, campaign="test", snapshots_digest="",
        snapshots=0, r=Phi.shape[1], responses=0, projection_error=0.0, sample=len(elements),
        sample_tolerance=0.0, sample_error=0.0, tip_mean=np.nan, tip_max=np.nan, seed=0,
        created="", versions=(),
    )  # fmt: skip
    return StateBasis(Phi, elements, weights, origin)


def projected(robot: Robot[ReducedBody], state: State) -> State:
    """The state of a reduced robot that is nearest to one of the full robot, in the norm of its modes."""
    body = reducible(robot.body.full)
    project = robot.body.Phi.T * body.weight  # (r, m)
    q = project @ body.deviations(state.q[:, None])[:, 0]
    return State(q, project @ body.rates(state.q, state.v[:, None])[:, 0])


def turned_space(robot: Robot[NodalBody]) -> Array:
    """All of space as modes (n, n), turned so that no coordinate is a node's, with ΦᵀMΦ = m I."""
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(robot.n, robot.n)))[0]
    Phi: Array = (
        turn / np.sqrt(3.0 * robot.body.tetrahedra.mass / robot.body.tetrahedra.mass.sum())[:, None]
    )
    return Phi
