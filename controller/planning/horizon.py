"""How far decisions look ahead: the step over the horizon.

A plan is a step of implicit Euler as long as the horizon H. At its end the effectors are at their target, so
that the robot has come nearly to a stop there.

**Motion that goes on.** That is right for a target that stays. A target that moves with a velocity u needs
forces that keep the robot moving: damping resists, and inertia must not count as a help, as it does where a
plan stops the robot within the horizon. So a share s of the velocity v goes on. That motion leads by h s v
within the tick, after which the effectors are to be at the target, and what the plan changes of the velocity
acts over the horizon:

    q₁ = q + h s v + H (v₁ − s v),   M (v₁ − v) = H (f(q₁) − C v₁)

With s = 0 this is the step of implicit Euler. The share follows from the goals of the last ticks: the motion
of the targets along that of the effectors, relative to the latter. Where targets have moved at least half as
fast as the effectors, s = 1; where they stay, s = 0: the robot comes to rest as if nothing had ever moved.
Nor does the motion go on of a robot that cannot follow: s decreases to zero where the effectors are between
three and four ticks of their motion from their target. Where contacts are in range s = 0: motion that meets
contact does not go on, and plans that count on it exceed limits or throw what is held. Where all contacts in
range are of parts that have neither actuators nor effectors, as of an object on a floor that nothing is near,
a plan is that without contacts. Every cluster of the robot has a share of its own.

A plan with s > 0 over a short horizon, of at most 0.05 s, is linearised at q + h v, where the robot is at
the end of the tick if nothing changes, as the stages of the model are. Linearised at q, it would count on
stiffness and efforts of a tick ago; in a body under pressure these change what a tick moves by a tenth, so
that the tip is late and decisions alternate. Beside it contacts count only where they push, or would if the
motion went on through the horizon: not the folds of a bellows that are near each other. Plans over longer
horizons remain linearised at q, with which those of the trunk over ten ticks follow its path better.

The velocity of a mode that actuators move directly is what the last decision made it. With damping b_K, that
velocity times −s b_K (H − h) / (b_K + H) is added to where such a mode ends, in which H is long against its
period. The decision corrects that, and so changes the velocity in the next tick by that over h. Where this
factor were more than one, decisions would alternate: it bounds s. Over a short horizon, where plans follow
every change of the velocity, the factor is at most 0.7, so that what alternates decays.

**Following over a shorter horizon.** A plan with s = 0 stops the robot at its end, so that a robot that does
not come to rest within a tick is behind a moving target by about the horizon. Where the robot file gives a
shorter horizon for it, that is the horizon of ticks in which effectors follow targets: half of the time that
the effectors are behind, between the two. Farther from targets, and where these stay or have jumped, plans
look as far as ever: over a short horizon they weigh directions by inertia, and robots come to rest far from
the best place. No motion goes on then, also where no contact is in range: where that of an arm with nine
tendons does, its tensions change more than twice as much from tick to tick.

**Robots that would buckle without their cables.** At efforts that are given, a compressed body may be
unstable where it is stable at given positions, which is how its actuators hold it. The tangent K that
eliminates everything but forces is then singular or indefinite over a horizon, where inertia no longer
outweighs it. So a stiffness ρ_i along each actuator that holds a position is added to it, K + Σ ρ_i h_iᵀ h_i
with the rows h_i of δ_a, as in augmented Lagrangian methods (Fortin and Glowinski, Augmented Lagrangian
Methods, 1983). The unknown forces of these rows are λ_i + ρ_i (δ_a − δ_a,0)_i then. Motion, efforts and their
limits are those of the robot, whatever ρ is; the small energy term of (T1) counts the unknown forces, so that
of several ways to the target the plan takes one that moves the actuators little.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.planning.course import shares_that_go_on, time_behind
from tauten.model import (
    Assembled,
    Clusters,
    CondensedStep,
    ContactSpace,
    Forces,
    Integration,
    Robot,
    State,
    clusters_of,
    condense_step,
    recondensed,
)
from tauten.model.numerics import Array, Bools

ADDED = 0.3  # of the stiffness along an actuator in a tick, that is added to the tangent over the horizon
SHORT = 0.05  # s, the longest horizon whose plans are linearised where the velocity leads
DECAY = 0.7  # from tick to tick, at most, of what alternates in such plans
ROUNDING = 1e-9  # of the size of the largest part
TINY = float(np.finfo(float).tiny)  # the least positive number
BEHIND = 0.5  # of the time that effectors are behind targets, which is their horizon as they follow


@dataclass(frozen=True, slots=True)
class Horizon:
    """A robot, and how far its decisions look ahead.

    Attributes:
        robot: steps of one tick.
        ahead: the same robot with a workspace for the step over the horizon; None: the horizon is one tick.
        integration: of that step.
        idle: names of the parts that have neither actuators nor effectors.
        least: what an effort moves its own actuator by in a tick; less is rounding [m].
        clusters: what of the robot acts on each other.
        ticks: its length; 0: one tick, for which there is no step of its own.
        following: its least length where the effectors follow targets that move [s]; infinite: its own, and
            motion goes on.
    """

    robot: Robot
    ahead: Robot | None
    integration: Integration
    idle: frozenset[str]
    least: float
    clusters: Clusters
    ticks: int = 0
    following: float = math.inf

    def of(self, robot: Robot, sight: float) -> Horizon:
        """The same for the robot at another time.

        Args:
            robot: at that time.
            sight: distance up to which contacts are looked for, if more than the alarm distance [m].
        """
        if sight > robot.contacts.alarm_distance:
            robot = robot.with_contacts(robot.contacts.reaching(sight))
        return self if robot is self.robot else replace(self, robot=robot)


def horizon_of(robot: Robot, seconds: float, following: float | None = None) -> Horizon:
    """The horizon of a robot's decisions.

    A quasi-static robot has none: where its steps lead does not depend on their length.

    Args:
        robot: its workspace is used.
        seconds: of the horizon; at most a time step: decisions look one tick ahead.
        following: least length where the effectors follow targets that move [s]; None: that of the horizon,
            and motion goes on.
    """
    scheme = robot.integration
    known = frozenset(robot.body.idle_parts), ROUNDING * robot.part_size, clusters_of(robot)
    if scheme.static or seconds <= robot.h:
        return Horizon(robot, None, scheme, *known)
    ahead = replace(scheme, rate=1.0 / seconds)
    least = math.inf if following is None else max(following, robot.h)
    return Horizon(robot, robot.fork(), ahead, *known, round(seconds / robot.h), least)


def held_taut(horizon: Horizon, step: CondensedStep, effort: Array) -> tuple[Bools, Array]:
    """Actuators along which a plan may add stiffness: those that hold a position now.

    A plan leaves many cables at no tension: rounding, whose sign must not choose the next plan.

    Args:
        horizon: laws of its actuators.
        step: of the tick.
        effort: (n_a,) of the last step [N, Pa].

    Returns:
        Which they are (n_a,), and efforts (n_a,) from which on those that only pull do so [N].
    """
    laws = horizon.robot.actuators.laws
    flexibility = step.compliance.W.diagonal()[step.layout.actuators]  # m/N
    least = horizon.least / np.maximum(flexibility, TINY)
    taut: Bools = ~laws.held_by_force & (laws.bilateral | (effort > least))
    if laws.springs is not None:
        taut &= laws.springs.flexibility == 0.0
    return taut, least


def step_ahead(
    horizon: Horizon,
    space: ContactSpace,
    assembled: Assembled,
    step: CondensedStep,
    forces: Forces,
    course: Array | None,
    taut: Bools,
) -> CondensedStep:
    """The step over the horizon, condensed to the rows of the tick; that of the tick where there is none.

    Contacts with friction are solved among efforts, to which no stiffness is added.

    Args:
        horizon: the robot.
        space: basis of the contact forces.
        assembled: forces and tangents at the state where the tick starts.
        step: of the tick.
        forces: of the last step.
        course: (s, n_v) goals of the last ticks, see `with_goal`; None: there were none.
        taut: (n_a,) actuators along which stiffness may be added to the tangent.

    Raises:
        FactorisationError: the state has diverged.
    """
    robot, ahead, scheme = horizon.robot, horizon.ahead, horizon.integration
    if ahead is None:
        return step
    if horizon.idle and _touch_nothing_else(horizon, step):
        step = step.without_contacts()
    clusters, short = horizon.clusters, scheme.h <= SHORT
    values, layout = step.rows.effectors.values, robot.effector_layout
    if course is not None and horizon.following < scheme.h:
        seconds = max(BEHIND * time_behind(course, layout, values, robot.h), horizon.following)
        scheme = replace(scheme, rate=1.0 / seconds) if seconds < scheme.h else scheme
    elif course is not None:
        meets = _in_contact(clusters, step, forces, scheme.h, robot.tolerance)  # (c,)
        if not all(meets.tolist()):
            moved = robot.h * (step.compliance.H[step.layout.effectors] @ step.state.v)  # (n_e,)
            factor = DECAY if short else 1.0
            most = largest_share(robot.h, scheme.h, scheme.rayleigh_stiffness, factor)
            shares = shares_that_go_on(course, layout, values, moved, clusters, most)
            shares[meets] = 0.0
            share = _mean_share(shares, layout.scale * moved, clusters)
            if share > 0.0 and short:
                return moving_on(ahead, space, step, forces, scheme, share)
            scheme = _going_on(scheme, 1.0 - robot.h / scheme.h, shares, share, clusters)
    rho, added = None, None
    if any(taut.tolist()) and not step.frictional:
        actuators = step.layout.actuators
        flexibility, stiffness = step.compliance.W.diagonal()[actuators], np.zeros(len(taut))
        chosen = taut & (flexibility > 0.0)  # m/N, of the tick
        stiffness[chosen] = ADDED / flexibility[chosen]
        added, stiffness = assembled.augmentation(step.compliance.H[actuators], stiffness)
        rho = stiffness if any(stiffness.tolist()) else None
    return recondensed(space, step, ahead.body.system(assembled, scheme, added), rho)


def _in_contact(
    clusters: Clusters, step: CondensedStep, forces: Forces, seconds: float, least: float
) -> Bools:
    """The clusters (c,) whose motion does not go on because contacts of theirs are in range.

    Over a short horizon none goes on where any contact pushes, or would.

    Args:
        clusters: of the robot.
        step: its state, and the contacts in range.
        forces: of the last step.
        seconds: of the horizon.
        least: gap from which on contacts do not push [m].
    """
    found = np.zeros(len(clusters.each), np.bool_)
    if len(step.rows.contacts.rows.delta) == 0:
        return found
    if seconds <= SHORT:
        found[:] = meets_contact(step, forces, seconds, least)
        return found
    if len(found) == 1:
        found[0] = True
        return found
    numbers = clusters.of_pairs[step.rows.contacts.found.pair]
    found[numbers[numbers >= 0]] = True
    return found


def _mean_share(shares: Array, moved: Array, clusters: Clusters) -> float:
    """The mean of the shares of the clusters (c,), by the squares of their motion (n_e,) [m]."""
    if len(shares) == 1:
        return float(shares[0])
    weights = np.array([float(moved[of.effectors] @ moved[of.effectors]) for of in clusters.each])
    return float(weights @ shares / max(weights.sum(), TINY))


def _going_on(
    scheme: Integration, left: float, shares: Array, share: float, clusters: Clusters
) -> Integration:
    """The scheme over the horizon in which shares of the motion go on.

    Args:
        scheme: where none goes on.
        left: of the horizon after the tick, as a part of it.
        shares: of the velocity that go on in every cluster (c,).
        share: of bodies that are in no cluster or in several.
        clusters: of the robot.
    """
    if not any(shares.tolist()):
        return scheme
    if len(shares) == 1:
        return replace(scheme, ahead=left * share)
    own = np.where(clusters.of_parts >= 0, shares[clusters.of_parts], share)
    return replace(scheme, ahead=left * share, aheads=tuple((left * own).tolist()))


def _touch_nothing_else(horizon: Horizon, step: CondensedStep) -> bool:
    """Whether the contacts in range are of idle parts alone, with each other and with obstacles."""
    pairs = [horizon.robot.contacts.pairs[i] for i in set(step.rows.contacts.pair.tolist())]
    return all(p.owner in horizon.idle and (not p.other or p.other in horizon.idle) for p in pairs)


def meets_contact(step: CondensedStep, forces: Forces, seconds: float, least: float) -> bool:
    """Whether contacts push, or would where the motion went on; obstacles that move always count.

    Args:
        step: its state, and the contacts in range, at least one.
        forces: of the last step.
        seconds: for which the motion would go on.
        least: gap from which on contacts do not push [m].
    """
    contacts = step.rows.contacts
    pushing = (forces.beta > 0.0).any() or len(forces.extra) > 0
    if pushing or contacts.found.surface is not None:
        return True
    gaps, later = contacts.rows.delta, contacts.rows.after(seconds, step.state.v)
    return bool((np.minimum(gaps, later) <= least).any())


def largest_share(h: float, horizon: float, stiffness_damping: float, most: float = 1.0) -> float:
    """The share s with which decisions do not alternate, at most 1.

    Args:
        h: length of a tick [s].
        horizon: length H of the horizon [s].
        stiffness_damping: b_K [s].
        most: largest factor of what alternates from tick to tick.
    """
    factor = stiffness_damping * (horizon - h)
    return min(1.0, most * h * (stiffness_damping + horizon) / factor) if factor > 0.0 else 1.0


def moving_on(
    ahead: Robot,
    space: ContactSpace,
    step: CondensedStep,
    forces: Forces,
    scheme: Integration,
    share: float,
) -> CondensedStep:
    """The step over a short horizon of a robot whose motion goes on.

    Linearised where the velocity alone leads within the tick, as the stages of the model are: elements and
    efforts there differ from those here by as much as a tick changes them.

    Args:
        ahead: the robot, with the workspace of this step.
        space: basis of the contact forces.
        step: of one tick.
        forces: of the last step.
        scheme: over the horizon.
        share: of the velocity, that goes on.
    """
    h, v = step.system.h, step.state.v
    led = ahead.advance(step.state, v, h)
    there = State(led.q, v, step.state.memory)
    made = share + (1.0 - share) * h / scheme.h  # of the way of the velocity over the horizon
    slid = made * scheme.h * v
    return condense_step(ahead, space, there, forces, True, True, replace(scheme, ahead=made), slid)
