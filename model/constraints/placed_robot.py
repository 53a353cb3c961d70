"""Where the nodes of a robot with constraints are, and what is drawn of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators import Coupling
from tauten.model.body import SparseRobot
from tauten.model.constraints.coordinates import CoordinateMap
from tauten.model.constraints.frames import Frames
from tauten.model.constraints.joints import FrameJoints
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Ints
from tauten.model.robot import State
from tauten.model.tetra import TetRobot


@dataclass(frozen=True, slots=True)
class PlacedRobot(SparseRobot):
    """The coordinates of a robot some of whose nodes follow others, and the places of its nodes.

    State.q has the positions of free nodes, position and unit quaternion of each rigid region, the unit
    quaternion of each pinned one, and the angle or travel of each drive; State.v has three, six, three and
    one numbers for them. A node of a beam is a rigid region of four nodes: itself and three beside it.

    Attributes, beside those of every sparse robot:
        raw: the same robot without constraints or couplings, over all nodes that are not fixed.
        frames: rigid regions and drives.
        coordinates: the map to the nodes.
        coupling: of all actuators, drives included; None: each is driven alone.
        drive_places: (m,) numbers of the actuated drives among all single actuators.
        driven: (m,) their numbers among the drive regions; hinges are drive regions without an actuator.
        joints: beams and springs between frames; None: there are none.
    """

    raw: TetRobot
    frames: Frames
    coordinates: CoordinateMap
    coupling: Coupling | None
    drive_places: Ints
    driven: Ints
    joints: FrameJoints | None

    @property
    def mesh(self) -> TetMesh:
        """Linear tetrahedra on all nodes at rest."""
        return self.raw.mesh

    @property
    def size(self) -> float:
        """Diagonal of the bounding box at rest [m]."""
        return self.raw.size

    @property
    def n_nodes(self) -> int:
        """Nodes, fixed ones included."""
        return self.raw.n_nodes

    @property
    def n_elements(self) -> int:
        """Tetrahedra, of smoothed elements those that are averaged, and beams."""
        return self.raw.n_elements

    @property
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""
        return self.raw.triangles if self.joints is None else self.joints.drawn(self.mesh)

    def turns(self, state: State) -> Array:
        """Rotations of the nodes of beams: (b, 4), unit quaternions."""
        assert self.joints is not None
        return self.frames.quaternions(state.q[3 * len(self.coordinates.free) :])[
            self.joints.turning
        ]

    def rest(self) -> State:
        """The stress-free state at standstill."""
        free = self.raw.rest().q.reshape(-1, 3)[self.coordinates.free]
        return State(np.concatenate([free.ravel(), self.frames.rest()]), np.zeros(self.n))

    def placed(self, state: State) -> tuple[State, Array]:
        """The state of the nodes, and the levers of `Frames.place`: (k, 3) [m]."""
        first, map_ = 3 * len(self.coordinates.free), self.coordinates
        x = np.zeros((map_.n_nodes, 3))
        x[map_.free] = state.q[:first].reshape(-1, 3)
        x[self.frames.nodes], levers = self.frames.place(state.q[first:])
        q = map_.followed(x.ravel())
        return State(q, np.zeros(len(q))), levers

    def nodes(self, state: State) -> Array:
        """Positions of all nodes, fixed ones included: (n_nodes, 3) [m]."""
        return self.raw.nodes(self.placed(state)[0])

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.raw.effector(self.placed(state)[0])

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,)."""
        return self.raw.effector_values(self.placed(state)[0])

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins, here all nodes and the outlines of beams: (P, 3) [m]."""
        x = self.nodes(state)
        return x if self.joints is None else self.joints.points(x, self.turns(state))

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.raw.candidates(self.placed(state)[0])

    @property
    def segment_owners(self) -> Ints:
        """The actuator of every segment that `actuator_segments` gives: (s,)."""
        others = self.member_numbers(self.raw.actuator_set.segment_members)
        return self.motors(np.concatenate([others, self.drive_places]))

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each of `triangles` encloses, −1 where none: (t,)."""
        return self.motors(
            self.member_numbers(self.raw.actuator_set.chamber_members(self.triangles))
        )

    def actuator_segments(self, state: State) -> Array:
        """Segments by which actuators are drawn: (s, 2, 3) [m], see `Robot`."""
        raw_state = self.placed(state)[0]
        drives = self.frames.drive_segments(state.q[3 * len(self.coordinates.free) :])
        return np.concatenate([self.raw.actuator_segments(raw_state), drives[self.driven]])

    def member_numbers(self, others: Ints) -> Ints:
        """Numbers among all single actuators, of numbers (m,) among those that are no drives; −1 remains."""
        count = self.raw.actuator_set.n_members + len(self.drive_places)
        numbers: Ints = np.append(np.setdiff1d(np.arange(count), self.drive_places), -1)[others]
        return numbers

    def motors(self, members: Ints) -> Ints:
        """The actuators (m,) that drive single actuators (m,); −1 remains −1."""
        return members if self.coupling is None else self.coupling.motors_of(members)
