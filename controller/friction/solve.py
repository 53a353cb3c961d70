"""Solve inverse control with Coulomb friction.

The exact point of holding is the first answer. Trials follow, each a path through smoothed laws, an exact
solution at its end, restoration of the limits and descent on exact pieces; the best exact point within the
limits is the answer, whenever the search is cut.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tauten.controller.friction.descent import GONE, descend, predicted_gain
from tauten.controller.friction.exact import NEWTON, WIDE, forces_error
from tauten.controller.friction.nearest import nearest_to_limits
from tauten.controller.friction.path import nested_path, one_shot_path
from tauten.controller.friction.problem import EffortPoint, FrictionInverse, normals_alone
from tauten.controller.friction.search import EffortSearch, effort_search
from tauten.controller.qpcc import (
    Backend,
    Budget,
    QpccSettings,
    Start,
    Status,
    TimeLimit,
    solve_qpcc,
)
from tauten.model.numerics import Array

LOWER = 1e-6  # of the objective of holding, by which a trial must be lower to replace what is known
MOVED = 0.1  # of the way to the target, that efforts move effectors where nothing hides it
RESERVED = NEWTON + 4  # linear systems: an exact solution, a slope and two QPs
SLIPPERY = 1e-3  # friction, below which the efforts without it are tried, too
SLOPING = 1e-3  # predicted gain, of the objective, from which a point counts as having a gradient


@dataclass(frozen=True, slots=True)
class PathTrial:
    """One way to look for a lower point.

    Attributes:
        share: κ at the start of the path.
        nested: whether the smoothed law is solved at each width.
        from_hold: whether the path starts from holding; else from the best point.
    """

    share: float
    nested: bool = False
    from_hold: bool = False


# the second continues from where the first has arrived
SLOPED = (PathTrial(1.0, from_hold=True), PathTrial(0.3))
# where nothing that the efforts do at first changes the objective; others only while nothing is gained
FLAT = (
    PathTrial(1.0, nested=True, from_hold=True),
    PathTrial(0.3),
    PathTrial(3.0, nested=True, from_hold=True),
    PathTrial(0.3, nested=True, from_hold=True),
)
WARM = (PathTrial(0.3, from_hold=True),)
CONTINUED = 2  # trials that run although something has been gained


@dataclass(frozen=True, slots=True)
class FrictionSettings:
    """How far the search goes.

    Attributes:
        solver: QP library for what `solve_dual` leaves, see `qpcc.qp_backend`.
        solves: linear systems, after which only the forward solution at hand is completed.
        time: after which the same; the point of holding is found in any case. None: no limit.
        path_steps: of a path, at most.
        forwards: exact solutions of a descent, at most.
        warm: whether one narrow path is enough, as from step to step of a control loop.
    """

    solver: str | Backend = "daqp"
    solves: int = 2000
    time: TimeLimit | None = None
    path_steps: int = 60
    forwards: int = 12
    warm: bool = False


@dataclass(frozen=True, slots=True)
class InverseSolution:
    """Efforts of an inverse problem with friction.

    Attributes:
        lam_a: (n_a,) efforts.
        forces: (s + 3 k,) contact forces that they cause.
        status: OK; SEEKING_CONTACT where holding has no gradient and nothing lower was found; MAX_PIVOTS
            where the search was cut; NOT_FOUND where no exact forces of holding were found; INFEASIBLE where
            holding exceeds the limits and nothing within them was found; NOT_FINITE.
        objective: f of (I1).
        held: that of holding.
        error: of the natural map over all contacts [unit of u].
        gain: share of the objective by which its piece promises to fall: stationary where it is zero.
        solves: linear systems that were solved.
    """

    lam_a: Array
    forces: Array
    status: Status
    objective: float
    held: float
    error: float
    gain: float
    solves: int


DEFAULT = FrictionSettings()


def solve_friction_inverse(
    problem: FrictionInverse,
    lam: Array,
    forces: Array | None = None,
    settings: FrictionSettings = DEFAULT,
    guess: tuple[Array, Array] | None = None,
) -> InverseSolution:
    """The best efforts found; never worse than those that are held, and exact, also when the search is cut.

    Where holding exceeds the limits, the search starts from the nearest point to them instead.

    Args:
        problem: the inverse problem.
        lam: (n_a,) efforts of holding.
        forces: (s + 3 k,) contact forces to start from; None: zero.
        settings: how far the search goes.
        guess: efforts (n_a,) and contact forces (s + 3 k,) of an answer to nearly the same problem. Where
            descent from there is lower than holding, nothing else is tried.
    """
    program = problem.program
    numbers = (*program.arrays[:2], program.G, program.M, program.m, lam)
    if not all(np.isfinite(values).all() for values in numbers):
        return _unsolved(problem, lam, Status.NOT_FINITE, 0)
    budget = Budget(settings.solves, settings.time or TimeLimit(), reserved=RESERVED)
    search = effort_search(problem, settings.solver, budget)
    start = np.zeros(len(search.contacts.q))
    if forces is not None:
        start[search.place] = forces
    held = search.exact(search.bounded(lam), start, needed=True)
    if held is None:
        return _unsolved(problem, lam, Status.NOT_FOUND, budget.spent)
    held = nearest_to_limits(search, held)
    near = None
    if guess is not None:
        r = np.zeros_like(start)
        r[search.place] = guess[1]
        near = search.exact(search.bounded(guess[0]), r)
    best, flat = _searched(search, held, near, settings)
    if problem.friction.max(initial=0.0) <= SLIPPERY and not budget.exhausted:
        near = _without_friction(search, lam, start, settings)
        best = _lower(search, near, best, settings) or best
    status = Status.OK
    if not search.feasible(best):
        status = Status.INFEASIBLE
    elif budget.exhausted:
        status = Status.MAX_PIVOTS
    elif flat and best is held:
        status = Status.SEEKING_CONTACT
    return InverseSolution(
        best.lam,
        search.rows(best.r),
        status,
        best.objective,
        held.objective,
        forces_error(search.contacts, best.lam, best.r),
        predicted_gain(search, best),
        budget.spent,
    )


def _searched(
    search: EffortSearch, held: EffortPoint, near: EffortPoint | None, settings: FrictionSettings
) -> tuple[EffortPoint, bool]:
    """The best point of a search, and whether descent from holding was out of sight.

    Args:
        search: the problem.
        held: the point of holding.
        near: exact, of a guess; None: there is none.
        settings: how far the search goes.
    """
    best = _lower(search, near, held, settings)
    if best is not None:
        return best, False
    flat = _flat(search, held, settings.warm)
    best = _best(search, held, FLAT if flat else WARM if settings.warm else SLOPED, settings)
    if flat and best.objective > (1.0 - SLOPING) * held.objective and search.feasible(held):
        best = held  # crumbs would only make the efforts drift
    return best, flat


def _flat(search: EffortSearch, held: EffortPoint, warm: bool) -> bool:
    """Whether descent from holding is out of sight.

    In a control loop most points without gain are minima; there the efforts must also be unable to move the
    effectors.

    Args:
        search: the problem.
        held: the point of holding.
        warm: whether it is a step of a control loop.
    """
    if warm:
        way = math.sqrt(2.0 * max(held.objective, 0.0))
        return held.objective > search.problem.enough and search.reach(held) <= MOVED * way
    return predicted_gain(search, held) <= SLOPING


def _best(
    search: EffortSearch,
    held: EffortPoint,
    trials: tuple[PathTrial, ...],
    settings: FrictionSettings,
) -> EffortPoint:
    """The best point of some trials; holding, where it is within the limits and none is lower.

    Args:
        search: the problem.
        held: the point of holding.
        trials: in their order.
        settings: lengths of path and descent.
    """
    best, allowed = held, search.feasible(held)
    enough = max(GONE * held.objective, search.problem.enough)
    for number, trial in enumerate(trials):
        continued = number < CONTINUED or best is held
        if search.budget.exhausted or not continued or (allowed and best.objective <= enough):
            break
        found = _tried(search, trial, held if trial.from_hold else best, held, settings)
        if found is None:
            continue
        if not allowed or found.objective < best.objective - LOWER * held.objective:
            best, allowed = found, True
    return best


def _tried(
    search: EffortSearch,
    trial: PathTrial,
    start: EffortPoint,
    held: EffortPoint,
    settings: FrictionSettings,
) -> EffortPoint | None:
    """The exact point within the limits that a trial leads to; None where it leads to none.

    Args:
        search: the problem.
        trial: how.
        start: exact, where its path starts.
        held: the point of holding.
        settings: lengths of path and descent.
    """
    wide = WIDE
    if trial.nested:
        lam, r = nested_path(search, start, trial.share)
    else:
        lam, r, wide = one_shot_path(search, start, trial.share, settings.path_steps)
    found = search.exact(lam, r, wide)
    if found is not None:
        found = search.within(found, held)
    return None if found is None else descend(search, found, held, settings.forwards)


def _without_friction(
    search: EffortSearch, lam: Array, forces: Array, settings: FrictionSettings
) -> EffortPoint | None:
    """The exact point at the efforts of the QPCC without friction, which sees other minima than a path.

    Args:
        search: the problem.
        lam: (n_a,) efforts of holding.
        forces: (3 m,) contact forces to start from.
        settings: length of the search.
    """
    program, rows = normals_alone(search.problem)
    pushing, budget = search.rows(forces)[rows] > 0.0, search.budget
    begin, limits = budget.time.clock(), QpccSettings(settings.solver, settings.path_steps)
    found = solve_qpcc(program, Start(lam, pushing), limits)
    budget.count(found.pivots, begin)
    if not found.status.usable:
        return None
    start = np.zeros(len(search.place))
    start[rows] = found.beta
    near = np.zeros_like(forces)
    near[search.place] = start
    return search.exact(search.bounded(found.lam_a), near)


def _lower(
    search: EffortSearch, near: EffortPoint | None, held: EffortPoint, settings: FrictionSettings
) -> EffortPoint | None:
    """The point that descent from a guess leads to; None where it is no lower than what is known.

    Args:
        search: the problem.
        near: exact; None: there is none.
        held: the point of holding.
        settings: length of the descent.
    """
    if near is not None:
        near = search.within(near, held)
    if near is None:
        return None
    found = descend(search, near, held, settings.forwards)
    lower = found.objective < (1.0 - LOWER) * held.objective or not search.feasible(held)
    return found if lower else None


def _unsolved(problem: FrictionInverse, lam: Array, status: Status, solves: int) -> InverseSolution:
    """No solution, with the reason."""
    none = np.zeros(len(problem.program.m))
    return InverseSolution(lam, none, status, np.inf, np.inf, np.inf, 0.0, solves)
