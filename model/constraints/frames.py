"""Nodes that move with a frame: rigid and pinned regions, and those that turn about or move along an axis.

A rigid region has six coordinates, the position c of its centre and a rotation R: x = c + R ρ. One that is
pinned has three, the rotation, x = p + R ρ, where the pin p follows other nodes. The region of a drive has
one, θ: x = p + exp(θ [a]x) (x₀ − p) where it turns about the axis a through p, x = x₀ + θ a where it moves
along a.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.constraints.kernels import centripetal_rates, lever_stiffness, place_frames
from tauten.model.numerics import (
    Array,
    Bools,
    Ints,
    longest,
    moments_at_end,
    rotations_between,
    turned,
)
from tauten.model.tetra import Lumping


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
class PinnedRegion:
    """A rigid region that turns freely about a point, which follows other nodes.

    Attributes:
        name: for errors.
        nodes: (k,) node ids.
        pin: (3,) the point at rest [m].
        masters: (4,) nodes that the point follows.
        weights: (4,) theirs, which sum to one.
    """

    name: str
    nodes: Ints
    pin: Array
    masters: Ints
    weights: Array


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
    """All rigid, pinned and drive regions of a robot, in this order; made by `make_frames`.

    The coordinates of a rigid region are c and a unit quaternion, those of a pinned one a unit quaternion,
    those of a drive its angle or travel. Methods take coordinates q (7 n_rigid + 4 n_pinned + n_drives,), and
    velocities v, or a step, of (n_velocities,).

    Attributes:
        nodes: (k,) nodes of all regions, region by region, numbered among those that are not fixed.
        owner: (k,) region of each.
        offsets: (k, 3) from the region's centre, from its pin, or from `through`, at rest [m].
        centres: (n_rigid, 3) centres of the rigid regions at rest [m].
        n_pinned: pinned regions.
        axes: (n_drives, 3) unit directions.
        through: (n_drives, 3) points of the axes [m].
        turns: (n_drives,) bool.
        excess: (regions, 3, 3) of second moments of their lumped masses at rest, see `Lumping` [kg m²].
        rotations: (n_turning,) first velocity of the rotation of every rigid and pinned region.
        drives: (n_drives,) velocity of every drive.
        reach: (regions,) largest displacement of a node by a unit of each region's rotation or travel [m].
        lumped: (l,) numbers of the rigid and pinned regions whose lumped masses have too much inertia,
        tensors: (l, 3, 3) how much of it, at rest [kg m²],
        about: (n_drives,) and of every drive about its axis.
    """

    nodes: Ints
    owner: Ints
    offsets: Array
    centres: Array
    n_pinned: int
    axes: Array
    through: Array
    turns: Bools
    excess: Array
    rotations: Ints = field(init=False)
    drives: Ints = field(init=False)
    reach: Array = field(init=False)
    lumped: Ints = field(init=False)
    tensors: Array = field(init=False)
    about: Array = field(init=False)

    def __post_init__(self) -> None:
        """Compute what does not depend on the state."""
        rigid, pinned = np.arange(self.n_rigid), np.arange(self.n_pinned)
        rotations = np.concatenate([6 * rigid + 3, 6 * self.n_rigid + 3 * pinned])
        object.__setattr__(self, "rotations", rotations)
        drives = self.n_velocities - self.n_drives + np.arange(self.n_drives)
        object.__setattr__(self, "drives", drives)
        object.__setattr__(self, "reach", self._reach())
        (lumped,) = np.nonzero(self.excess[: self.n_turning].any(axis=(1, 2)))
        object.__setattr__(self, "lumped", lumped)
        object.__setattr__(self, "tensors", _inertia_of(self.excess[lumped]))
        about = self.inertia_about_axes(self.excess)
        object.__setattr__(self, "about", np.where(self.turns, about, 0.0))

    @property
    def is_lumped(self) -> bool:
        """Whether the masses of any region have more inertia than its elements."""
        return bool(self.excess.any())

    @property
    def n_rigid(self) -> int:
        """Rigid regions."""
        return len(self.centres)

    @property
    def n_drives(self) -> int:
        """Drive regions."""
        return len(self.axes)

    @property
    def n_turning(self) -> int:
        """Regions with a rotation: rigid and pinned ones."""
        return self.n_rigid + self.n_pinned

    @property
    def n_velocities(self) -> int:
        """Velocities of all regions."""
        return 6 * self.n_rigid + 3 * self.n_pinned + self.n_drives

    def _reach(self) -> Array:
        """The attribute `reach`."""
        drive = self.owner - self.n_turning
        turning, arms = drive >= 0, self.offsets.copy()
        arms[turning] = np.cross(self.axes[drive[turning]], arms[turning])
        reach = np.zeros(self.n_turning + self.n_drives)
        np.maximum.at(reach, self.owner, np.linalg.norm(arms, axis=1))
        reach[self.n_turning :][~self.turns] = 1.0
        return reach

    def largest_moves(self, step: Array) -> tuple[float, float]:
        """Largest displacement of a node in a step, about, and what pins may add to it [m]."""
        rigid = step[: 6 * self.n_rigid].reshape(-1, 6)[:, :3]
        turns = np.linalg.norm(step[self.rotations[:, None] + np.arange(3)], axis=1)
        arms = self.reach * np.concatenate([turns, np.abs(step[self.drives])])
        pinned = arms[self.n_rigid : self.n_turning].sum()  # each may follow the one before
        return float(max(longest(rigid), arms.max(initial=0.0))), float(pinned)

    def rest(self) -> Array:
        """Coordinates at rest: (7 n_rigid + 4 n_pinned + n_drives,)."""
        still = np.array([1.0, 0.0, 0.0, 0.0])
        poses = np.hstack([self.centres, np.tile(still, (self.n_rigid, 1))])
        return np.concatenate(
            [poses.ravel(), np.tile(still, self.n_pinned), np.zeros(self.n_drives)]
        )

    def parted(self, q: Array) -> tuple[Array, Array]:
        """Poses (n_turning, 7), those of pinned regions with a position of zero, and drives (n_drives,)."""
        end = 7 * self.n_rigid
        last = end + 4 * self.n_pinned
        if not self.n_pinned:
            return q[:end].reshape(-1, 7), q[last:]
        pinned = np.hstack([np.zeros((self.n_pinned, 3)), q[end:last].reshape(-1, 4)])
        return np.concatenate([q[:end].reshape(-1, 7), pinned]), q[last:]

    def place(self, q: Array) -> tuple[Array, Array]:
        """Positions of the nodes, of pinned regions from their pin, and levers, both (k, 3) [m].

        The lever of a node in a rigid or pinned region is R ρ, that in a drive region its derivative ∂x/∂θ.
        """
        poses, theta = self.parted(q)
        return place_frames(
            poses, theta, self.owner, self.offsets, self.axes, self.through, self.turns
        )

    def quaternions(self, q: Array) -> Array:
        """Rotations of all regions, and at the end that of what is fixed: (regions + 1, 4), unit."""
        poses, theta = self.parted(q)
        half = 0.5 * np.where(self.turns, theta, 0.0)[:, None]
        drives = np.hstack([np.cos(half), np.sin(half) * self.axes])
        return np.concatenate([poses[:, 3:], drives, [[1.0, 0.0, 0.0, 0.0]]])

    def beside(self, drive: int) -> Array:
        """The point of a drive's axis beside its region at rest: (3,) [m]."""
        own = self.offsets[self.owner == self.n_turning + drive]
        middle = own.mean(axis=0) if len(own) else np.zeros(3)  # a drum moves no nodes
        axis = self.axes[drive]
        if self.turns[drive]:
            middle = (middle @ axis) * axis
        point: Array = self.through[drive] + middle
        return point

    def centripetal(self, levers: Array, v: Array) -> Array:
        """Accelerations of the nodes at constant velocities, with levers from `place`: (k, 3) [m/s²]."""
        omega = v[self.rotations[:, None] + np.arange(3)].reshape(-1, 3)
        rate = v[self.drives]
        return centripetal_rates(omega, rate, self.owner, levers, self.axes, self.turns)

    def inertia_about_axes(self, moments: Array) -> Array:
        """Inertia of the drives about their axes (n_drives,), of second moments (regions, 3, 3) [kg m²]."""
        of_drives = _inertia_of(moments[self.n_turning :])
        found: Array = np.einsum("di,dij,dj->d", self.axes, of_drives, self.axes)
        return found

    def excess_inertia(self, q: Array) -> tuple[Array, Array]:
        """What lumped masses have too much: inertia (n_turning, 3, 3), and (n_drives,) about axes [kg m²]."""
        found = np.zeros((self.n_turning, 3, 3))
        found[self.lumped] = self._turned_tensors(q)
        return found, self.about

    def excess_moments(self, q: Array, v: Array) -> Array:
        """Moments ω x I ω (n_velocities,) of that inertia [N m]."""
        columns = self.rotations[self.lumped, None] + np.arange(3)
        omega = v[columns]  # (l, 3) rad/s
        momentum = (self._turned_tensors(q) @ omega[:, :, None])[:, :, 0]
        found, on, back = np.zeros(self.n_velocities), [1, 2, 0], [2, 0, 1]
        found[columns] = omega[:, on] * momentum[:, back] - omega[:, back] * momentum[:, on]
        return found

    def _turned_tensors(self, q: Array) -> Array:
        """`tensors` at coordinates q: (l, 3, 3) [kg m²]."""
        if len(self.lumped) == 0:
            return self.tensors
        turns = self.parted(q)[0][self.lumped, 3:]
        R = Rotation.from_quat(turns[:, [1, 2, 3, 0]]).as_matrix()
        found: Array = R @ self.tensors @ R.swapaxes(1, 2)
        return found

    def stiffness(self, levers: Array, force: Array) -> tuple[Array, Array]:
        """What levers that turn add to the tangent −∂(Tᵀ f)/∂q under forces (k, 3) of fixed direction [N].

        Of a rigid or pinned region this is the symmetric part, exact at equilibrium. Levers (k, 3) are from
        `place`.

        Returns:
            (n_turning, 3, 3) blocks of the rotations and (n_drives,) of the drives [N m].
        """
        blocks = np.zeros((self.n_turning, 3, 3))
        drives = lever_stiffness(self.owner, levers, force, self.axes, self.turns, blocks)
        return blocks, drives

    def moved(self, q: Array, step: Array) -> Array:
        """Coordinates after a step."""
        poses, theta = self.parted(q)
        rigid = step[: 6 * self.n_rigid].reshape(-1, 6)
        turns = step[self.rotations[:, None] + np.arange(3)].reshape(-1, 3)
        quaternions = turned(poses[:, 3:].copy(), turns)
        after = np.hstack([poses[: self.n_rigid, :3] + rigid[:, :3], quaternions[: self.n_rigid]])
        pinned = quaternions[self.n_rigid :]
        return np.concatenate([after.ravel(), pinned.ravel(), theta + step[self.drives]])

    def between(self, before: Array, after: Array) -> Array:
        """The step that moves coordinates to others, inverse of `moved`; turns of up to π."""
        (first, theta), (last, ahead) = self.parted(before), self.parted(after)
        step = np.zeros(self.n_velocities)
        rigid = step[: 6 * self.n_rigid].reshape(-1, 6)
        rigid[:, :3] = last[: self.n_rigid, :3] - first[: self.n_rigid, :3]
        turns = rotations_between(first[:, 3:].copy(), last[:, 3:].copy())
        step[self.rotations[:, None] + np.arange(3)] = turns
        step[self.drives] = ahead - theta
        return step

    def at_end(self, step: Array, force: Array) -> Array:
        """Forces (n_velocities,) [N], [N m] at the end of a step that do the work of given ones on it."""
        turns, found = self.rotations[:, None] + np.arange(3), force.copy()
        found[turns] = moments_at_end(step[turns].reshape(-1, 3), force[turns].reshape(-1, 3))
        return found


def _inertia_of(moments: Array) -> Array:
    """Tensors of inertia tr(S) I − S (m, 3, 3) of second moments S (m, 3, 3) [kg m²]."""
    trace = np.trace(moments, axis1=1, axis2=2)
    found: Array = trace[:, None, None] * np.eye(3) - moments
    return found


def make_frames(
    rigid: list[RigidRegion],
    pinned: list[PinnedRegion],
    drives: list[DriveRegion],
    number: Ints,
    x0: Array,
    mass: Array,
    lumpings: list[Lumping],
) -> Frames:
    """The regions as arrays.

    Args:
        rigid: rigid regions; their centres are those of their masses.
        pinned: pinned regions.
        drives: drive regions.
        number: (n_nodes,) number of each node among those that are not fixed.
        x0: (n_nodes, 3) positions at rest [m].
        mass: (n_nodes,) lumped mass [kg].
        lumpings: what lumping it has changed.
    """
    centres = np.array(
        [np.average(x0[one.nodes], axis=0, weights=mass[one.nodes]) for one in rigid]
    ).reshape(-1, 3)
    pins = np.array([one.pin for one in pinned]).reshape(-1, 3)
    through = np.array([one.through for one in drives]).reshape(-1, 3)
    regions = [
        *(one.nodes for one in rigid),
        *(one.nodes for one in pinned),
        *(one.nodes for one in drives),
    ]
    owner = np.repeat(np.arange(len(regions)), [len(part) for part in regions])
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *regions])
    region, excess = np.full(len(x0), -1), np.zeros((len(regions), 3, 3))
    region[nodes] = owner
    for one in lumpings:
        excess += one.within(region, len(regions))
    return Frames(
        nodes=number[nodes],
        owner=owner,
        offsets=x0[nodes] - np.concatenate([centres, pins, through])[owner],
        centres=centres,
        n_pinned=len(pinned),
        axes=np.array([one.axis for one in drives]).reshape(-1, 3),
        through=through,
        turns=np.array([one.turns for one in drives], dtype=bool),
        excess=excess,
    )
