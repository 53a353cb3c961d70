"""Robots of tetrahedra as state reduction sees them, and in the coordinates of a state basis."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from tauten.model import Robot
from tauten.model.constraints import ConstrainedBody, Drums, FrameJoints
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.points import points_at
from tauten.model.tetra import NodalBody, TetBody
from tauten.reduction.reduced_body import ElementSample, StateBasisError
from tauten.reduction.state.tetra.actuators import modal_curvature, reduced_actuators
from tauten.reduction.state.tetra.arrays import make_work
from tauten.reduction.state.tetra.beams import ReducedSprings, reduced_beams
from tauten.reduction.state.tetra.body import contact_surface, mode_points, sampled_body
from tauten.reduction.state.tetra.ecsw import sample_elements
from tauten.reduction.state.tetra.lifting import Lifting, make_lifting
from tauten.reduction.state.tetra.modal_body import ModalBody
from tauten.reduction.state.tetra.node_chart import NONE, NodeChart
from tauten.reduction.state.tetra.points import integration_points

# Factor between the volume of the weighted elements and the body's; samples reach 1.02
_VOLUME = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class ReducibleTetBody:
    """A robot made of tetrahedra, with or without constraints; deviations are those of a `NodeChart`.

    Modes are orthonormal in the mass, Φᵀ M Φ = m I with the body's mass m, so α is in metres and |α| is the
    root mean square displacement of the body. Fixed nodes have no rows in Φ, so they do not move. The angle
    or travel of each drive, and position and rotation of rigid regions, of parts on pins and hinges and of
    the nodes of beams, are coordinates of their own.

    Attributes:
        robot: the robot.
        chart: the deviations that modes combine.
        joints: beams and springs; None: there are none.
        drums: motors that wind several cables; None: there are none.
        driven: (d,) numbers of the actuated drives among the regions of drives.
    """

    robot: Robot[TetBody]
    chart: NodeChart
    joints: FrameJoints | None = None
    drums: Drums | None = None
    driven: Ints = field(default_factory=lambda: NONE)

    norm, default_motion = "mass", 5e-5  # a share of all displacement

    @property
    def own_coordinates(self) -> int:
        """Drives, frames and beams, at the end of the deviations."""
        return self.chart.own

    @property
    def kept_unknowns(self) -> Ints:
        """Unknowns (d,) of drives and frames, after those of the nodes that modes move."""
        return np.arange(3 * len(self.chart.moved), self.robot.n)

    @property
    def weight(self) -> Array:
        """Diagonal (m,) of M / m for nodes that modes move, one for each own coordinate."""
        mass = self.chart.tetrahedra.mass.reshape(-1, 3)[self.chart.moved].ravel()
        weight = 3.0 * mass / mass.sum()  # every node counts three times
        return np.concatenate([weight, np.ones(self.chart.own)])

    @property
    def n_elements(self) -> int:
        """Number of integration points."""
        return len(integration_points(self.robot.body.tetrahedra))

    def deviations(self, q: Array) -> Array:
        """Deviations (m, s) of configurations (n_q, s) [m, rad]."""
        return self.chart.deviations(q)

    def rates(self, q: Array, motion: Array) -> Array:
        """Rates of the deviations (m, k) of velocities (n, k) at a configuration q (n_q,) [m/s, rad/s]."""
        return self.chart.rates(motion)

    def sample(self, Phi: Array, alphas: Array, tolerance: float, seed: int) -> ElementSample:
        """A sample of integration points, see `Reducible` and `sample_elements`.

        The last modes are the robot's own coordinates.
        """
        chart = self.chart
        E, motion = chart.places(Phi)
        own, beta = np.ascontiguousarray(E[:, : motion.elements]), motion.beta(alphas)
        return sample_elements(chart.tetrahedra, own, beta[: motion.elements], tolerance, seed)

    def implausible(self, elements: Ints, weights: Array) -> str:
        """A sentence where the weighted elements have another volume than the body, see `Reducible`."""
        volume = integration_points(self.robot.body.tetrahedra).volume
        with np.errstate(over="ignore"):
            share = float(weights @ volume[elements] / volume.sum())
        if 1.0 / _VOLUME <= share <= _VOLUME:
            return ""
        return (
            f"the weighted elements of this state basis have {share:.3g} times the volume of "
            f"robot {self.robot.name!r}, allowed are {1.0 / _VOLUME} to {_VOLUME}"
        )

    def reduced(self, Phi: Array, elements: Ints, weights: Array) -> Robot[ModalBody]:
        """The robot in the coordinates of a state basis, see `Reducible`.

        Raises:
            StateBasisError: the last modes are not the robot's own coordinates.
        """
        robot, chart = self.robot, self.chart
        full, tetrahedra = robot.body, chart.tetrahedra
        E, motion = chart.places(Phi)
        sampled = sampled_body(tetrahedra, E[:, : motion.elements], elements, weights)
        curvature = modal_curvature(full, np.ascontiguousarray(E[:, : motion.pulled]))
        surface, contacts = contact_surface(robot, E)
        drives, effectors = full.actuator_set.drives, robot.effectors
        places = effectors.places(tetrahedra.motion(full.mesh.nodes))
        loose = self.floating
        body = ModalBody(
            gravity=full.gravity,
            integration=full.integration,
            actuator_set=dataclasses.replace(
                reduced_actuators(full, E),
                drives=dataclasses.replace(drives, columns=motion.modes + drives.travels),
            ),
            full=robot,
            Phi=Phi,
            chart=chart,
            E=E,
            own_motion=motion,
            sampled=sampled,
            curvature=curvature,
            mass=E.T @ (tetrahedra.mass[:, None] * E) - chart.excess(motion),
            floating=E.T @ ((loose * tetrahedra.mass)[:, None] * E) - chart.excess(motion, loose)
            if loose.any()
            else None,
            load=E.T @ tetrahedra.load,
            springs=self.reduced_springs(E),
            drums=self.drums,
            driven=motion.modes + self.driven,
            beams=None
            if self.joints is None
            else reduced_beams(chart, self.joints, E, motion, loose),
            contact_points=surface,
            effector_places=np.asarray(places.H @ E),
            work=make_work(sampled, curvature.tendons, motion.pulled),
        )
        points = mode_points(tetrahedra, E, effectors.points)
        return robot.with_body(body, effectors.over(points), contacts, surface)

    @property
    def floating(self) -> Bools:
        """Which displacements (3 n_nodes,) of nodes that are not fixed are of bodies that nothing holds."""
        full, tetrahedra = self.robot.body, self.chart.tetrahedra
        if not full.floating.any():
            return np.zeros(tetrahedra.m, np.bool_)
        nodes = points_at(np.flatnonzero(tetrahedra.dof >= 0))
        T = full.motion(full.rest()).placed(nodes).motion()
        moved: Bools = abs(T) @ full.floating > 0.0
        return moved

    def reduced_springs(self, E: Array) -> ReducedSprings | None:
        """The springs of hinges in the coordinates β, of E from `NodeChart.places`; None: there are none."""
        if self.joints is None or self.joints.springs.shape[0] == 0:
            return None
        body, S = self.robot.body, sp.csc_array(self.joints.springs)
        stretched = S[:, np.repeat(body.tetrahedra.dof >= 0, 3)] @ E
        at_rest = S @ body.mesh.nodes.ravel()
        return ReducedSprings(stretched.T @ stretched, stretched.T @ at_rest)


def reducible_nodes(robot: Robot[NodalBody]) -> ReducibleTetBody:
    """A robot whose nodes move freely, as state reduction sees it.

    Raises:
        StateBasisError: its materials are viscous.
    """
    require_elastic(robot)
    return ReducibleTetBody(robot, NodeChart(robot.body.tetrahedra, robot.rest().q))


def reducible_constrained(robot: Robot[ConstrainedBody]) -> ReducibleTetBody:
    """A robot some of whose nodes follow others, as state reduction sees it.

    Raises:
        StateBasisError: its materials are viscous, or all of it are beams and drives.
    """
    require_elastic(robot)
    body = robot.body
    frames, map_, joints = body.frames, body.coordinates, body.joints
    chart = NodeChart(body.tetrahedra, robot.rest().q, frames, map_, pulled=pulled_nodes(body))
    if joints is not None and len(joints.nodes) > 0:
        chart = dataclasses.replace(chart, lifting=lifting_of(robot, chart, joints))
    if len(chart.moved) == 0:
        raise StateBasisError(
            f"robot {robot.name}: nothing of it can be reduced, as beams, drives and rigid regions keep "
            "their coordinates; use the full model"
        )
    return ReducibleTetBody(robot, chart, joints, body.drums, body.driven)


def lifting_of(
    robot: Robot[ConstrainedBody], chart: NodeChart, joints: FrameJoints
) -> Lifting | None:
    """The pins of beams and what follows them; None: there are none."""
    glue, tetrahedra = robot.body.coordinates.glue, robot.body.tetrahedra
    if glue is None or chart.turned == chart.centred:
        return None
    _, first = np.unique(joints.turning, return_index=True)
    owner = joints.turning[first]
    pinned = first[(owner >= chart.centred) & (owner < chart.turned)]
    rows, columns = tetrahedra.dof[joints.nodes[pinned]], 3 * chart.moved
    spread = sp.csr_array(sp.csc_array(glue)[:, (columns[:, None] + np.arange(3)).ravel()])
    weights = sp.csr_array(sp.csc_array(sp.csr_array(glue)[rows])[:, columns])
    return make_lifting(tetrahedra, weights, spread, robot.body.linear_solver)


def pulled_nodes(body: ConstrainedBody) -> Ints:
    """Nodes that cables and chambers depend on, among those that are not fixed."""
    cables = body.tetrahedra.curvature.ends.ravel()
    nodes = np.unique(np.concatenate([cables, body.actuator_set.chambers.used]))
    first: Ints = body.tetrahedra.dof[nodes]
    return first[first >= 0] // 3


def require_elastic(robot: Robot[TetBody]) -> None:
    """Raise a StateBasisError where materials are viscous."""
    if robot.body.tetrahedra.viscosity is not None:
        raise StateBasisError(
            f"robot {robot.name}: viscous materials have no state bases; leave out material.viscosity, "
            "or use the full model"
        )
