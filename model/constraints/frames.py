"""Nodes that move with a frame: rigid regions, and regions that turn about or move along an axis.

A rigid region has six coordinates, the position c of its centre and a rotation R: x = c + R ρ. The region
of a drive has one, θ: x = p + exp(θ [a]x) (x₀ − p) where it turns about the axis a through p, x = x₀ + θ a
where it moves along a.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.constraints.kernels import (
    centripetal_rates,
    lever_stiffness,
    place_frames,
)
from tauten.model.numerics import Array, Bools, Ints, turned


@dataclass(frozen=True, slots=True)
class RigidRegion:
    """A region that moves as a rigid body.

    Attributes:
        name: for errors.
        nodes: (k,) node ids.
    """

    name: str
    nodes: Ints


@dataclass(frozen=True, slots=True)
class DriveRegion:
    """A region that turns about an axis, or moves along it.

    Attributes:
        name: of the drive; for errors.
        nodes: (k,) node ids.
        axis: (3,) unit direction.
        through: (3,) a point of the axis [m].
        turns: whether it turns about the axis; otherwise it moves along it.
    """

    name: str
    nodes: Ints
    axis: Array
    through: Array
    turns: bool


@dataclass(frozen=True, slots=True)
class Frames:
    """All rigid regions and drive regions of a robot, in this order; made by `make_frames`.

    The coordinates of rigid region r are c_r and a unit quaternion, those of drive d its angle or travel.

    Attributes:
        nodes: (k,) nodes of all regions, region by region, numbered among those that are not fixed.
        owner: (k,) region of each.
        offsets: (k, 3) from the region's centre, or from `through`, at rest [m].
        centres: (n_rigid, 3) centres of the rigid regions at rest [m].
        axes: (n_drives, 3) unit directions.
        through: (n_drives, 3) points of the axes [m].
        turns: (n_drives,) bool.
    """

    nodes: Ints
    owner: Ints
    offsets: Array
    centres: Array
    axes: Array
    through: Array
    turns: Bools

    @property
    def n_rigid(self) -> int:
        """Rigid regions."""
        return len(self.centres)

    @property
    def n_drives(self) -> int:
        """Drive regions."""
        return len(self.axes)

    @property
    def n_velocities(self) -> int:
        """Velocities of all regions."""
        return 6 * self.n_rigid + self.n_drives

    @property
    def reach(self) -> Array:
        """Largest displacement of a node by a unit of each region's rotation or travel (regions,) [m]."""
        longest = np.ones(self.n_rigid + self.n_drives)
        for region in range(len(longest)):
            arms = self.offsets[self.owner == region]
            drive = region - self.n_rigid
            if drive >= 0 and not self.turns[drive]:
                continue
            if drive >= 0:
                arms = np.cross(self.axes[drive], arms)
            longest[region] = np.linalg.norm(arms, axis=1).max(initial=0.0)
        return longest

    def rest(self) -> Array:
        """Coordinates at rest: (7 n_rigid + n_drives,)."""
        poses = np.hstack([self.centres, np.tile([1.0, 0.0, 0.0, 0.0], (self.n_rigid, 1))])
        return np.concatenate([poses.ravel(), np.zeros(self.n_drives)])

    def place(self, q: Array) -> tuple[Array, Array]:
        """Positions of the nodes and their levers, both (k, 3) [m].

        The lever of a node in a rigid region is R ρ, that in a drive region its derivative ∂x/∂θ.

        Args:
            q: (7 n_rigid + n_drives,) coordinates.
        """
        poses, theta = q[: 7 * self.n_rigid].reshape(-1, 7), q[7 * self.n_rigid :]
        return place_frames(
            poses, theta, self.owner, self.offsets, self.axes, self.through, self.turns
        )

    def drive_segments(self, q: Array) -> Array:
        """For each drive the point of its axis beside its region, and one metre along: (n_drives, 2, 3) [m].

        Args:
            q: (7 n_rigid + n_drives,) coordinates.
        """
        points = np.zeros((self.n_drives, 3))
        for drive in range(self.n_drives):
            middle = self.offsets[self.owner == self.n_rigid + drive].mean(axis=0)
            axis, travel = self.axes[drive], q[7 * self.n_rigid + drive]
            shift = (middle @ axis) * axis if self.turns[drive] else middle + travel * axis
            points[drive] = self.through[drive] + shift
        return np.stack([points, points + self.axes], axis=1)

    def centripetal(self, levers: Array, v: Array) -> Array:
        """Accelerations of the nodes at constant velocities of the regions: (k, 3) [m/s²].

        Args:
            levers: (k, 3) from `place`.
            v: (6 n_rigid + n_drives,) velocities of the regions.
        """
        omega = v[: 6 * self.n_rigid].reshape(-1, 6)[:, 3:]
        rate = v[6 * self.n_rigid :]
        return centripetal_rates(omega, rate, self.owner, levers, self.axes, self.turns)

    def stiffness(self, levers: Array, force: Array) -> tuple[Array, Array]:
        """What turning levers add to the tangent −∂(Tᵀ f)/∂q under forces that keep their direction.

        Of a rigid region this is the symmetric part, exact at equilibrium.

        Args:
            levers: (k, 3) from `place` [m].
            force: (k, 3) on the nodes [N].

        Returns:
            (n_rigid, 3, 3) blocks of the rotations and (n_drives,) of the drives [N m].
        """
        blocks = np.zeros((self.n_rigid, 3, 3))
        drives = lever_stiffness(self.owner, levers, force, self.axes, self.turns, blocks)
        return blocks, drives

    def moved(self, q: Array, step: Array) -> Array:
        """Coordinates after a step.

        Args:
            q: (7 n_rigid + n_drives,) before.
            step: (6 n_rigid + n_drives,) velocities times the time step.
        """
        poses, theta = q[: 7 * self.n_rigid].reshape(-1, 7), q[7 * self.n_rigid :]
        rigid = step[: 6 * self.n_rigid].reshape(-1, 6)
        quaternions = turned(poses[:, 3:].copy(), rigid[:, 3:].copy())
        after = np.hstack([poses[:, :3] + rigid[:, :3], quaternions])
        return np.concatenate([after.ravel(), theta + step[6 * self.n_rigid :]])


def make_frames(
    rigid: list[RigidRegion], drives: list[DriveRegion], number: Ints, x0: Array, mass: Array
) -> Frames:
    """The regions as arrays.

    Args:
        rigid: rigid regions; their centres are those of their masses.
        drives: drive regions.
        number: (n_nodes,) number of each node among those that are not fixed.
        x0: (n_nodes, 3) positions at rest [m].
        mass: (n_nodes,) lumped mass [kg].
    """
    centres = np.array(
        [np.average(x0[one.nodes], axis=0, weights=mass[one.nodes]) for one in rigid]
    ).reshape(-1, 3)
    through = np.array([one.through for one in drives]).reshape(-1, 3)
    regions = [one.nodes for one in rigid] + [one.nodes for one in drives]
    owner = np.repeat(np.arange(len(regions)), [len(part) for part in regions])
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *regions])
    return Frames(
        nodes=number[nodes],
        owner=owner,
        offsets=x0[nodes] - np.concatenate([centres, through])[owner],
        centres=centres,
        axes=np.array([one.axis for one in drives]).reshape(-1, 3),
        through=through,
        turns=np.array([one.turns for one in drives], dtype=bool),
    )
