"""Robots made of beams as state reduction sees them, and the elements that carry their loads."""

from __future__ import annotations

import numpy as np

from tauten.model import Robot, State
from tauten.model.beams import BeamBody, BeamLoopError, make_tree
from tauten.model.numerics import Array, Ints
from tauten.reduction.reduced_body import ElementSample, StateBasisError
from tauten.reduction.state.beams.strain_body import StrainBody, make_reduced

STATES = 40  # training states taken of a campaign
DIRECTIONS = 3  # random directions at each


class ReducibleBeams:
    """A robot made of beams as state reduction sees it: deviations are natural strains.

    Modes are orthonormal in the stiffness of the strains, Φᵀ D Φ = I, so the strain energy is ½ |α|².
    """

    own_coordinates, kept_unknowns = 0, np.zeros(0, np.int64)  # all strains are those of modes
    norm, default_motion = "stiffness", 5e-3  # a share in the root of the strain energy

    def __init__(self, robot: Robot[BeamBody]) -> None:
        """Order the beams of a robot.

        Raises:
            StateBasisError: they form closed loops, or none of the nodes is fixed.
        """
        try:
            self.robot, self.tree = robot, make_tree(robot.body.beams, robot.body.dof < 0)
        except BeamLoopError as error:
            raise StateBasisError(
                f"robot {robot.name}: {error}; state bases need beams that branch from fixed nodes without "
                "loops, use the full model"
            ) from error

    @property
    def weight(self) -> Array:
        """Stiffnesses (6 e,) of the natural strains [N/m], [N m]."""
        return self.tree.D

    @property
    def n_elements(self) -> int:
        """Number of beam elements."""
        return len(self.tree)

    def deviations(self, q: Array) -> Array:
        """Natural strains (6 e, s) of configurations (n_q, s)."""
        poses = [self.robot.body.pose(State(column, column)) for column in q.T]
        columns = [self.tree.strains(*pose) for pose in poses]
        return np.stack(columns, axis=1)

    def rates(self, q: Array, motion: Array) -> Array:
        """Rates of the strains (6 e, k) of velocities (n, k) at a configuration (n_q,)."""
        body, k = self.robot.body, motion.shape[1]
        every = np.zeros((2 * body.n_nodes, 3, k))
        every[body.pattern.dof >= 0] = motion.reshape(-1, 3, k)
        return self.tree.rates(*body.pose(State(q, q)), every.reshape(-1, 6, k))

    def sample(self, Phi: Array, alphas: Array, tolerance: float, seed: int) -> ElementSample:
        """The elements that carry loads: those at which the change of J is evaluated for the tangent.

        Elements that carry little but their own weight add nearly nothing. Those with the largest
        contributions to K d, for random directions d, are taken, so many that the others together add less
        than a share of K d, the tolerance. All weights are one. See `Reducible`.
        """
        rng = np.random.default_rng(seed)
        every = np.arange(len(self.tree))
        robot = make_reduced(self.robot, self.tree, Phi, every)
        strain = Phi.reshape(len(every), 6, -1)  # (e, 6, r)
        chosen = np.linspace(0, alphas.shape[1] - 1, min(STATES, alphas.shape[1])).round()
        parts, products = [], []
        for alpha in np.ascontiguousarray(alphas.T)[chosen.astype(int)]:
            d = rng.normal(size=(Phi.shape[1], DIRECTIONS))
            d /= np.linalg.norm(d, axis=0)
            state = State(alpha, np.zeros_like(alpha))
            K = robot.forces(state, balancing_effort(robot, state), exact=True)[1]
            rows = robot.body.work.load_Y.reshape(strain.shape)
            found = np.swapaxes(strain, 1, 2) @ (rows @ d) + np.swapaxes(rows, 1, 2) @ (strain @ d)
            parts.append(found.reshape(len(every), -1))
            products.append(K @ d)
        contributions, scale = np.concatenate(parts, axis=1), float(np.linalg.norm(products))
        order = np.argsort(-np.linalg.norm(contributions, axis=1), kind="stable")
        left_out = np.cumsum(contributions[order[::-1]], axis=0)[::-1]  # from each element on
        error = np.append(np.linalg.norm(left_out, axis=1), 0.0) / scale  # (e + 1,)
        count = max(1, int(np.argmax(error <= tolerance)))
        return ElementSample(np.sort(order[:count]), np.ones(count), float(error[count]))

    def implausible(self, elements: Ints, weights: Array) -> str:
        """A sentence where elements have other weights than one, see `Reducible`."""
        if (weights == 1.0).all():
            return ""
        wrong = np.flatnonzero(weights != 1.0)[0]
        return (
            f"element {elements[wrong]} of this state basis has the weight {weights[wrong]:.3g}: expected "
            "is 1 for every beam"
        )

    def reduced(self, Phi: Array, elements: Ints, weights: Array) -> Robot[StrainBody]:
        """The robot in the coordinates of a state basis, see `Reducible`; elements are those with loads."""
        return make_reduced(self.robot, self.tree, Phi, elements)


def balancing_effort(robot: Robot[StrainBody], state: State) -> Array:
    """The efforts (n_a,) that balance the other forces at a state best, without contacts [N]."""
    from scipy.optimize import nnls  # takes long, and only campaigns need it

    H = robot.rows(state, contacts=False).actuators.dense()
    both = robot.actuators.laws.bilateral  # these pull, and they push
    effort: Array = nnls(np.hstack([H.T, -H[both].T]), -robot.forces(state)[0])[0]
    effort, pushing = effort[: len(H)], effort[len(H) :]
    effort[both] -= pushing
    return effort
