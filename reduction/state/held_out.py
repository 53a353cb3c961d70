"""Snapshots that are held out of the training, and the errors of a reduced model there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import count

import numpy as np

from tauten.model import ContactSpace, Robot, default_enrichment
from tauten.model.numerics import Array, Bools, Ints
from tauten.reduction.campaign import Report, Snapshots, pressed_columns
from tauten.reduction.contact import TipErrors, tip_errors
from tauten.reduction.reduced_body import StateBasisError
from tauten.reduction.state.basis import StateBasis, reduced_robot
from tauten.reduction.state.bodies import reducible

HELD_OUT = 5  # every fifth run is held out of the training
CHECKS = 100  # largest number of held-out equilibria compared
MARGIN = 0.5  # of the goal, within which the few compared first are, where all may be within it
FIRST_CHECKS, HOPELESS = 12, 3.0  # those compared first; how far beyond the goal the others are not
CHOOSING = 0.3  # of the time of an attempt, for modes and elements


def held_out_snapshots(snapshots: Snapshots) -> Bools:
    """Which snapshots are held out of the training: (s,) bool; whole runs, so that no load occurs in both.

    Of fewer than `HELD_OUT` runs single snapshots are held out: without them such a design has no others.
    """
    runs = np.unique(snapshots.run)
    if len(runs) >= HELD_OUT:
        held: Bools = np.searchsorted(runs, snapshots.run) % HELD_OUT == HELD_OUT - 1
    else:
        held = np.arange(len(snapshots)) % HELD_OUT == HELD_OUT - 1
    return held


def check_errors(
    robot: Robot,
    states: StateBasis,
    basis: ContactSpace,
    held_out: Snapshots,
    each: Callable[[], None] = lambda: None,
) -> TipErrors:
    """Tip errors of the reduced model, with the enrichment of a controller, at full-order equilibria.

    At equal positions of the actuators, and where the robot holds some by their effort at equal efforts too,
    as of chambers at equal volume and at equal pressure: the larger of both.
    """
    tolerance = robot.tolerance
    enrichment = default_enrichment(tolerance)
    reduced = reduced_robot(robot, states)
    found = tip_errors(reduced, held_out, basis, enrichment, each=each)
    if not robot.actuators.laws.held_by_force.any():
        return found
    other = tip_errors(reduced, held_out, basis, enrichment, held="as held")
    return TipErrors(
        error=np.maximum(found.error, other.error),  # NaN where one of both was not found
        converged=found.converged & other.converged,
        extra_columns=np.maximum(found.extra_columns, other.extra_columns),
    )


def checked_on_held_out(
    robot: Robot,
    states: StateBasis,
    basis: ContactSpace,
    held_out: Snapshots,
    report: Report,
    goal: float | None = None,
) -> StateBasis:
    """The basis with its tip errors on held-out equilibria.

    The mean is that over the range of the actuators, see `range_weights`. Where some equilibria are far
    beyond the goal, the others are not compared.

    Args:
        robot: the full model.
        states: state basis without tip errors.
        basis: contact modes.
        held_out: equilibria of the full model.
        report: called with the share of the attempt that is done since the last call, and in words.
        goal: largest error that is of use [m]; None: any is.

    Raises:
        StateBasisError: the reduced model does not converge at half of them or more.
    """
    few = held_out.select(spread(robot, held_out, FIRST_CHECKS))
    if goal is not None and 2 * len(few) < len(held_out):
        first = checked_on_held_out(
            robot, states, basis, few, lambda share, what: report(0.0, what)
        )
        if first.origin.tip_max > HOPELESS * goal:
            report(1.0 - CHOOSING, "")
            return first
    chosen = spread(robot, held_out, CHECKS)
    checks = held_out.select(chosen)
    size = f"{states.r} modes, {len(states.elements)} elements, held-out loads"
    number = count(1)

    def each() -> None:
        report((1.0 - CHOOSING) / len(checks), f"{size} {next(number)} of {len(checks)}")

    errors = check_errors(robot, states, basis, checks, each)
    good = np.isfinite(errors.error)  # (s,)
    if 2 * good.sum() <= len(checks):
        raise StateBasisError(f"converge at only {good.sum()} of {len(checks)} held-out equilibria")
    weights = range_weights(held_out.run, robot.n_a)[chosen]
    touched = good & pressed_columns(robot, checks)
    pressed = _mean_and_largest(errors.error, weights, touched) if touched.any() else None
    return states.with_tip_errors(*_mean_and_largest(errors.error, weights, good), pressed)


def _mean_and_largest(error: Array, weights: Array, chosen: Bools) -> tuple[float, float]:
    """Weighted mean and largest of the chosen errors (s,) [m]."""
    found = error[chosen]
    return float(np.average(found, weights=weights[chosen])), float(found.max())


def range_weights(run: Ints, actuators: int) -> Array:
    """How much of the actuators' range each equilibrium of runs from rest stands for: (s,), 1 at their ends.

    Runs go from rest to random commands, evenly: most of their equilibria are near rest, where a reduced
    model is better than elsewhere. Of n actuators the commands within a share x of the way to all the ends
    fill xⁿ of the range, so that an equilibrium at x stands for a part of it as x^(n − 1).
    """
    _, first, counts = np.unique(run, return_index=True, return_counts=True)
    place = np.arange(len(run)) - np.repeat(first, counts)  # (s,) in its run
    share: Array = (place + 1.0) / np.repeat(counts, counts)
    weights: Array = share ** (actuators - 1)
    return weights


def spread_places(run: Ints, most: int, whole: bool) -> Ints:
    """Equilibria at even distances among those held out, at most some number of them, the last one included.

    Runs of an even number of equilibria would be left out at their ends otherwise.

    Args:
        run: (s,) of each equilibrium, ascending.
        most: their number; a single run is taken whatever it has.
        whole: whether runs are taken or left out as a whole.
    """
    if not whole:
        return _evenly(len(run), most)
    runs = np.unique(run)
    chosen = runs[_evenly(len(runs), max(1, most * len(runs) // len(run)))]
    return np.flatnonzero(np.isin(run, chosen)).astype(np.int64)


def _evenly(count: int, most: int) -> Ints:
    """At most some of the numbers below a count at even distances, ascending, the last one included."""
    places: Ints = np.arange(count - 1, -1, -count // most)[::-1]
    return places


def spread(robot: Robot, held_out: Snapshots, most: int) -> Ints:
    """The `spread_places` of a robot: whole runs with friction, as equilibria depend on the way to them."""
    return spread_places(held_out.run, most, not robot.contacts.without_friction.all())


def modes_suffice(
    robot: Robot, states: StateBasis, basis: ContactSpace, held_out: Snapshots, goal: float
) -> bool:
    """Whether the modes of a basis, with all elements, are well within the goal at a few equilibria.

    Args:
        robot: the full model.
        states: modes and a sample, which may be too coarse.
        basis: contact modes.
        held_out: equilibria of the full model.
        goal: largest error of the tip [m].
    """
    count = reducible(robot).n_elements
    origin = replace(states.origin, sample=count)
    every = StateBasis(states.Phi, np.arange(count), np.ones(count), origin)
    few = held_out.select(spread(robot, held_out, FIRST_CHECKS))
    errors = check_errors(robot, every, basis, few)
    return bool((errors.error <= MARGIN * goal).all())
