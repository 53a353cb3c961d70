"""Which nodes of a robot modes move, and what drives, glue, pins and rigid regions make of that.

Modes move the free nodes and those of rigid and pinned regions, whose rigidity is linear in the modes of a
campaign as far as its snapshots span it. A rotation of a drive's region about an axis a is linear in sin θ
and 1 − cos θ,

    x = x₀ + sin θ a x ρ + (1 − cos θ) a x (a x ρ),                                           (T6)

so that all nodes are q₀ + E β with a constant E and β = (α, sin θ or travel, 1 − cos θ): modes α that leave
the regions of drives where they are, and the motion of the drives, exact at any angle. Nodes that are glued,
and pins, follow by constant weights, which are part of E.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.constraints import CoordinateMap, Frames
from tauten.model.numerics import Array, Ints
from tauten.model.tetra import Tetrahedra
from tauten.reduction.reduced_body import StateBasisError


@dataclass(frozen=True, slots=True, eq=False)
class DriveMotion:
    """β and its derivatives by (α, θ).

    Attributes:
        modes: number of α.
        drives: m.
        turning: (t,) numbers of the drives that turn about their axes.
        reach: (m,) largest displacement of a node by a unit of each drive [m].
    """

    modes: int
    drives: int
    turning: Ints
    reach: Array

    @property
    def size(self) -> int:
        """Length of β."""
        return self.modes + self.drives + len(self.turning)

    def beta(self, q: Array) -> Array:
        """β (R, …) of coordinates q (r + m, …), one state or several in columns."""
        theta = q[self.modes + self.turning]
        beta = np.concatenate([q, 1.0 - np.cos(theta)])
        beta[self.modes + self.turning] = np.sin(theta)
        return beta

    def jacobian(self, q: Array) -> Array:
        """J (R, r + m) at q (r + m,)."""
        columns = self.modes + self.turning
        J, theta = np.eye(self.size, len(q)), q[columns]
        J[columns, columns] = np.cos(theta)
        J[len(q) + np.arange(len(columns)), columns] = np.sin(theta)
        return J

    def bend(self, q: Array) -> Array:
        """∂²β/∂θ² of each drive: (m, R), two entries a row at most."""
        columns = self.modes + self.turning
        second, theta = np.zeros((self.drives, self.size)), q[columns]
        second[self.turning, columns] = -np.sin(theta)
        second[self.turning, len(q) + np.arange(len(columns))] = np.cos(theta)
        return second


@dataclass(frozen=True, slots=True, eq=False)
class NodeChart:
    """Deviations of a robot made of tetrahedra: displacements of nodes, then coordinates of drives.

    Attributes:
        tetrahedra: the elements, over the nodes that are not fixed.
        rest: (n_q,) configuration of the robot at rest.
        frames: rigid, pinned and drive regions; None: there are none, and
        coordinates: the map from the configuration to the nodes.
    """

    tetrahedra: Tetrahedra
    rest: Array
    frames: Frames | None = None
    coordinates: CoordinateMap | None = None

    @property
    def drives(self) -> int:
        """Number of drive regions, whose coordinates are the last deviations."""
        return 0 if self.frames is None else self.frames.n_drives

    @property
    def free(self) -> Ints:
        """Free nodes among those that are not fixed."""
        nodes = np.arange(self.tetrahedra.m // 3)
        return nodes if self.coordinates is None else self.coordinates.free

    @property
    def in_regions(self) -> Ints:
        """Places of the nodes of rigid and pinned regions among those of all frames."""
        if self.frames is None:
            return np.zeros(0, dtype=np.int64)
        return np.flatnonzero(self.frames.owner < self.frames.n_turning)

    @property
    def moved(self) -> Ints:
        """Nodes that modes move, among those that are not fixed: free ones, then those of regions."""
        if self.frames is None:
            return self.free
        return np.concatenate([self.free, self.frames.nodes[self.in_regions]])

    def deviations(self, q: Array) -> Array:
        """Deviations (m, s) of configurations (n_q, s) [m, rad]; nodes of pinned regions from their pin."""
        if self.frames is None:
            plain: Array = q - self.rest[:, None]
            return plain
        first, chosen = 3 * len(self.free), self.in_regions
        parts = [q[:first] - self.rest[:first, None]]
        if len(chosen) > 0:
            still = self.frames.place(self.rest[first:])[0][chosen].ravel()
            placed = [self.frames.place(one)[0][chosen].ravel() - still for one in q[first:].T]
            parts.append(np.stack(placed, axis=1))
        return np.concatenate([*parts, q[len(q) - self.drives :]])

    def rates(self, q: Array, motion: Array) -> Array:
        """Rates of the deviations (m, k) of velocities (n, k) at a configuration (n_q,)."""
        if self.frames is None:
            return motion
        first, chosen, frames = 3 * len(self.free), self.in_regions, self.frames
        parts = [motion[:first]]
        if len(chosen) > 0:
            owner, own = frames.owner[chosen], motion[first:]
            turns = own[frames.rotations[owner][:, None] + np.arange(3)]  # (c, 3, k)
            levers = frames.place(q[first:])[1][chosen]
            rate = np.cross(turns, levers[:, :, None], axis=1)
            rigid = owner < frames.n_rigid
            rate[rigid] += own[6 * owner[rigid][:, None] + np.arange(3)]
            parts.append(rate.reshape(-1, motion.shape[1]))
        return np.concatenate([*parts, motion[len(motion) - self.drives :]])

    def configuration(self, deviations: Array) -> Array:
        """The configuration (n_q,) nearest to deviations (m,): regions have the rotations that fit best."""
        if self.frames is None:
            plain: Array = self.rest + deviations
            return plain
        q, first, frames = self.rest.copy(), 3 * len(self.free), self.frames
        q[:first] += deviations[:first]
        q[len(q) - self.drives :] = deviations[len(deviations) - self.drives :]
        chosen = self.in_regions
        still = frames.place(self.rest[first:])[0][chosen]
        x = still + deviations[first : len(deviations) - self.drives].reshape(-1, 3)
        for region in range(frames.n_turning):
            own = frames.owner[chosen] == region
            rho, y = frames.offsets[chosen[own]], x[own]
            rigid = region < frames.n_rigid
            about, centre = (rho.mean(axis=0), y.mean(axis=0)) if rigid else np.zeros((2, 3))
            turn, _ = Rotation.align_vectors(y - centre, rho - about)
            place = first + 7 * region
            if rigid:
                q[place : place + 3] = centre - turn.apply(about)
                place += 3
            else:
                place -= 3 * (region - frames.n_rigid)
            q[place : place + 4] = turn.as_quat()[[3, 0, 1, 2]]
        return q

    def velocity(self, q: Array, rates: Array) -> Array:
        """The velocity (n,) with rates of the deviations (m,) at a configuration, in the mean square."""
        if self.frames is None:
            return rates
        first, frames, chosen = 3 * len(self.free), self.frames, self.in_regions
        v = np.zeros(first + frames.n_velocities)
        v[:first] = rates[:first]
        v[len(v) - self.drives :] = rates[len(rates) - self.drives :]
        levers = frames.place(q[first:])[1][chosen]
        moving = rates[first : len(rates) - self.drives].reshape(-1, 3)
        for region in range(frames.n_turning):
            own = frames.owner[chosen] == region
            arms = np.cross(np.eye(3)[None, :, :], levers[own][:, None, :])  # (c, 3, 3), row ω_j
            turning = arms.swapaxes(1, 2).reshape(-1, 3)
            place = first + int(frames.rotations[region])
            if region < frames.n_rigid:
                turning = np.hstack([np.tile(np.eye(3), (int(own.sum()), 1)), turning])
                place -= 3
            found = np.linalg.lstsq(turning, moving[own].ravel(), rcond=None)[0]
            v[place : place + len(found)] = found
        return v

    def places(self, Phi: Array) -> tuple[Array, DriveMotion]:
        """E (3 n_nodes, R), displacements of all nodes that are not fixed, and the motion of β.

        Args:
            Phi: (m, r + d) state modes.

        Raises:
            StateBasisError: the last modes are not those of the drives.
        """
        m, first = self.drives, len(Phi) - self.drives
        r = Phi.shape[1] - m
        if r < 1 or not np.array_equal(Phi[first:], np.eye(m, r + m, r)) or Phi[:first, r:].any():
            raise StateBasisError(
                f"the last {m} modes of this state basis are not the drives of this robot: make it again "
                "from the robot file with `tauten reduce --states`"
            )
        frames, map_ = self.frames, self.coordinates
        if frames is None or map_ is None:
            return Phi, DriveMotion(r, 0, np.zeros(0, dtype=np.int64), np.zeros(0))
        motion = DriveMotion(r, m, np.flatnonzero(frames.turns), frames.reach[frames.n_turning :])
        E = np.zeros((map_.n_nodes, 3, motion.size))
        E[self.moved, :, :r] = Phi[:first, :r].reshape(-1, 3, r)
        second = r + m
        for drive, axis in enumerate(frames.axes):
            inside = frames.owner == frames.n_turning + drive
            nodes, arms = frames.nodes[inside], frames.offsets[inside]
            if not frames.turns[drive]:
                E[nodes, :, r + drive] = axis
                continue
            E[nodes, :, r + drive] = np.cross(axis, arms)
            E[nodes, :, second] = np.cross(axis, np.cross(axis, arms))
            second += 1
        flat = E.reshape(-1, motion.size)
        return np.ascontiguousarray(flat if map_.glue is None else map_.glue @ flat), motion
