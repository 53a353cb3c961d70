"""The robot: what a step uses, whatever its body is made of.

`linearise` gives the system of one step, `rows` the rows of effectors, actuators and contacts,
`advance` the next state, `rest` the initial one. A robot is immutable except for the workspace of its body:
code that steps a robot uses a `fork` of it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic

import numpy as np
from typing_extensions import TypeVar

from tauten.model.actuators import ActuatorRows
from tauten.model.body import Body
from tauten.model.contact import ContactSet, ObstaclePoses, contact_rows
from tauten.model.effectors import Effectors
from tauten.model.layout import Layout, row_layout
from tauten.model.numerics import Array, Ints
from tauten.model.points import Motion
from tauten.model.rows import NO_EFFECTOR_ROWS, ContactRows, PairSlots
from tauten.model.signals import Actuators, EffectorLayout, Limits
from tauten.model.state import RobotRows, State
from tauten.model.system import Integration, System

B_co = TypeVar("B_co", bound=Body, covariant=True, default=Body)
Other = TypeVar("Other", bound=Body)
P = TypeVar("P")


@dataclass(frozen=True, eq=False)
class Robot(Generic[B_co]):
    """A soft robot: a body, what drives it, what is to reach targets, and what may touch.

    Robots can be pickled, the workspace of their body without its factors.

    Attributes:
        name: in keys and messages.
        frame: frame id of its positions on the wire.
        digest: what its contact forces depend on, from its files alone, see
            `tauten.model.schema.robot_digest`.
        tolerance: depth of penetration from which a unit column is added for a contact candidate [m].
        actuators: names, kinds and laws of its actuators, in the order of λ_a.
        limits: limits of their efforts, positions and rates.
        effectors: what is to reach targets, over points of the body.
        contacts: candidates and the surfaces they may touch, and
        vertices: the points of these surfaces, of the type that the body has.
        body: its mechanics.
        digests_of_fewer: digests of this robot with the first 0, 1, 2, ... of its contacts.
    """

    name: str
    frame: str
    digest: str
    tolerance: float
    actuators: Actuators
    limits: Limits
    effectors: Effectors[Any]
    contacts: ContactSet
    vertices: Any
    body: B_co
    digests_of_fewer: tuple[str, ...] = ()

    @property
    def effector_names(self) -> tuple[str, ...]:
        """Names of the effectors, in row order."""
        return self.effectors.layout.names

    @property
    def gravity(self) -> Array:
        """Gravity that acts on it: (3,) [m/s²]."""
        return self.body.gravity

    @cached_property
    def integration(self) -> Integration:
        """Time step and scheme."""
        return self.body.integration

    @cached_property
    def h(self) -> float:
        """Time step [s]."""
        return self.body.h

    @cached_property
    def n(self) -> int:
        """Free degrees of freedom, the length of v."""
        return self.body.n

    @cached_property
    def n_a(self) -> int:
        """Actuators; couplings count as one."""
        return len(self.actuators)

    @property
    def n_c(self) -> int:
        """Contact candidates, slots of λ_c."""
        return self.contacts.n_slots

    @property
    def n_nodes(self) -> int:
        """Nodes of its body, fixed ones included."""
        return self.body.n_nodes

    @cached_property
    def size(self) -> float:
        """Largest distance between two nodes at rest [m]."""
        return self.body.size

    @cached_property
    def part_size(self) -> float:
        """Size of the largest part [m]; of the body itself where it has no parts."""
        return self.body.part_size

    @cached_property
    def layout(self) -> Layout:
        """Where the rows of effectors, actuators and contacts are in a step."""
        return row_layout(self.effector_layout.n_rows, self.n_a)

    @cached_property
    def effector_layout(self) -> EffectorLayout:
        """Kinds of the effectors, their rows, goal values and weights."""
        return self.effectors.layout

    @property
    def pairs(self) -> tuple[PairSlots, ...]:
        """Contact pairs in the order of their slots."""
        return self.contacts.pair_slots

    @cached_property
    def actuator_set(self) -> ActuatorRows:
        """Rows of the actuators."""
        return self.body.actuator_set

    @property
    def triangles(self) -> Ints:
        """Its surface as triples of `points`, for drawing: (t, 3)."""
        return self.body.triangles

    def fork(self) -> Robot[B_co]:
        """The same robot with a separate workspace."""
        return dataclasses.replace(self, body=self.body.fork())

    def loaded(self, gravity: Array, effector_force: Array) -> Robot[B_co]:
        """The robot under another gravity (3,) [m/s²] and forces on its effectors (3 p,) [N]."""
        body = self.body.loaded(np.asarray(gravity), np.asarray(effector_force), self.effectors)
        return dataclasses.replace(self, body=body)

    @property
    def obstacles(self) -> ObstaclePoses:
        """Where its obstacles are at the end of the step that is taken."""
        return self.contacts.poses

    def with_obstacles(self, poses: ObstaclePoses) -> Robot[B_co]:
        """The same robot with its obstacles in other poses."""
        known = poses is self.contacts.poses or not poses.poses
        return self if known else self.with_contacts(self.contacts.placed(poses))

    def with_contacts(self, contacts: ContactSet) -> Robot[B_co]:
        """The same robot with its contacts in another place, or another step."""
        return dataclasses.replace(self, contacts=contacts)

    def later(self, seconds: float) -> Robot[B_co]:
        """The same robot with its obstacles where they are a time later [s]."""
        poses = self.contacts.poses
        return self.with_obstacles(poses.after(seconds)) if poses.poses else self

    def stepping(
        self,
        state: State,
        seconds: float | None = None,
        end: State | None = None,
        far: bool = False,
        later: float = 0.0,
    ) -> Robot[B_co]:
        """The same robot in a step: what touches obstacles or other bodies stays on their side where it was.

        Args:
            state: where the step starts.
            seconds: its length, by default the time step; the obstacles are where they are at its end.
            end: where the step leads without contact and is linearised; None: where the velocity leads, and
                contacts are detected where it starts.
            far: whether what is beyond the alarm distance where it starts may touch at its end.
            later: how much later the obstacles are where they are at its end [s].
        """
        if later != 0.0 and self.contacts.poses.poses:
            return self.later(later).stepping(state, seconds, end, far)
        poses, h = self.contacts.poses, self.h if seconds is None else seconds
        of_obstacles = bool(poses.poses if far else self.contacts.sided)
        if not (of_obstacles or self.contacts.loose):
            return self
        linearised_here = end is None
        if end is None:
            v = self.body.floating_velocity(state) if self.integration.static else state.v
            end = self.advance(state, v, h) if v.any() else state
        if end is state and not poses.change:
            return self.with_contacts(self.contacts.placed(poses))
        x, led = (self.motion(at).placed(self.vertices).y for at in (state, end))
        ends = (led, x) if linearised_here else (led,)
        return self.with_contacts(self.contacts.stepping(x, ends, poses.after(-h), far))

    def with_integration(self, integration: Integration) -> Robot[B_co]:
        """The same robot with another time step or scheme."""
        return dataclasses.replace(self, body=self.body.with_integration(integration))

    def with_body(
        self, body: Other, effectors: Effectors[P], contacts: ContactSet, vertices: P
    ) -> Robot[Other]:
        """The same robot with another body, with effectors and contacts over its points."""
        return Robot(
            self.name, self.frame, self.digest, self.tolerance, self.actuators, self.limits,
            effectors, contacts, vertices, body, self.digests_of_fewer,
        )  # fmt: skip

    @property
    def floats(self) -> bool:
        """Whether nothing holds a part of it, which moves by its inertia in quasi-static steps too."""
        parts = self.body.part_robots or (self,)
        return any(part.body.floats for part in parts)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        return self.body.rest()

    def motion(self, state: State) -> Motion[Any]:
        """Where the points of the body are at a state, and how they move with the unknowns."""
        return self.body.motion(state)

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins: (P, 3) [m]."""
        return self.body.points(state)

    def effector(self, state: State) -> Array:
        """Positions of the effectors: (p, 3) [m]; of a distance, length or volume, of its points' mean."""
        return self.effectors.positions(self.motion(state))

    def effector_values(self, state: State) -> Array:
        """Goal values of the effectors: (n_v,), see `EffectorLayout`."""
        return self.effectors.values(self.motion(state))

    def candidates(self, state: State) -> Array:
        """Positions of the contact candidates: (n_c, 3) [m]."""
        return self.contacts.positions(self.motion(state).placed(self.vertices).y)

    def actuator_segments(self, state: State) -> Array:
        """Segments by which actuators are drawn: (s, 2, 3) [m].

        Of cables both ends of every straight piece; of forces, drives and slides where they act, and the
        point one metre along their direction or axis.
        """
        return self.actuator_set.segments(self.motion(state))

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration at a state [m]."""
        return self.body.displacement(state, dq)

    def rows(self, state: State, contacts: bool = True, effectors: bool = True) -> RobotRows:
        """Rows of effectors, actuators and contacts at a state; none of what is left out."""
        motion, touching = self.body.motion(state), self.contacts
        if contacts:
            placed = motion.placed(self.vertices)
            found = contact_rows(touching.detect(placed.y), placed, touching.frictional)
        else:
            none = motion.units(np.zeros(0, dtype=np.int64))
            found = ContactRows.out_of_range(none, self.n_c, touching.frictional)
        reaching = self.effectors.rows(motion) if effectors else NO_EFFECTOR_ROWS
        return RobotRows(reaching, self.actuator_set.rows(motion), found)

    def spring_rows(self, state: State) -> Array:
        """B (s, n) of the springs between motors at rest and what they move, which add Bᵀ B to K [√(N/m)].

        Cables without tension at rest are slack.
        """
        laws, none = self.actuators.laws, np.zeros(self.n_a)
        if laws.springs is None:
            return np.zeros((0, self.n))
        flexibility, tension = laws.springs.flexibility, laws.springs.effort(none, none)
        (acting,) = ((flexibility > 0.0) & (laws.bilateral | (tension > 0.0))).nonzero()
        rows = self.actuator_set.rows(self.motion(state)).chosen(acting)
        found: Array = rows / np.sqrt(flexibility[acting])[:, None]
        return found

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (n,) [N], and K = −∂force/∂q as the body stores it.

        Args:
            state: where to evaluate.
            effort: (n_a,) efforts of the actuators, whose curvature enters the tangent; None: none does.
            exact: the exact derivative, which is not always positive definite.
        """
        return self.body.forces(state, effort, exact)

    def linearise(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from this state: A, b, v_free (7)-(10).

        Args:
            state: where the step starts.
            effort: (n_a,) last efforts of the actuators, for the curvature they add to A.
            integration: another scheme than the robot's.

        Raises:
            FactorisationError: A is not positive definite (a state that has blown up).
        """
        return self.body.linearise(state, effort, integration or self.integration)

    def static_system(self, state: State, effort: Array | None = None) -> System:
        """The system of a quasi-static step, whatever the scheme of the robot; see `linearise`."""
        return self.linearise(state, effort, dataclasses.replace(self.integration, static=True))

    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, with the velocity v and moved by h v.

        Args:
            state: before the step.
            v: (n,) velocity after it [m/s].
            h: its length [s].
            straight: whether nodes of beams move along straight lines where they could move along arcs.
        """
        return self.body.advance(state, v, h, straight)

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""
        return self.body.potential(state)

    def energy(self, state: State) -> float:
        """Potential and kinetic energy, and that stored in viscous materials [J]."""
        body = self.body
        return body.potential(state) + body.kinetic_energy(state) + body.stored(state)
