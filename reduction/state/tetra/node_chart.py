"""Which nodes of a robot modes move, and what drives, glue, pins, rigid regions and beams make of that.

Modes move the free nodes. A rotation of a drive's region about an axis a is linear in sin θ and 1 − cos θ,

    x = x₀ + sin θ a x ρ + (1 − cos θ) a x (a x ρ),                                           (T6)

and so is that of a frame in its rotation, x = c + R ρ. Frames of rigid and pinned regions keep these as
coordinates: modes of displacement would strain a rigid region where it turns, which then resists as soft
material does, and stretch a beam where it bends. All nodes are q₀ + E β with a constant E (`OwnMotion`):
modes α that leave the regions of drives and other frames where they are, and the motion of these, exact at
any angle. Nodes that are glued, and pins, follow by constant weights, which are part of E.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.constraints import CoordinateMap, Frames
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.tetra import Tetrahedra
from tauten.reduction.reduced_body import StateBasisError
from tauten.reduction.state.tetra.lifting import Lifting
from tauten.reduction.state.tetra.own_motion import OwnMotion

NONE = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class NodeChart:
    """Deviations of a robot made of tetrahedra: displacements of nodes, then its own coordinates.

    Own coordinates are those of `OwnMotion` after the modes: drives, pins of beams, centres and rotation
    vectors of the frames of rigid and pinned regions.

    Attributes:
        tetrahedra: the elements, over the nodes that are not fixed.
        rest: (n_q,) configuration of the robot at rest.
        frames: rigid, pinned and drive regions; None: there are none, and
        coordinates: the map from the configuration to the nodes.
        lifting: pins of beams; None: there are none.
        pulled: nodes that the cables and chambers depend on, among those that are not fixed.
    """

    tetrahedra: Tetrahedra
    rest: Array
    frames: Frames | None = None
    coordinates: CoordinateMap | None = None
    lifting: Lifting | None = None
    pulled: Ints = field(default_factory=lambda: NONE)

    @property
    def drives(self) -> int:
        """Number of drive regions."""
        return 0 if self.frames is None else self.frames.n_drives

    @property
    def centred(self) -> int:
        """Number of frames that have a centre of their own: those of rigid regions, which are first."""
        return 0 if self.frames is None else self.frames.n_rigid

    @property
    def turned(self) -> int:
        """Number of frames that have a rotation of their own: those of rigid and of pinned regions."""
        return 0 if self.frames is None else self.frames.n_turning

    @property
    def placed(self) -> int:
        """Components of the displacements of pins and centres."""
        pins = 0 if self.lifting is None else self.lifting.W.shape[0]
        return 3 * (pins + self.centred)

    @property
    def own(self) -> int:
        """Number of the last deviations, which are coordinates of their own."""
        return self.drives + self.placed + 3 * self.turned

    @property
    def moved(self) -> Ints:
        """Nodes that modes move, among those that are not fixed: those that follow no frame and no glue."""
        nodes = np.arange(self.tetrahedra.m // 3)
        return nodes if self.coordinates is None else self.coordinates.free

    def frame_columns(self, frames: Frames) -> tuple[Ints, Ints, Ints, Ints]:
        """Places of centres (c, 3) and rotations of frames (f, 4) in q, and (c, 3), (f, 3) in v of states."""
        first, number = 3 * len(self.moved), np.arange(self.turned)
        pinned = 7 * frames.n_rigid + 4 * (number - frames.n_rigid)
        quaternion = first + np.where(number < frames.n_rigid, 7 * number + 3, pinned)
        three, rigid = np.arange(3), np.arange(self.centred)[:, None]
        return (
            first + 7 * rigid + three,
            quaternion[:, None] + np.arange(4),
            first + 6 * rigid + three,
            first + frames.rotations[number][:, None] + three,
        )

    def deviations(self, q: Array) -> Array:
        """Deviations (m, s) of configurations (n_q, s) [m, rad]."""
        if self.frames is None:
            plain: Array = q - self.rest[:, None]
            return plain
        first = 3 * len(self.moved)
        own = [q[len(q) - self.drives :]]
        if self.turned > 0:
            centres, turns, _, _ = self.frame_columns(self.frames)
            rotations = q[turns].transpose(2, 0, 1).reshape(-1, 4)[:, [1, 2, 3, 0]]  # (s f, 4)
            vectors = Rotation.from_quat(rotations).as_rotvec().reshape(q.shape[1], -1).T
            own += [(q[centres] - self.rest[centres][..., None]).reshape(-1, q.shape[1]), vectors]
        return self.lowered(q[:first] - self.rest[:first, None], own)

    def lowered(self, u: Array, own: list[Array]) -> Array:
        """Deviations, or their rates, of displacements u (3 k, s) and of drives, centres and rotations."""
        if self.lifting is None:
            return np.concatenate([u, *own])
        d = self.lifting.pins(u)
        return np.concatenate([u - self.lifting.L @ d, own[0], d, *own[1:]])

    def lifted(self, deviations: Array) -> Array:
        """Displacements (3 k,) of the nodes that modes move, of deviations (m,) or of rates of these."""
        u: Array = deviations[: len(deviations) - self.own]
        if self.lifting is None:
            return u
        first = len(u) + self.drives
        return u + self.lifting.L @ deviations[first : first + self.lifting.L.shape[1]]

    def rates(self, motion: Array) -> Array:
        """Rates of the deviations (m, k) of velocities (n, k); of rotation vectors angular velocities."""
        if self.frames is None:
            return motion
        own = [motion[len(motion) - self.drives :]]
        if self.turned > 0:
            own += [motion[columns.ravel()] for columns in self.frame_columns(self.frames)[2:]]
        return self.lowered(motion[: 3 * len(self.moved)], own)

    def configuration(self, deviations: Array) -> Array:
        """The configuration (n_q,) of deviations (m,)."""
        if self.frames is None:
            plain: Array = self.rest + deviations
            return plain
        q, first = self.rest.copy(), 3 * len(self.moved)
        own = deviations[len(deviations) - self.own :]
        q[:first] += self.lifted(deviations)
        q[len(q) - self.drives :] = own[: self.drives]
        if self.turned > 0:
            centres, turns, _, _ = self.frame_columns(self.frames)
            last = self.drives + self.placed
            q[centres] += own[last - 3 * len(centres) : last].reshape(-1, 3)
            rotations = Rotation.from_rotvec(own[last:].reshape(-1, 3))
            q[turns] = rotations.as_quat()[:, [3, 0, 1, 2]]
        return q

    def velocity(self, rates: Array) -> Array:
        """The velocity (n,) with rates of the deviations (m,), see `rates`."""
        if self.frames is None:
            return rates
        first = 3 * len(self.moved)
        v, own = np.zeros(first + self.frames.n_velocities), rates[len(rates) - self.own :]
        v[:first] = self.lifted(rates)
        v[len(v) - self.drives :] = own[: self.drives]
        if self.turned > 0:
            _, _, centres, turns = self.frame_columns(self.frames)
            last = self.drives + self.placed
            v[centres] = own[last - 3 * len(centres) : last].reshape(-1, 3)
            v[turns] = own[last:].reshape(-1, 3)
        return v

    def places(self, Phi: Array) -> tuple[Array, OwnMotion]:
        """E (3 n_nodes, R), displacements of all free nodes, of modes Phi (m, r + o), and the motion of β.

        Raises:
            StateBasisError: the last modes are not the robot's own coordinates.
        """
        own, first = self.own, len(Phi) - self.own
        r = Phi.shape[1] - own
        if (
            r < 1
            or not np.array_equal(Phi[first:], np.eye(own, r + own, r))
            or Phi[:first, r:].any()
        ):
            raise StateBasisError(
                f"the last {own} modes of this state basis are not the own coordinates of this robot (of "
                "drives, rigid regions, pins, hinges and beams): make it again from the robot "
                "file with `tauten reduce --states`"
            )
        frames, map_ = self.frames, self.coordinates
        if frames is None or map_ is None:
            return Phi, OwnMotion(r, 0, NONE, 0, 0, np.zeros(0), r, r)
        turning = np.flatnonzero(frames.turns)
        reach = np.concatenate([frames.reach[frames.n_turning :], frames.reach[: frames.n_turning]])
        sizes = (r, self.drives, turning, self.placed, self.turned, reach)
        R = OwnMotion(*sizes, 0, 0).size
        E = np.zeros((map_.n_nodes, 3, R))
        E[self.moved, :, :r] = Phi[:first, :r].reshape(-1, 3, r)
        if self.lifting is not None:
            L = self.lifting.L
            E[self.moved, :, r + self.drives : r + self.drives + L.shape[1]] = L.reshape(
                -1, 3, L.shape[1]
            )
        self.place_drives(frames, E, r)
        self.place_frames(frames, E, r)
        flat = E.reshape(-1, R)
        flat = np.ascontiguousarray(flat if map_.glue is None else map_.glue @ flat)
        if self.turned == 0:
            return flat, OwnMotion(*sizes, R, R)
        by_elements = self.touched(flat, self.element_nodes, r)
        by_pulls = self.touched(flat, self.pulled, r)
        order = np.argsort(np.where(by_elements, 0, np.where(by_pulls, 1, 2)), kind="stable")
        pulled = int((by_elements | by_pulls).sum())
        motion = OwnMotion(*sizes, int(by_elements.sum()), pulled, order)
        return np.ascontiguousarray(flat[:, order]), motion

    @property
    def element_nodes(self) -> Ints:
        """Nodes of the elements, among those that are not fixed."""
        domains = self.tetrahedra.elements.domains
        nodes = np.unique(np.concatenate([NONE, *(part.nodes.ravel() for part in domains)]))
        first: Ints = self.tetrahedra.dof[nodes]
        return first[first >= 0] // 3

    def touched(self, E: Array, nodes: Ints, r: int) -> Bools:
        """Which columns of E (3 n_nodes, R) move some nodes, or are modes: (R,).

        Args:
            E: displacements.
            nodes: the nodes.
            r: number of modes.
        """
        found: Bools = np.any(E.reshape(-1, 3, E.shape[1])[nodes], axis=(0, 1))
        found[:r] = True
        return found

    def place_drives(self, frames: Frames, E: Array, r: int) -> None:
        """The displacements of the regions of drives into E (n_nodes, 3, R).

        Args:
            frames: the frames.
            E: written.
            r: number of modes.
        """
        second = r + self.drives + self.placed
        for drive, axis in enumerate(frames.axes):
            inside = frames.owner == frames.n_turning + drive
            nodes, arms = frames.nodes[inside], frames.offsets[inside]
            if not frames.turns[drive]:
                E[nodes, :, r + drive] = axis
                continue
            E[nodes, :, r + drive] = np.cross(axis, arms)
            E[nodes, :, second] = np.cross(axis, np.cross(axis, arms))
            second += 1

    def place_frames(self, frames: Frames, E: Array, r: int) -> None:
        """The displacements of rigid and pinned regions into E (n_nodes, 3, R).

        Args:
            frames: the frames.
            E: written.
            r: number of modes.
        """
        three, centre = np.arange(3), r + self.drives + self.placed - 3 * self.centred
        first = r + self.drives + self.placed + int(frames.turns.sum())
        for region in range(self.turned):
            inside = frames.owner == region
            nodes, rho = frames.nodes[inside], frames.offsets[inside]
            if region < frames.n_rigid:
                E[nodes[:, None], three, centre + 3 * region + three] = 1.0
            columns = first + 9 * region + 3 * three[:, None] + three  # (i, j)
            E[nodes[:, None, None], three[:, None], columns] = rho[:, None, :]

    def excess(self, motion: OwnMotion, chosen: Bools | None = None) -> Array:
        """What of Eᵀ M E (R, R), of `chosen` (3 n_nodes,) or all displacements, only lumped masses have."""
        found, frames = np.zeros((motion.size, motion.size)), self.frames
        if frames is None:
            return found
        moments = frames.excess.copy()
        if chosen is not None:
            moments[frames.owner[~chosen[3 * frames.nodes]]] = 0.0
        first, three, about = motion.straight, np.arange(3), frames.inertia_about_axes(moments)
        for place, drive in enumerate(motion.turning):
            for column in (motion.modes + drive, first + place):
                found[column, column] = about[drive]
        first += len(motion.turning)
        for region in range(self.turned):
            for row in first + 9 * region + 3 * three:
                found[np.ix_(row + three, row + three)] = moments[region]
        return found if motion.order is None else found[np.ix_(motion.order, motion.order)]
