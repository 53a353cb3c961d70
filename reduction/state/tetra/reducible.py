"""Robots of tetrahedra as state reduction sees them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from tauten.model import TetRobot
from tauten.model.constraints import ConstrainedRobot
from tauten.model.effectors import Effectors
from tauten.model.numerics import Array, Ints
from tauten.reduction.reduced_robot import ElementSample
from tauten.reduction.state.tetra.actuators import modal_curvature, reduced_actuators
from tauten.reduction.state.tetra.arrays import make_work
from tauten.reduction.state.tetra.body import contact_surface, mode_points, sampled_body
from tauten.reduction.state.tetra.ecsw import sample_elements
from tauten.reduction.state.tetra.node_chart import NodeChart
from tauten.reduction.state.tetra.points import integration_points
from tauten.reduction.state.tetra.robot import ReducedSprings, ReducedTetRobot, chart_weight

_VOLUME = (
    2.0  # factor between the volume of the weighted elements and the body's; samples reach 1.02
)


@dataclass(frozen=True, slots=True, eq=False)
class ReducibleTetRobot:
    """A robot made of tetrahedra, with or without constraints; deviations are those of a `NodeChart`.

    Modes are orthonormal in the mass, Φᵀ M Φ = m I with the body's mass m, so α is in metres and |α| is the
    root mean square displacement of the body. Fixed nodes have no rows in Φ, so they do not move. The angle
    or travel of each drive is a coordinate of its own.

    Attributes:
        robot: the robot.
    """

    robot: TetRobot | ConstrainedRobot

    @property
    def chart(self) -> NodeChart:
        """The deviations that modes combine."""
        robot, rest = self.robot, self.robot.rest().q
        if isinstance(robot, TetRobot):
            return NodeChart(robot, rest)
        return NodeChart(robot.raw, rest, robot.frames, robot.coordinates)

    @property
    def own_coordinates(self) -> int:
        """The drives, at the end of the deviations."""
        return self.chart.drives

    @property
    def weight(self) -> Array:
        """Diagonal (m,) of M / m for the nodes, one for each drive."""
        return chart_weight(self.chart)

    @property
    def norm(self) -> str:
        """What W is, in a word."""
        return "mass"

    @property
    def default_motion(self) -> float:
        """Relative projection error that a basis is allowed, a share of all displacement."""
        return 5e-5

    @property
    def n_elements(self) -> int:
        """Number of integration points."""
        return len(integration_points(self.chart.raw))

    def deviations(self, q: Array) -> Array:
        """Deviations (m, s) of configurations (n_q, s) [m, rad]."""
        return self.chart.deviations(q)

    def rates(self, q: Array, motion: Array) -> Array:
        """Rates of the deviations (m, k) of velocities (n, k) at a configuration q (n_q,) [m/s, rad/s]."""
        return self.chart.rates(q, motion)

    def sample(self, Phi: Array, alphas: Array, tolerance: float, seed: int) -> ElementSample:
        """A sample of integration points, see `sample_elements`.

        Args:
            Phi: (m, r) state modes, the last of which are the drives.
            alphas: (r, s) states of a campaign [m, rad].
            tolerance: relative residual.
            seed: of random directions.
        """
        chart = self.chart
        E, motion = chart.places(Phi)
        return sample_elements(chart.raw, E, motion.beta(alphas), tolerance, seed)

    def implausible(self, elements: Ints, weights: Array) -> str:
        """A sentence where the weighted elements have another volume than the body.

        Args:
            elements: (s,) numbers of integration points.
            weights: (s,) their weights.
        """
        volume = integration_points(self.chart.raw).volume
        with np.errstate(over="ignore"):
            share = float(weights @ volume[elements] / volume.sum())
        if 1.0 / _VOLUME <= share <= _VOLUME:
            return ""
        return (
            f"the weighted elements of this state basis have {share:.3g} times the volume of "
            f"robot {self.robot.name!r}, allowed are {1.0 / _VOLUME} to {_VOLUME}"
        )

    def reduced(self, Phi: Array, elements: Ints, weights: Array) -> ReducedTetRobot:
        """The robot in the coordinates of a state basis.

        Args:
            Phi: (m, r) state modes, the last of which are the drives.
            elements: (s,) numbers of integration points, ascending.
            weights: (s,) their weights.

        Raises:
            StateBasisError: the last modes are not those of the drives.
        """
        robot, chart = self.robot, self.chart
        raw = chart.raw
        E, motion = chart.places(Phi)
        body, curvature = sampled_body(raw, E, elements, weights), modal_curvature(raw, E)
        surface, contacts = contact_surface(raw, E)
        drives = robot.actuator_set.drives
        places = raw.effectors.places(raw.motion(raw.rest()))
        points = mode_points(raw, E, raw.effectors.points)
        return ReducedTetRobot(
            names=robot.names,
            digest=robot.digest,
            gravity=robot.gravity,
            tolerance=robot.tolerance,
            integration=robot.integration,
            actuators=robot.actuators,
            actuator_set=dataclasses.replace(
                reduced_actuators(raw, E),
                drives=dataclasses.replace(drives, columns=motion.modes + drives.travels),
                coupling=robot.actuator_set.coupling,
            ),
            limits=robot.limits,
            effectors=Effectors(raw.effectors.kinds, points),
            contacts=contacts,
            vertices=surface,
            full=robot,
            Phi=Phi,
            chart=chart,
            E=E,
            drive_motion=motion,
            body=body,
            curvature=curvature,
            mass=E.T @ (raw.mass[:, None] * E),
            load=E.T @ raw.load,
            springs=self.springs(E),
            drums=None if isinstance(robot, TetRobot) else robot.drums,
            effector_places=np.asarray(places.H @ E),
            work=make_work(body, curvature.tendons),
        )

    def springs(self, E: Array) -> ReducedSprings | None:
        """The springs of hinges in the coordinates β; None: there are none.

        Args:
            E: (3 n_nodes, R) from `NodeChart.places`.
        """
        robot = self.robot
        if isinstance(robot, TetRobot) or robot.joints is None:
            return None
        free = robot.raw.pattern.dof >= 0
        S = sp.csc_array(robot.joints.springs)
        stretched = S[:, np.repeat(free, 3)] @ E
        at_rest = S @ robot.mesh.nodes.ravel()
        return ReducedSprings(stretched.T @ stretched, stretched.T @ at_rest)
