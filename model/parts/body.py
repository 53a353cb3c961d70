"""The body of a robot of several parts: A is block-diagonal, each block is that of a part.

    W = h² Σ_p H_p A_p⁻¹ H_pᵀ

A part's forces, matrices and states are computed by its own body, in the part's own frame, where gravity is
turned instead of the part. Parts act on each other through rows only: contact.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from tauten.model.body import Body, Turning
from tauten.model.effectors import Effectors
from tauten.model.numerics import Array, Factorisation, Ints
from tauten.model.parts.actuators import PartsActuators
from tauten.model.parts.factors import block_factors, joined_system
from tauten.model.parts.motion import PartsMotion, PartsPoints, slices
from tauten.model.parts.part import Assembly, Part
from tauten.model.parts.spans import (
    PartsAssembled,
    Spans,
    advanced,
    joined_forces,
    joined_state,
    scheme_of_part,
    start_of_part,
)
from tauten.model.robot import Robot
from tauten.model.state import Assembled, Augmentation, State, StepStart
from tauten.model.system import Integration, System


@dataclass(frozen=True, slots=True, eq=False)
class PartsBody(Body[PartsPoints]):
    """A body of several parts. A matrix is stored as the values of every part, one after the other.

    Attributes, beside those of every body:
        parts: the parts.
        assembly: what makes one robot of them.
        spans: where their numbers are.
        extent: largest distance between two nodes of all parts at rest [m].
        bodies: the body of each part.
    """

    actuator_set: PartsActuators
    parts: tuple[Part, ...]
    assembly: Assembly
    spans: Spans
    extent: float
    bodies: tuple[Body[Any], ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "bodies", tuple(part.robot.body for part in self.parts))

    @property
    def part_robots(self) -> tuple[Robot, ...]:
        """The robots of its parts."""
        return tuple(part.robot for part in self.parts)

    @property
    def n(self) -> int:
        """Free degrees of freedom of all parts."""
        return int(self.spans.columns[-1].stop)

    @property
    def n_nodes(self) -> int:
        """Nodes of all parts, fixed ones included."""
        return sum(body.n_nodes for body in self.bodies)

    @property
    def n_elements(self) -> int:
        """Finite elements of all parts."""
        return sum(body.n_elements for body in self.bodies)

    @property
    def moving_mass(self) -> float:
        """Mass of all nodes that are not fixed [kg]."""
        return sum(body.moving_mass for body in self.bodies)

    @property
    def size(self) -> float:
        """Largest distance between two nodes of all parts at rest [m]."""
        return self.extent

    @property
    def part_size(self) -> float:
        """Size of the largest part [m]."""
        return max(body.part_size for body in self.bodies)

    @property
    def linear_solver(self) -> str:
        """Names of the solvers of all parts."""
        return " and ".join(dict.fromkeys(body.linear_solver for body in self.bodies))

    @property
    def stored_shape(self) -> tuple[int, ...]:
        """Shape of the values of a matrix: (Σ,)."""
        return (int(self.spans.stored[-1].stop),)

    @property
    def triangles(self) -> Ints:
        """Surfaces of all parts as triples of `points`: (t, 3)."""
        counts = [len(part.robot.points(part.robot.rest())) for part in self.parts]
        pairs = zip(self.bodies, slices(counts), strict=True)
        return np.concatenate([body.triangles + span.start for body, span in pairs])

    @property
    def chamber_owners(self) -> Ints:
        """The actuator whose chamber each triangle of the surface encloses, −1 where none: (t,)."""
        pairs = zip(self.bodies, self.actuator_set.spans, strict=True)
        found = [(body.chamber_owners, span.start) for body, span in pairs]
        owners = np.concatenate([np.where(own >= 0, own + first, -1) for own, first in found])
        return self.actuator_set.motors(owners)

    @property
    def of_objects(self) -> Ints:
        """Numbers (m,) of the triangles of parts without an actuator; none where no part has one."""
        moved = np.array([body.actuator_set.n_a > 0 for body in self.bodies])
        counts = [len(body.triangles) for body in self.bodies]
        return np.flatnonzero(np.repeat(~moved & moved.any(), counts))

    @property
    def idle_parts(self) -> tuple[str, ...]:
        """Names of the parts that have neither actuators nor effectors."""
        return tuple(p.name for p in self.parts if p.robot.layout.contacts.start == 0)

    @property
    def part_names(self) -> tuple[str, ...]:
        """Names of the parts."""
        return tuple(part.name for part in self.parts)

    @property
    def components(self) -> Ints:
        """Number of the set of each unknown (n,): those of every part."""
        found, first = [], 0
        for body in self.bodies:
            found.append(body.components + first)
            first = int(found[-1].max(initial=first - 1)) + 1
        return np.concatenate(found)

    def unknowns_of(self, part: str) -> slice:
        """The unknowns of a part."""
        return self.spans.columns[self.part_names.index(part)]

    def surface_points(self, vertices: Ints) -> PartsPoints:
        """No points: surfaces belong to the parts."""
        raise NotImplementedError("surfaces belong to the parts of a robot")

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins: (P, 3) [m]."""
        pairs = zip(self.parts, self.states(state), strict=True)
        return np.concatenate(
            [part.placement.points(part.robot.points(own)) for part, own in pairs]
        )

    def fork(self) -> PartsBody:
        """The same body with separate workspaces."""
        parts = tuple(part.made_of(part.robot.fork()) for part in self.parts)
        return dataclasses.replace(self, parts=parts)

    def with_integration(self, integration: Integration) -> PartsBody:
        """The same body with another time step; static parts remain so where the scheme of all does."""
        pairs = zip(self.parts, self.schemes(integration), strict=True)
        parts = tuple(part.made_of(part.robot.with_integration(own)) for part, own in pairs)
        return dataclasses.replace(self, parts=parts, integration=integration)

    def loaded(
        self, gravity: Array, effector_force: Array, effectors: Effectors[PartsPoints]
    ) -> PartsBody:
        """The body under other loads, see `Body`."""
        forces = effector_force.reshape(-1, 3)
        spans = slices([len(part.robot.effector_names) for part in self.parts])
        parts = tuple(
            part.made_of(
                part.robot.loaded(
                    part.placement.into_part(gravity),
                    part.placement.into_part(forces[span]).ravel(),
                )
            )
            for part, span in zip(self.parts, spans, strict=True)
        )
        return dataclasses.replace(self, gravity=gravity, parts=parts)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        return joined_state([body.rest() for body in self.bodies])

    def states(self, state: State) -> list[State]:
        """The state of each part."""
        if len(self.bodies) == 1:
            return [state]
        spans = self.spans
        every = zip(spans.configuration, spans.columns, spans.memory, strict=True)
        return [State(state.q[q], state.v[v], state.memory[memory]) for q, v, memory in every]

    def each(self, state: State) -> Iterator[tuple[Body[Any], State]]:
        """The body of each part with its state."""
        return zip(self.bodies, self.states(state), strict=True)

    def values(self, stored: Array) -> list[Array]:
        """Values of a matrix of each part, as its body stores them."""
        pairs = zip(self.spans.stored, self.spans.shapes, strict=True)
        return [stored[span].reshape(shape) for span, shape in pairs]

    def motion(self, state: State) -> PartsMotion:
        """Where the points of all parts are at a state."""
        motions = tuple(body.motion(own) for body, own in self.each(state))
        return PartsMotion(motions, self.spans.columns)

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration at a state [m]."""
        every = zip(self.bodies, self.states(state), self.spans.columns, strict=True)
        return max(body.displacement(own, dq[span]) for body, own, span in every)

    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, of every part by its body, see `Robot`."""
        every = zip(self.bodies, self.states(state), self.spans.columns, strict=True)
        found = [advanced(body, own, v[span], h, straight) for body, own, span in every]
        return joined_state(found)

    def floating_velocity(self, state: State) -> Array:
        """Velocity (n,) of what floats in any part, zero of all else, see `Body`."""
        return np.concatenate([body.floating_velocity(own) for body, own in self.each(state)])

    def remembering(self, before: State, after: State, h: float) -> State:
        """The state at the end of a step, with the memory of every part there, see `Body`."""
        every = zip(self.bodies, self.states(before), self.states(after), strict=True)
        return joined_state([body.remembering(one, other, h) for body, one, other in every])

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (n,) [N], and K of every part, see `Robot`."""
        every = zip(self.bodies, self.states(state), self.actuator_set.split(effort), strict=True)
        found = [body.forces(own, part, exact) for body, own, part in every]
        force, K = zip(*found, strict=True)
        return np.concatenate(force), np.concatenate([values.ravel() for values in K])

    def schemes(self, given: Integration | None) -> list[Integration]:
        """The scheme of each part in a step of all, see `scheme_of_part`."""
        whole, taken = self.integration, given or self.integration
        aheads = taken.aheads or (taken.ahead,) * len(self.bodies)
        pairs = zip(self.bodies, aheads, strict=True)
        return [
            scheme_of_part(body.integration, whole, taken, ahead, body.floats)
            for body, ahead in pairs
        ]

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> PartsAssembled:
        """Forces and tangents of every part at a state, see `Body`."""
        efforts, schemes = self.actuator_set.split(effort), self.schemes(integration)
        every = zip(self.bodies, self.states(state), efforts, schemes, strict=True)
        found = tuple(body.assemble(own, lam, one) for body, own, lam, one in every)
        return PartsAssembled(state, effort, found)

    def linearise(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step of all parts from a state, see `Robot`."""
        efforts, schemes = self.actuator_set.split(effort), self.schemes(integration)
        every = zip(self.bodies, self.states(state), efforts, schemes, strict=True)
        found = [body.linearise(own, lam, one) for body, own, lam, one in every]
        return joined_system(self.spans, found)

    def system(
        self, assembled: Assembled, integration: Integration, added: Augmentation = None
    ) -> System:
        """The system of one step of all parts, see `Body`."""
        assert isinstance(assembled, PartsAssembled)
        more = added if isinstance(added, tuple) else (None,) * len(self.bodies)
        every = zip(self.bodies, assembled.parts, self.schemes(integration), more, strict=True)
        found = [body.system(own, scheme, one) for body, own, scheme, one in every]
        return joined_system(self.spans, found)

    def factors(self) -> Factorisation:
        """Workspaces for factors of the matrix of each part."""
        return block_factors([body.factors() for body in self.bodies], self.spans)

    def masses(self, state: State) -> Array:
        """The mass matrix of each part at a state, as its body stores matrices."""
        stored = np.zeros(self.stored_shape)
        every = zip(self.bodies, self.states(state), self.values(stored), strict=True)
        for body, own, values in every:
            body.add_mass(values, body.masses(own))
        return stored

    def matrix(self, values: Array) -> sp.csc_array | Array:
        """A block-diagonal matrix (n, n) from values as `forces` and `masses` give them."""
        pairs = zip(self.bodies, self.values(values), strict=True)
        blocks = [body.matrix(own) for body, own in pairs]
        if any(sp.issparse(block) for block in blocks):
            return sp.csc_array(sp.block_diag(blocks, format="csc"))
        dense: Array = scipy.linalg.block_diag(*blocks)
        return dense

    def add_mass(self, values: Array, mass: Array) -> None:
        """Add what `masses` gives to a matrix as the body stores it."""
        values += mass

    def damping_at(self, state: State, scheme: Integration) -> tuple[Array | None, Array]:
        """Forces (n,) of viscous materials' memory [N] or None, and C without a M of every part."""
        every = zip(self.bodies, self.states(state), self.schemes(scheme), strict=True)
        found = [body.damping_at(own, one) for body, own, one in every]
        stored = np.concatenate([values.ravel() for _, values in found])
        return joined_forces(self.spans, [force for force, _ in found]), stored

    def inertia_at(self, state: State) -> Array | None:
        """Centrifugal and gyroscopic forces (n,) of dynamic parts [N]; None where masses are constant."""
        pairs = self.each(state)
        found = [None if one.integration.static else one.inertia_at(own) for one, own in pairs]
        return joined_forces(self.spans, found)

    def turning_steps(self) -> Turning | None:
        """What replaces long straight steps by such that turn elements; None: nothing does. Expensive."""
        every = [body.turning_steps() for body in self.bodies]
        return None if all(one is None for one in every) else partial(self._turned, every)

    def _turned(self, every: Sequence[Turning | None], state: State, u: Array) -> Array:
        steps = zip(every, self.states(state), self.spans.columns, strict=True)
        return np.concatenate(
            [u[span] if one is None else one(own, u[span]) for one, own, span in steps]
        )

    def inverted(self, state: State) -> int:
        """Number of elements that are turned inside out."""
        return sum(body.inverted(own) for body, own in self.each(state))

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""
        return sum(body.potential(own) for body, own in self.each(state))

    def stored(self, state: State) -> float:
        """Energy stored in the memory of viscous materials [J]."""
        return sum(body.stored(own) for body, own in self.each(state))

    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step [m/s], [rad/s]."""
        every = zip(self.bodies, self.states(start), self.states(end), strict=True)
        return np.concatenate([body.velocity(one, other) for body, one, other in every])

    def at_end(self, start: State, end: State, force: Array) -> Array:
        """Forces (n,) at the end of a step that do the work of given ones at its start [N], see `Body`."""
        every = zip(
            self.bodies, self.states(start), self.states(end), self.spans.columns, strict=True
        )
        return np.concatenate(
            [body.at_end(one, other, force[span]) for body, one, other, span in every]
        )

    def damping_at_end(self, start: StepStart, K: Array) -> Array:
        """Second derivative of ½ vᵀ C v by v h at the end of a step, see `Body`."""
        every = zip(self.bodies, self.starts(start), self.values(K), strict=True)
        return np.concatenate([body.damping_at_end(one, own).ravel() for body, one, own in every])

    def step_start(self, state: State) -> StepStart:
        """The start of a step that is iterated, see `Body`; each part has a scheme and damping of its own."""
        starts = [start_of_part(body, own) for body, own in self.each(state)]
        return StepStart(
            state,
            self.integration,
            np.concatenate([start.mass.ravel() for start in starts]),
            np.concatenate([start.damping.ravel() for start in starts]),
            np.concatenate([start.force for start in starts]),
        )

    def starts(self, start: StepStart) -> list[StepStart]:
        """The start of an iterated step of each part."""
        every = zip(
            self.states(start.state),
            self.schemes(start.integration),
            self.values(start.mass),
            self.values(start.damping),
            self.spans.columns,
            strict=True,
        )
        return [
            StepStart(state, scheme, mass, damping, start.force[span])
            for state, scheme, mass, damping, span in every
        ]
