"""The next tick under what the actuators are to do, each within its limits of position, rate and effort.

An actuator is given a position, as a winch is, or an effort, as a supply of pressure is. Within a tick it
reaches the positions from `lower` to `upper`. Its effort over its position is a falling staircase:

    position              effort
    above upper           that of a cable which hangs slack, zero
    at upper              up to λ_min
    up to the position    λ_min: the actuator takes up what becomes free
    at the position       λ_min to λ_max
    down to lower         λ_max: the actuator gives way
    at lower              λ_max and more: no actuator of this rate keeps its limit

With an effort given, this is the effort between lower and upper. A staircase that falls is a monotone law, as
that of a contact: a few forward steps with the right end of each actuator find the step. From step to step an
actuator goes over to the next end of its staircase. Where some that act on each other would go to and fro so,
one changes at a time, always the first that has to, as in the least-index method of Murty (Linear
Complementarity, Linear and Nonlinear Programming, 1988).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller.qpcc import NO_PIECE
from tauten.model import (
    Clusters,
    Command,
    CondensedStep,
    Enrichment,
    Forces,
    Limits,
    PredictedStep,
    Robot,
    forward_step,
)
from tauten.model.numerics import Array, Bools, kernel

ROUNDING = 1e-6  # of the largest effort
SHORT = 1e-9  # of the range of positions; what counts as none
ONE_BY_ONE = 6  # forward steps in all, as a multiple of those in which actuators change together


@dataclass(frozen=True, slots=True)
class Reach:
    """Positions that the actuators reach in a tick.

    Attributes:
        lower: (n_a,) least.
        upper: (n_a,) largest.
    """

    lower: Array
    upper: Array


@dataclass(frozen=True, slots=True)
class FirstTick:
    """A tick that the model takes.

    Attributes:
        solved: forces and motion.
        command: the position or effort that each actuator ended with.
        position: (n_a,) positions of the actuators after it, within reach.
    """

    solved: PredictedStep
    command: Command
    position: Array


def reach_of(position: Array, limits: Limits, h: float) -> Reach:
    """What the actuators reach in a time step.

    Args:
        position: (n_a,) positions at its start.
        limits: of positions and rates.
        h: time step [s].
    """
    step = h * limits.rate
    return Reach(
        np.maximum(limits.position_min, position - step),
        np.minimum(limits.position_max, position + step),
    )


def reach_held(
    reach: Reach, position: Array, command: Command, effort: Array, limits: Limits
) -> Reach:
    """Reach of actuators that do not give way: from where they were to what is commanded.

    One that is still on its way gives way where its effort is beyond a limit: the motion of the last step may
    end a little beyond what its linearisation predicted.

    Args:
        reach: of actuators that give way.
        position: (n_a,) positions commanded last [m].
        command: position or effort of each actuator.
        effort: (n_a,) of the last step [N, Pa].
        limits: of the efforts.
    """
    given, moving = command.by_position, command.position != position
    kept_above = given & ~(moving & (effort > limits.effort_max))
    kept_below = given & ~(moving & (effort < limits.effort_min))
    lower = np.where(kept_above, np.fmin(position, command.position), reach.lower)
    return Reach(lower, np.where(kept_below, np.fmax(position, command.position), reach.upper))


def take_tick(
    step: CondensedStep,
    enrichment: Enrichment,
    previous: Forces,
    wanted: Command,
    reach: Reach,
    limits: Limits,
) -> FirstTick:
    """Solve a tick in which each actuator does what is wanted as far as its limits permit.

    Where no ends of the actuators are found that agree, all do what is wanted, whatever their efforts.
    """
    command = Command(wanted.position.copy(), wanted.effort.copy())
    actuators, ends = step.layout.actuators, (reach.lower, reach.upper)
    least, most = limits.effort_min, limits.effort_max
    short = SHORT * (limits.position_max - limits.position_min)
    together = 2 * step.layout.n_a + 4
    for number in range(ONE_BY_ONE * together):
        solved = forward_step(step, enrichment, previous, command)
        lam, delta = solved.effort, solved.delta[actuators]
        changed = _corrected(
            command.position, command.effort, (wanted.position, wanted.effort), ends, (least, most, short),
            (lam, delta), step.laws.bilateral, number >= together,
        )  # fmt: skip
        if not changed:
            break
    else:
        command = Command(wanted.position.copy(), wanted.effort.copy())
        solved = forward_step(step, enrichment, previous, command)
        delta = solved.delta[actuators]
    by_force, position = ~np.isnan(command.effort), command.position.copy()
    position[by_force] = np.minimum(np.maximum(delta, reach.lower), reach.upper)[by_force]
    return FirstTick(solved, command, position)


def given_in(tick: FirstTick, supplied: Bools, limits: Limits) -> Command:
    """What actuators are given at the end of a tick: what they ended with, or efforts of supplies.

    Args:
        tick: solved.
        supplied: (n_a,) which are supplies that keep efforts.
        limits: of the efforts.
    """
    command = tick.command
    within = np.minimum(np.maximum(tick.solved.effort, limits.effort_min), limits.effort_max)
    position, effort = command.position.copy(), command.effort.copy()
    position[supplied], effort[supplied] = np.nan, within[supplied]
    return Command(position, effort)


def first_tick(
    robot: Robot,
    planned: Command,
    position: Array,
    locks: Command | None,
    before: Array,
    share: Array,
    together: Clusters | None,
) -> tuple[Command, Reach]:
    """What the actuators are to do in the first tick of a plan, and what they reach in it.

    All go to the plan's positions; what supplies that keep efforts get is what that takes in the tick, see
    `given_in`: the plan's own effort takes the whole horizon. Forces on points that keep their effort get the
    plan's all the same: only inertia resists such a force within a tick, and one that brakes in the next what
    it has accelerated lets a lightly damped robot swing between its limits. A cable without tension in the
    plan has none in the tick, and its winch follows the path; where actuators go a share of the way, its
    tension decreases by that share: let go at once, one that plans pull and let go in turn is never taut.

    Args:
        robot: limits and laws of the actuators.
        planned: positions and efforts of all actuators at the end of the plan.
        position: (n_a,) positions of the actuators commanded last [m].
        locks: what locked actuators do in this tick; None: all are decided.
        before: (n_a,) efforts of the last step [N, Pa].
        share: of the way to the plan's positions that each goes (n_a,); efforts are
            kept within limits all the same.
        together: clusters of which all actuators get there in the same tick, that of the slowest; None: any.
    """
    limits, laws, lam_a = robot.limits, robot.actuators.laws, planned.effort
    reach = reach_of(position, limits, robot.h)
    there = np.minimum(np.maximum(planned.position, reach.lower), reach.upper)
    way = planned.position - position
    for own in together.each if together is not None else ():
        moving = own.actuators[way[own.actuators] != 0.0]
        least = ((there - position)[moving] / way[moving]).min(initial=1.0)
        there[moving] = position[moving] + least * way[moving]
    slack = laws.slack(lam_a, limits, ROUNDING)
    effort = np.minimum(np.maximum(lam_a, limits.effort_min), limits.effort_max)
    if min(share.tolist(), default=1.0) < 1.0:
        held_back = share < 1.0
        there = np.where(held_back, position + share * (there - position), there)
        effort = np.where(held_back, before + share * (effort - before), effort)
    free = slack | (laws.held_by_force & robot.actuators.are_forces)
    wanted = Command.either(free, there, effort)
    if locks is None:
        return wanted, reach
    locked = locks.by_position | locks.by_force
    wanted = Command(
        np.where(locked, locks.position, wanted.position),
        np.where(locked, locks.effort, wanted.effort),
    )
    return wanted, reach_held(reach, position, locks, before, limits)


def exceeded(robot: Robot, tick: FirstTick) -> tuple[str, ...]:
    """Names of the efforts that are beyond their limits in a tick, and of what else is not met."""
    excess = robot.actuators.laws.beyond(tick.solved.effort, robot.limits)
    if tick.solved.converged and not any((excess > ROUNDING).tolist()):
        return ()
    names = robot.actuators.effort_names
    found = tuple(names[i] for i in np.flatnonzero(excess > ROUNDING).tolist())
    return found if tick.solved.converged else (*found, *NO_PIECE)


def jammed(robot: Robot, tick: FirstTick) -> bool:
    """Whether contacts are deeper than the tolerance after a tick because no forces open them."""
    solved = tick.solved
    return not solved.converged and solved.deepest_gap < -robot.tolerance


def stalled_locks(locks: Command, tick: FirstTick, robot: Robot) -> Bools:
    """Which locks (n_a,) do not get where they are to be in a tick."""
    short = ROUNDING * robot.h * robot.limits.rate
    found: Bools = locks.by_position & (np.abs(tick.position - locks.position) > short)
    return found


@kernel
def _corrected(
    position: Array, effort: Array, wanted: tuple[Array, Array], reach: tuple[Array, Array],
    limits: tuple[Array, Array, Array], found: tuple[Array, Array], bilateral: Bools, first: bool,
) -> bool:  # fmt: skip
    """Where forces and positions ask for another end of a staircase, and whether any does.

    Args:
        position: (n_a,) positions that were solved with, NaN where efforts were; overwritten.
        effort: (n_a,) efforts that were solved with; overwritten.
        wanted: positions and efforts that are wanted, likewise.
        reach: (n_a,) least and largest positions.
        limits: (n_a,) least and largest efforts, and positions that are rounding.
        found: (n_a,) efforts and positions that were found.
        bilateral: (n_a,) which actuators pull and push.
        first: whether only the first of them changes.
    """
    (lam, delta), changed = found, False
    for i in range(len(lam)):
        ends, range_ = (reach[0][i], reach[1][i]), (limits[0][i], limits[1][i])
        middle, goal, short = wanted[0][i], wanted[1][i], limits[2][i]
        if np.isnan(effort[i]):
            there = np.nan
            force = _from_position(
                position[i], lam[i], middle, goal, ends, range_, short, bilateral[i]
            )
        else:
            there, force = (
                _from_effort(effort[i], delta[i], middle, ends, range_, short),
                np.nan,
            )
        if not (np.isnan(there) and np.isnan(force)):
            changed, position[i], effort[i] = True, there, force
            if first:
                return changed
    return changed


@kernel
def _from_position(
    position: float, lam: float, middle: float, effort: float, reach: tuple[float, float],
    limits: tuple[float, float], short: float, bilateral: bool,
) -> float:  # fmt: skip
    """The effort that an actuator goes over to from a position, NaN: none.

    Args:
        position: the position.
        lam: effort that was found there.
        middle: position that is wanted; NaN where an effort is,
        effort: this one.
        reach: least and largest position.
        limits: least and largest effort.
        short: what is rounding of a position.
        bilateral: whether it pulls and pushes.
    """
    lower, upper = reach
    least, most = limits
    by_effort, small = not np.isnan(effort), ROUNDING * max(abs(least), abs(most))
    if position >= upper - short and (by_effort or middle < upper - short):
        floor = effort if by_effort else least
        return floor if lam > floor + small else np.nan
    if position <= lower + short and (by_effort or middle > lower + short):
        ceiling = effort if by_effort else most
        return ceiling if lam < ceiling - small else np.nan
    if lam > most + small and middle > lower + short:
        return most
    takes_up = lam < least - small and middle < upper - short
    return least if takes_up and (bilateral or least > 0.0) else np.nan


@kernel
def _from_effort(
    effort: float, delta: float, middle: float, reach: tuple[float, float],
    limits: tuple[float, float], short: float,
) -> float:  # fmt: skip
    """The position that an actuator goes over to from an effort, NaN: none; arguments as above.

    Args:
        effort: the effort.
        delta: position that was found with it.
        middle: position that is wanted; NaN where this effort is.
        reach: least and largest position.
        limits: least and largest effort.
        short: what is rounding of a position.
    """
    given_way = effort == limits[1] and delta > middle + short
    taken_up = effort == limits[0] and delta < middle - short
    if given_way or taken_up:
        return middle
    if delta > reach[1] + short:
        return reach[1]
    return reach[0] if delta < reach[0] - short else np.nan
