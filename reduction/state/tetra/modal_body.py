"""A body of tetrahedra in reduced coordinates: no array of a step is as long as its mesh.

Nodes are at q₀ + E β (14), with β = α where the robot has neither drives nor beams, and otherwise also sines
and cosines of angles θ and rotation matrices of frames (`tauten.reduction.state.tetra.own_motion`). State.q
has α and the robot's own coordinates, State.v their rates and angular velocities. Forces and tangent are sums
over a sample of elements, directly in β (`tauten.reduction.state.tetra.kernels`); those in the coordinates
follow with J = ∂β/∂q: Jᵀ f and Jᵀ K J.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from tauten.model import Assembled, Augmentation, Integration, Robot, State, System
from tauten.model.constraints import Drums
from tauten.model.numerics import Array, Ints
from tauten.model.points import points_at
from tauten.model.tetra import TetBody
from tauten.reduction.dense_step import DenseAssembled, implicit_system, velocity_of_mass
from tauten.reduction.reduced_body import ReducedBody
from tauten.reduction.state.tetra.actuators import ModalCurvature, Wound
from tauten.reduction.state.tetra.arrays import Response, SampledElements, Work, make_work
from tauten.reduction.state.tetra.beams import ReducedBeams, ReducedSprings
from tauten.reduction.state.tetra.body import ModeMotion, ModePoints, mode_points
from tauten.reduction.state.tetra.elements import (
    assemble_response,
    assemble_semidefinite,
    sampled_energy,
)
from tauten.reduction.state.tetra.kernels import combine, tangents_apart
from tauten.reduction.state.tetra.node_chart import NodeChart
from tauten.reduction.state.tetra.own_motion import Derivative, OwnMotion


@dataclass(frozen=True, slots=True, eq=False)
class SampledAssembled(DenseAssembled):
    """Forces and tangents of sampled elements at a state; attributes beside those of `DenseAssembled`.

    Attributes:
        motion: β there, and its derivative J.
        over_beta: (R,) forces without actuators and contacts for β.
        members: efforts on all single actuators but drives; None: there are none.
        wound: cables on drums; None: there are none.
        tension: of each cable [N].
        response: of the elements, in the workspace of the body that assembled it.
        apart: D and the derivative K of elements, cables and chambers (k, k), for systems of several lengths;
            None: their sum is made for each system.
    """

    motion: ModeMotion
    over_beta: Array
    members: Array | None
    wound: Wound | None
    tension: Array
    response: Response
    apart: tuple[Array, Array] | None = field(default=None, kw_only=True)


@dataclass(frozen=True, slots=True, eq=False)
class ModalBody(ReducedBody[ModePoints]):
    """A body of tetrahedra moved by modes.

    Attributes, beside those of every reduced body:
        chart: the deviations that Φ combines.
        E: (3 n_nodes, R) displacements of all nodes that are not fixed, by β.
        own_motion: β of the coordinates.
        sampled: elements.
        curvature: of its cables and chambers.
        mass: (R, R) Eᵀ M E [kg].
        floating: (R, R) the same of nodes that nothing holds; None: all are held.
        load: (R,) Eᵀ of gravity and outer forces [N].
        springs: that keep hinges aligned; None: there are none.
        drums: motors that wind several cables; None: there are none.
        driven: (d,) unknowns that actuated drives move.
        beams: beside the elements; None: there are none.
        contact_points: the points of surfaces that touch.
        effector_places: (3 p, R) displacement of the effectors, where outer forces act on them.
        work: workspace of the kernels.
    """

    full: Robot[TetBody]
    chart: NodeChart
    E: Array
    own_motion: OwnMotion
    sampled: SampledElements
    curvature: ModalCurvature
    mass: Array
    floating: Array | None
    load: Array
    springs: ReducedSprings | None
    drums: Drums | None
    driven: Ints
    beams: ReducedBeams | None
    contact_points: ModePoints
    effector_places: Array
    work: Work

    @property
    def n_elements(self) -> int:
        """Elements in the sample."""
        return self.sampled.elements

    def fork(self) -> ModalBody:
        """The same body with a workspace of its own."""
        work = make_work(self.sampled, self.curvature.tendons, self.own_motion.pulled)
        return dataclasses.replace(self, work=work)

    def of(self, full: Robot[TetBody]) -> ModalBody:
        """The same reduction of a full robot under other loads."""
        tetrahedra = full.body.tetrahedra
        return dataclasses.replace(
            self,
            full=full,
            chart=dataclasses.replace(self.chart, tetrahedra=tetrahedra),
            gravity=full.gravity,
            load=self.E.T @ tetrahedra.load,
        )

    def surface_points(self, vertices: Ints) -> ModePoints:
        """Points of the body at some nodes (v,) of the full robot."""
        return mode_points(self.full.body.tetrahedra, self.E, points_at(vertices))

    def lifted(self, state: State) -> State:
        """The state of the full robot whose deviations are Φ α."""
        q = self.chart.configuration(self.Phi @ state.q)
        return State(q, self.chart.velocity(self.Phi @ state.v))

    def motion(self, state: State) -> ModeMotion:
        """Where the points of the body are at a state."""
        map_, q = self.own_motion, state.q
        if map_.is_plain:
            return ModeMotion(q, None, np.zeros(0))
        travel = q[map_.modes : map_.modes + map_.drives]
        beta = map_.beta(q)
        return ModeMotion(beta, map_.jacobian(beta), travel)

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of an effector, contact vertex, or node of a drive or beam in a change dq [m].

        See `Body`.
        """
        map_ = self.own_motion
        change = dq if map_.is_plain else map_.jacobian(map_.beta(state.q)).rates(dq)
        effectors = np.hypot.reduce((self.effector_places @ change).reshape(-1, 3), axis=1)
        contacts = np.hypot.reduce((self.contact_points.map @ change).reshape(-1, 3), axis=1)
        most = float(np.maximum.reduce(contacts, initial=np.maximum.reduce(effectors, initial=0.0)))
        return most if map_.is_plain else max(most, map_.largest_move(dq))

    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, see `Robot`."""
        map_, step = self.own_motion, h * v
        q = map_.moved(state.q, step) if map_.frames > 0 else state.q + step
        return State(q, v, state.memory)

    def velocity(self, start: State, end: State) -> Array:
        """The velocity (n,) that moves one state to another within a step, see `Body`."""
        return self.own_motion.between(start.q, end.q) / self.h

    def at_end(self, start: State, end: State, force: Array) -> Array:
        """Forces (n,) at the end of a step that do the work of given ones at its start, see `Body`."""
        return self.own_motion.at_end(self.own_motion.between(start.q, end.q), force)

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Forces without actuators and contacts (n,) [N], and the tangent K (n, n), see `Robot`."""
        at = self.responding(state, effort, dataclasses.replace(self.integration, static=True))
        return at.force, self.tangent(at, (0.0, 1.0), exact)

    def material_stiffness(self, state: State) -> Array:
        """The stiffness of the material (n, n), carried along with the elements."""
        at = self.responding(state, None, dataclasses.replace(self.integration, static=True))
        return self.tangent(at, (1.0, 0.0), True)

    def assemble(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> SampledAssembled:
        """Forces and tangents at a state, see `Body`."""
        return self.responding(state, effort, integration, several=True)

    def responding(
        self,
        state: State,
        effort: Array | None,
        integration: Integration | None,
        several: bool = False,
    ) -> SampledAssembled:
        """Forces at a state, and what tangents there are made from.

        Args:
            state: where steps start.
            effort: (n_a,) last efforts of the actuators; None: zero.
            integration: another scheme than the body's; None: that one.
            several: whether systems of several lengths are made of these.
        """
        scheme, response = integration or self.integration, self.work.response
        actuators, motion = self.actuator_set, self.motion(state)
        beta, J = motion.beta, motion.J
        pulled = self.own_motion.pulled
        efforts = actuators.efforts(effort)
        wound = None if self.drums is None else self.wound(motion)
        if wound is not None and self.drums is not None:
            efforts = np.zeros(len(actuators.others)) if efforts is None else efforts
            efforts[self.drums.cables] = wound.tension
        cables, walled, _ = actuators.ends
        given = np.zeros(walled) if efforts is None else efforts
        tension, pressure = given[:cables], given[cables:walled]
        if len(self.curvature.volumes) > 0:
            self.curvature.write(beta[:pulled], pressure, response.curvature)
        damped = not scheme.static and scheme.rayleigh_stiffness > 0.0
        rate = state.v if J is None or scheme.static else J.rates(state.v)
        over_beta, resisting = self.material(beta, rate, damped)
        moments = held = np.zeros(len(state.v))
        if self.beams is not None:
            on_beams, moments, held = self.on_beams(state, motion, damped)
            over_beta += on_beams
        force, floats = over_beta, scheme.static and self.floating is not None
        mass = self.mass if self.floating is None or not floats else self.floating
        inertia: Array | None = None
        if J is not None:
            force, resisting = J.forces(over_beta) + moments, J.forces(resisting) + held
            if floats or not scheme.static:
                inertia = -J.forces(mass @ self.own_motion.centripetal(beta, state.v))
                mass = self.mass_with(J, floats)
        preload = actuators.preload(motion) if actuators.is_preloaded else None
        if preload is not None:
            force = force + preload[0]
        if wound is not None:
            force = force + wound.tension @ wound.H
        apart, sums = None, (self.sampled, self.curvature.tendons, self.work)
        if several and not scheme.static:
            apart = tangents_apart(beta[:pulled], tension, response, *sums)
        return SampledAssembled(
            state, effort, mass, force, inertia, resisting,
            motion, over_beta, efforts, wound, tension, response, floats=floats, apart=apart,
        )  # fmt: skip

    def material(self, beta: Array, rate: Array, damped: bool) -> tuple[Array, Array]:
        """Forces of elements, springs of hinges and loads for β (R,), and D v (R,) where damped.

        Args:
            beta: (R,) where to evaluate.
            rate: (R,) its rate; read where damped.
            damped: whether D v is needed.
        """
        load, own, response = self.load, self.own_motion.elements, self.work.response
        if self.springs is not None:
            load = load - self.springs.K @ beta - self.springs.p
        respond = (damped, self.sampled, response)
        assemble_response(beta[:own], rate[:own], load[:own], *respond)
        force, resisting = load.copy(), np.zeros(len(load))
        force[:own], resisting[:own] = response.force, response.resisting
        if damped and self.springs is not None:
            resisting += self.springs.K @ rate
        return force, resisting

    def on_beams(
        self, state: State, motion: ModeMotion, damped: bool
    ) -> tuple[Array, Array, Array]:
        """Forces of beams for β (R,), moments (n,) of coordinates that turn, and D v (n,) where damped."""
        assert self.beams is not None
        map_, beta, J = self.own_motion, motion.beta, motion.J
        _, force, moments = self.beams.forces(map_, state.q, beta)
        if not damped or J is None:
            return force, moments, np.zeros(self.n)
        D = self.beams.tangent(map_, state.q, beta, J, (1.0, 0.0))
        return force, moments, D @ state.v

    def tangent(self, at: SampledAssembled, shares: tuple[float, float], exact: bool) -> Array:
        """A sum of the stiffness of the material and the tangent (n, n).

        Args:
            at: the state.
            shares: of D and of K.
            exact: whether K is the derivative, or positive semidefinite.
        """
        beta, J, response = at.motion.beta, at.motion.J, at.response
        if not (exact or self.sampled.corotational):
            own = self.own_motion.elements
            assemble_semidefinite(beta[:own], self.sampled, response)
        tendons, pulled = self.curvature.tendons, self.own_motion.pulled
        tangent, summed = np.zeros((len(beta), len(beta))), self.work.S
        if exact and at.apart is not None:
            summed = shares[0] * at.apart[0] + shares[1] * at.apart[1]
        else:
            sums = self.sampled, tendons, self.work
            combine(beta[:pulled], at.tension, shares, exact, response, *sums)
        tangent[:pulled, :pulled] = summed
        if self.springs is not None:
            tangent += (shares[0] + shares[1]) * self.springs.K
        moved, members = self.actuator_set.transmissions, at.members
        if exact and moved is not None and members is not None:
            over_beta = ModeMotion(beta, None, at.motion.travel)
            efforts = members[len(members) - len(moved) :]
            tangent += shares[1] * moved.stiffness(over_beta, efforts)
        if J is None:
            return tangent
        tangent = J.congruent(tangent)
        map_ = self.own_motion
        if len(map_.turning) + map_.frames > 0:
            others = at.over_beta
            if members is not None and len(members) > 0:
                over_beta = ModeMotion(beta, None, at.motion.travel)
                others = others + members @ self.actuator_set.other_rows(over_beta).dense()
            map_.add_curvature(beta, others, shares[1], tangent, exact)
        if self.beams is not None:
            both = shares if exact else (shares[0] + shares[1], 0.0)
            tangent += self.beams.tangent(map_, at.state.q, beta, J, both)
        if at.wound is not None:
            tangent += shares[1] * at.wound.tangent
        return tangent

    def unstrained(self, at: SampledAssembled, shares: tuple[float, float]) -> Array:
        """`tangent` (n, n) with the stiffness of the material for K; drums hold what nothing else does."""
        tangent = self.tangent(at, (sum(shares), 0.0), True)
        return tangent if at.wound is None else tangent + shares[1] * at.wound.tangent

    def potential(self, state: State) -> float:
        """Energy of sampled elements, beams, springs and drums, minus the work of loads since rest [J]."""
        motion, springs, drums = self.motion(state), self.springs, self.drums
        beta, preload = motion.beta, self.actuator_set.preload(motion)
        own = beta[: self.own_motion.elements]
        energy = sampled_energy(own, self.sampled) - float(self.load @ beta)
        if self.beams is not None:
            energy += self.beams.forces(self.own_motion, state.q, beta)[0]
        if springs is not None:
            energy += float(beta @ (0.5 * springs.K @ beta + springs.p))
        if drums is not None:
            actuators = self.actuator_set
            rows = actuators.paths.rows(motion.placed(actuators.stations))
            energy += drums.energy(rows.delta, motion.travel[drums.regions])
        return energy if preload is None else energy - preload[1]

    def masses(self, state: State) -> Array:
        """The mass matrix (n, n) at a state."""
        J = self.motion(state).J
        return self.mass if J is None else self.mass_with(J)

    @property
    def floats(self) -> bool:
        """Whether there is a mass that is `floating`."""
        return self.floating is not None

    def floating_mass(self, state: State) -> Array | None:
        """Mass (n, n) of what moves by its inertia in quasi-static steps too; None: nothing does."""
        J = self.motion(state).J
        return self.floating if J is None or self.floating is None else self.mass_with(J, True)

    def floating_velocity(self, state: State) -> Array:
        """Velocity (n,) of what floats, see `Body`; of all else it is zero as far as no mode moves both."""
        mass = self.floating_mass(state)
        return np.zeros_like(state.v) if mass is None else velocity_of_mass(mass, state.v)

    def mass_with(self, J: Derivative, floating: bool = False) -> Array:
        """The mass matrix (n, n) where J (R, n) is known, of all or of what floats alone."""
        beams, over_beta = self.beams, self.floating if floating else self.mass
        assert over_beta is not None
        mass = J.congruent(over_beta)
        return mass if beams is None else mass + (beams.floating if floating else beams.inertia)

    def inertia_at(self, state: State) -> Array | None:
        """Centrifugal forces (n,) of drives and frames that turn [N]; None: there are none."""
        motion, rate = self.motion(state), self.own_motion.centripetal
        J = motion.J
        return None if J is None else -J.forces(self.mass @ rate(motion.beta, state.v))

    def wound(self, motion: ModeMotion) -> Wound | None:
        """The cables on drums at a state; None: there are none."""
        drums, actuators = self.drums, self.actuator_set
        if drums is None:
            return None
        rows = actuators.paths.rows(motion.placed(actuators.stations))
        tension = drums.tensions(rows.delta, motion.travel[drums.regions])
        H = rows.chosen(drums.cables)
        columns = self.own_motion.modes + drums.regions[drums.owner]
        H[np.arange(len(H)), columns] -= drums.gains
        return Wound(H, tension, H.T @ (drums.held_by(tension)[:, None] * H))

    def linearise(
        self, state: State, effort: Array | None = None, integration: Integration | None = None
    ) -> System:
        """The system of one step from this state, see `Robot`."""
        scheme = integration or self.integration
        return self.system(self.responding(state, effort, scheme), scheme)

    def system(
        self, assembled: Assembled, integration: Integration, added: Augmentation = None
    ) -> System:
        """The system of one step, see `Body`."""
        assert isinstance(assembled, SampledAssembled)
        at, tangent = assembled, partial(self.tangent, assembled, integration.shares)
        material = partial(self.unstrained, assembled, integration.shares)
        L = self.work.L if at.motion.J is None else np.zeros((self.n, self.n))
        turns = integration.static and self.own_motion.frames > 0
        loose = self.masses(at.state) if turns else None
        return implicit_system(integration, at, tangent, material, L, self.driven, added, loose)
