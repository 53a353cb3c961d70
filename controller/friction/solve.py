"""Solve inverse control with Coulomb friction.

The exact point of holding is the first answer. Trials follow, each a path through smoothed laws, an exact
solution at its end, restoration of the limits and descent on exact pieces; the best exact point within the
limits is the answer, whenever the search is cut. One that is cut tells where, and the next one goes on from
there: so searches that are all cut come to an end together.

Below, `search` is the problem, `held` the exact point of holding, `near` one of a guess or None, `settings`
how far the search goes, and `before` where it was cut before, or None.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tauten.controller.friction.descent import GONE, descend, predicted_gain
from tauten.controller.friction.exact import TRIED, WIDE
from tauten.controller.friction.nearest import nearest_to_limits, within_limits
from tauten.controller.friction.path import AT_ONCE, PathEnd, nested_path, one_shot_path
from tauten.controller.friction.problem import EffortPoint, FrictionInverse, normals_alone
from tauten.controller.friction.search import EffortSearch, effort_search
from tauten.controller.friction.trials import FLAT, SEEK, SLOPED, WARM, CutSearch, PathTrial
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
MOVED = 0.1  # of the way to the target, or of open contacts, that efforts move effectors unless hindered
UNMOVED = 1e-6  # of the way to the target, that counts as no motion
RESERVED = AT_ONCE + TRIED + 4  # linear systems: of a path, an exact solution, a slope and two QPs
SLIPPERY = 1e-3  # friction, below which the efforts without it are tried, too
SLOPING = 1e-3  # predicted gain, of the objective, from which a point counts as having a gradient


@dataclass(frozen=True, slots=True)
class FrictionSettings:
    """How far the search goes.

    Attributes:
        solver: QP library for what `solve_dual` leaves, see `qpcc.qp_backend`.
        solves: linear systems, after which only the forward solution at hand is completed.
        time: after which the same; the point of holding is found in any case. None: no limit.
        path_steps: of a path, at most; 0: no paths.
        forwards: exact solutions of a descent, at most.
        warm: whether one narrow path is enough, as from step to step of a control loop.
        seeking: whether the search is for contact, without which no effort moves the effectors.
    """

    solver: str | Backend = "daqp"
    solves: int = 2000
    time: TimeLimit | None = None
    path_steps: int = 60
    forwards: int = 12
    warm: bool = False
    seeking: bool = False


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
        excess: over the limits at most, in the unit of their rows.
        gain: share of the objective by which its piece promises to fall: stationary where it is zero.
        solves: linear systems that were solved.
        cut: where the search was cut; None: it was not.
    """

    lam_a: Array
    forces: Array
    status: Status
    objective: float
    held: float
    error: float
    excess: float
    gain: float
    solves: int
    cut: CutSearch | None = None


DEFAULT = FrictionSettings()


def solve_friction_inverse(
    problem: FrictionInverse,
    lam: Array,
    forces: Array | None = None,
    settings: FrictionSettings = DEFAULT,
    guess: tuple[Array, Array] | None = None,
    before: CutSearch | None = None,
) -> InverseSolution:
    """The best efforts found; never worse than those that are held, and exact, also when the search is cut.

    Where holding exceeds the limits, the search starts from the nearest point to them instead. Some steps of
    a path and one exact solution are taken whatever the budget.

    Args:
        problem: the inverse problem.
        lam: (n_a,) efforts of holding.
        forces: (s + 3 k,) contact forces to start from; None: zero.
        settings: how far the search goes.
        guess: efforts (n_a,) and contact forces (s + 3 k,) of an answer to nearly the same problem. Where
            descent from there is lower than holding, nothing else is tried.
        before: where a search of nearly the same problem was cut.
    """
    program = problem.program
    numbers = (program.Q.ravel(), program.c, program.G.ravel(), program.M.ravel(), program.m, lam)
    if not np.isfinite(np.concatenate(numbers)).all():
        return _unsolved(problem, lam, Status.NOT_FINITE, 0)
    budget = Budget(settings.solves, settings.time or TimeLimit(), reserved=RESERVED)
    search = effort_search(problem, settings.solver, budget)
    start = np.zeros(len(search.contacts.q))
    if forces is not None:
        start[search.place] = forces
    held = search.exact(lam, start, needed=True)
    if held is None:
        return _unsolved(problem, lam, Status.NOT_FOUND, budget.spent)
    if not search.feasible(held):
        held = nearest_to_limits(search, held)
    near = None
    if guess is not None:
        r = np.zeros_like(start)
        r[search.place] = guess[1]
        near = search.exact(guess[0], r)
    best, flat, cut = _searched(search, held, near, settings, before)
    if problem.friction.max(initial=0.0) <= SLIPPERY and not budget.exhausted:
        near = _without_friction(search, lam, start, settings)
        best = _lower(search, near, best, settings) or best
    if best is held and budget.exhausted and search.feasible(held):
        best = descend(search, held, held, 1, at_least=1)
    return InverseSolution(
        best.lam,
        search.rows(best.r),
        _status(search, best, flat and best is held, cut),
        best.objective,
        held.objective,
        best.error,
        best.excess,
        predicted_gain(search, best),
        budget.spent,
        cut,
    )


def _status(search: EffortSearch, best: EffortPoint, hidden: bool, cut: CutSearch | None) -> Status:
    """The status of an answer; `hidden`: it is holding, from where descent is out of sight."""
    if not search.feasible(best):
        return Status.INFEASIBLE
    if hidden and cut is None:
        return Status.SEEKING_CONTACT
    return Status.MAX_PIVOTS if search.budget.exhausted else Status.OK


def _searched(
    search: EffortSearch,
    held: EffortPoint,
    near: EffortPoint | None,
    settings: FrictionSettings,
    before: CutSearch | None,
) -> tuple[EffortPoint, bool, CutSearch | None]:
    """The best point of a search, whether descent from holding was out of sight, and where it was cut."""
    best = _lower(search, near, held, settings)
    if best is not None:
        return best, False, None
    flat = settings.seeking or _flat(search, held, settings.warm)
    trials: tuple[PathTrial, ...] = SEEK if settings.seeking else FLAT
    if not flat:
        trials = WARM if settings.warm else SLOPED
    met, apart = search.away(held) <= search.problem.near, not search.contacts.W_ca.any()
    if flat and (met or apart):  # efforts move nothing that contacts could move
        trials = ()
    if before is not None:
        before = before.on_all_rows(search) if before.flat is flat else None
    best, cut = _best(search, held, trials, settings, before)
    least = (1.0 - SLOPING) * search.away(held)
    if flat and search.away(best) > least and search.feasible(held):
        best = held  # crumbs and energy would only make the efforts drift
    if cut is None:
        return best, flat, None
    number, path = cut
    found = CutSearch(flat, number, path)
    return best, flat, found if path is None else found.with_forces(search.rows(path.state.r))


def _flat(search: EffortSearch, held: EffortPoint, warm: bool) -> bool:
    """Whether descent from holding is out of sight; `warm`: in a step of a control loop.

    There most points without gain are minima; the efforts must also be unable to move the effectors, while
    they move contacts that nothing touches. How far that is depends on the limits of a tick, so that a target
    far away alone does not count.
    """
    if warm:
        if held.objective <= search.problem.enough:
            return False
        way, (reach, free) = math.sqrt(2.0 * max(held.objective, 0.0)), search.reach(held)
        return reach <= max(MOVED * min(way, free), UNMOVED * way)
    return predicted_gain(search, held) <= SLOPING


def _best(
    search: EffortSearch,
    held: EffortPoint,
    trials: tuple[PathTrial, ...],
    settings: FrictionSettings,
    before: CutSearch | None,
) -> tuple[EffortPoint, tuple[int, PathEnd | None] | None]:
    """The best point of some trials in their order, and which one was cut where.

    It is holding, where that is within the limits and none is lower.
    """
    best, allowed = held, search.feasible(held)
    enough = max(GONE * held.objective, search.problem.enough)
    first, least = 0 if before is None else before.trial, (1.0 - SLOPING) * search.away(held)
    for number in range(first, len(trials) if settings.path_steps > 0 else 0):
        continued = not trials[number].fallback or search.away(best) > least
        spent = number > first and search.budget.exhausted
        if spent or not continued or (allowed and best.objective <= enough):
            break
        trial, path = trials[number], before.path if before and number == first else None
        found, end = _tried(search, trial, held if trial.from_hold else best, held, settings, path)
        lower = found is not None and found.objective < best.objective - LOWER * held.objective
        if found is not None and (lower or not allowed):
            best, allowed = found, True
        if end.cut:
            return best, (number, end)
        if best is held and search.budget.exhausted:
            if path is not end:
                return best, (number, end)
            if number + 1 < len(trials):
                return best, (number + 1, None)
    return best, None


def _tried(
    search: EffortSearch,
    trial: PathTrial,
    start: EffortPoint,
    held: EffortPoint,
    settings: FrictionSettings,
    before: PathEnd | None,
) -> tuple[EffortPoint | None, PathEnd]:
    """The exact point within the limits that a trial leads to from an exact start, or None, and its path.

    The path goes on, or has ended, where `before` says.
    """
    if before is not None and not before.cut:
        path = before
    elif trial.nested:
        path = replace(nested_path(search, start, trial.share, before), wide=WIDE)
    else:
        path = one_shot_path(search, start, trial.share, trial.pace, settings.path_steps, before)
    # nothing else moves the robot where descent is out of sight: then time must not prevent it for ever
    needed = trial.nested and path is before
    found = search.exact(path.state.lam, path.state.r, path.wide, needed)
    if found is not None:
        found = within_limits(search, found, held)
    if found is None:
        return None, path
    return descend(search, found, held, settings.forwards, brief=settings.warm), path


def _without_friction(
    search: EffortSearch, lam: Array, forces: Array, settings: FrictionSettings
) -> EffortPoint | None:
    """The exact point at the efforts of the QPCC without friction, which sees other minima than a path.

    It starts from the efforts of holding (n_a,) and contact forces (3 m,).
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
    return search.exact(found.lam_a, near)


def _lower(
    search: EffortSearch, near: EffortPoint | None, held: EffortPoint, settings: FrictionSettings
) -> EffortPoint | None:
    """The point that descent from a guess leads to; None where it is no lower than what is known."""
    if near is not None:
        near = within_limits(search, near, held)
    if near is None:
        return None
    found = descend(search, near, held, settings.forwards, brief=settings.warm)
    lower = found.objective < (1.0 - LOWER) * held.objective or not search.feasible(held)
    return found if lower else None


def _unsolved(problem: FrictionInverse, lam: Array, status: Status, solves: int) -> InverseSolution:
    """No solution, with the reason."""
    none = np.zeros(len(problem.program.m))
    return InverseSolution(lam, none, status, np.inf, np.inf, np.inf, np.inf, 0.0, solves)
