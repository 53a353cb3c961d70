"""Ways through smoothed laws of contact: from any start to efforts near which no contact hides the gradient.

`one_shot_path` shrinks the widths each step, and a step is one linearisation and one QP in the efforts.
`nested_path` solves the smoothed law at each width before it moves the efforts, and moves them only downhill:
it takes three times as many linear systems and also arrives where hold has no gradient.

Both go on where a path was cut, and take a few steps whatever the budget, so that one that is cut again and
again comes to its end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tauten.controller.friction.effort_step import EffortArrays, effort_measures, effort_step
from tauten.controller.friction.exact import NARROWER
from tauten.controller.friction.problem import EffortPoint, InverseContacts, cones_at
from tauten.controller.friction.search import EffortSearch
from tauten.model.friction import (
    Cones,
    LinearLaw,
    Width,
    Widths,
    law_error,
    law_size,
    linear_law,
    shortened,
    smoothed_law,
    widths,
)
from tauten.model.numerics import Array, kernel

NARROWEST = 1e-2  # κ at the end
LAST_GATE = 0.1  # error of the law, of its widths, up to which it counts as met there
ENOUGH_NARROW = 2  # steps that meet the law there
AT_ONCE = 4  # steps between two looks at the clock
SHRINK = 0.6  # of κ, in the nested form
ASTRAY = 20.0  # the same above which the efforts wait
SHORTEST = 1.0 / 32.0
TRUST = 0.1  # of the span of the efforts, a step at first
WIDEST = 4.0  # of that, later
GROW, CUT = 1.5, 0.5  # of the trust region
ENOUGH = 0.7  # share of a step above which the trust region grows
MET = 1e-2  # error of the law, of its widths, that counts as none in the nested form
LAW_STEPS = 12  # of Newton at a width
NESTED = 200  # linear systems of the nested form, at most, unless it goes on from a cut


def displacement_scale(search: EffortSearch, start: EffortPoint) -> float:
    """Displacement that matters: that from the target, at least a millionth of the largest one."""
    least = 1e-6 * float(np.abs(search.contacts.q).max())
    return max(float(np.sqrt(2.0 * max(start.objective, 0.0))), least, 1e-300)


class Pace(NamedTuple):
    """How fast a path goes.

    Attributes:
        shrink: factor of κ where the law is met.
        gate: error of the law, of its widths, up to which it counts as met.
    """

    shrink: float
    gate: float


SLOW = Pace(0.6, 0.1)  # more of the best known minima
FAST = Pace(0.5, 0.3)  # nearer to targets that move with the steps that a control loop has time for


class PathState(NamedTuple):
    """Where a path is.

    Attributes:
        lam: (n_a,) efforts.
        r: (3 m,) smoothed forces.
        trust: (n_a,) largest change of each effort.
        share: κ.
        narrow: steps that have met the law at the end of κ; with two the path is at its end.
    """

    lam: Array
    r: Array
    trust: Array
    share: float
    narrow: int


@dataclass(frozen=True, slots=True)
class PathEnd:
    """Where a path has arrived.

    Attributes:
        state: there.
        steps: that it has taken, those before a cut too.
        wide: how wide the law is there.
        cut: whether the budget has ended it.
    """

    state: PathState
    steps: int
    wide: Width
    cut: bool


def one_shot_path(
    search: EffortSearch,
    start: EffortPoint,
    share: float,
    pace: Pace,
    steps: int,
    before: PathEnd | None,
) -> PathEnd:
    """The end of a path.

    Args:
        search: the problem.
        start: an exact point.
        share: κ at first; 1 is wide.
        pace: how fast it shrinks.
        steps: linear systems, at most; some of them are solved whatever the budget.
        before: where the path was cut; None: it begins.
    """
    contacts, length, budget = search.contacts, displacement_scale(search, start), search.budget
    state, taken = _begin(search, start, share, before)
    widest, end = WIDEST * TRUST * search.span, budget.spent + steps - taken
    cut = False
    while state.narrow < ENOUGH_NARROW and budget.spent < end and not cut:
        number = min(budget.at_once(AT_ONCE), end - budget.spent)
        begin = budget.time.clock()
        state, spent = path_steps(contacts, search.arrays, state, length, widest, pace, number)
        budget.count(spent, begin)
        taken += spent
        cut = budget.exhausted or not budget.allows(AT_ONCE)
    cut &= state.narrow < ENOUGH_NARROW and budget.spent < end
    return PathEnd(state, taken, Width(state.share, length, NARROWER), cut)


def _begin(
    search: EffortSearch, start: EffortPoint, share: float, before: PathEnd | None
) -> tuple[PathState, int]:
    """Where a path begins, or goes on, and the steps that it has taken.

    Args:
        search: the problem.
        start: an exact point.
        share: κ at first.
        before: where the path was cut; None: it begins.
    """
    if before is None:
        return PathState(start.lam, start.r, TRUST * search.span, share, 0), 0
    return before.state._replace(lam=search.bounded(before.state.lam)), before.steps


@kernel
def path_steps(
    contacts: InverseContacts,
    arrays: EffortArrays,
    state: PathState,
    length: float,
    widest: Array,
    pace: Pace,
    steps: int,
) -> tuple[PathState, int]:
    """Where some steps of a path lead to, and how many were taken until its end.

    Args:
        contacts: the contacts.
        arrays: objective and limits.
        state: where the path is.
        length: displacement that matters.
        widest: (n_a,) largest trust region.
        pace: how fast κ shrinks.
        steps: at most.
    """
    lam, r, trust, share, narrow = state
    for step in range(steps):
        width = widths(contacts.w, r, share, length)
        cones = cones_at(contacts, lam)
        law = linear_law(cones, contacts.G, r, width, contacts.W_ca)
        change = np.zeros(len(lam))
        if law_error(width, law.F) <= ASTRAY:
            ahead = r + law.residual
            solved, found, _ = effort_step(arrays, lam, ahead, law.slope, trust)
            change = found if solved else change
        gate = pace.gate if share > NARROWEST else min(pace.gate, LAST_GATE)
        taken, error, lam, r = line_search(cones, contacts.W_ca, lam, r, change, law, width, gate)
        trust = np.minimum(GROW * trust, widest) if taken > ENOUGH else CUT * trust
        if error <= gate:
            narrow += int(share <= NARROWEST)
            if narrow == ENOUGH_NARROW:
                return PathState(lam, r, trust, share, narrow), step + 1
            share = max(pace.shrink * share, NARROWEST)
    return PathState(lam, r, trust, share, narrow), steps


@kernel
def line_search(
    cones: Cones,
    W_ca: Array,
    lam: Array,
    r: Array,
    change: Array,
    law: LinearLaw,
    width: Widths,
    gate: float,
) -> tuple[float, float, Array, Array]:
    """The share of a step, the error of the law after it, efforts (n_a,) and forces (3 m,) there.

    Args:
        cones: the contacts at these efforts.
        W_ca: (3 m, n_a) of contacts under efforts.
        lam: (n_a,) efforts.
        r: (3 m,) forces.
        change: (n_a,) of the efforts.
        law: linearised.
        width: of the law.
        gate: error of the law that is accepted.
    """
    follow = law.residual + np.dot(law.slope, change)
    du = (np.dot(W_ca, change) + np.dot(cones.W, follow)).reshape(law.u.shape)
    taken, before = 1.0, law_size(width, law.F)
    while True:
        there = r + taken * follow
        F = smoothed_law(cones, law.u + taken * du, there, width)
        error = law_error(width, F)
        better = error <= gate or law_size(width, F) < (1.0 - 1e-4 * taken) * before
        if better or 0.5 * taken < SHORTEST:
            return taken, error, lam + taken * change, there
        taken *= 0.5


def nested_path(
    search: EffortSearch, start: EffortPoint, share: float, before: PathEnd | None
) -> PathEnd:
    """The same where the smoothed law is solved at each width, and the efforts move only downhill.

    Args:
        search: the problem.
        start: an exact point.
        share: κ at first.
        before: where the path was cut; None: it begins.
    """
    contacts, length, budget = search.contacts, displacement_scale(search, start), search.budget
    (lam, r, trust, share, _), taken = _begin(search, start, share, before)
    widest, first, end = TRUST * search.span, budget.spent, budget.spent + NESTED - taken
    while True:
        width = widths(contacts.w, r, share, length)
        r, slope, _ = _meet(search, lam, r, width)
        objective, cut = effort_measures(search.arrays, lam, r)[0], False
        for _ in range(4):
            step = search.step(lam, r, slope, trust)
            if step is None or step.gain < 1e-3 * objective:
                break
            ahead = r + slope @ step.change
            there = lam + step.change
            found, turned, met = _meet(search, there, ahead, width)
            value = effort_measures(search.arrays, there, found)[0]
            if met and value < objective - 0.1 * step.gain:
                if value < objective - 0.5 * step.gain:
                    trust = np.minimum(2.0 * trust, WIDEST * widest)
                lam, r, slope = there, found, turned
                break
            trust = 0.25 * np.minimum(trust, np.abs(step.change).max())
            cut = budget.spent - first >= AT_ONCE and budget.exhausted
            if cut:
                break
        arrived = not cut and (share <= NARROWEST or budget.spent > end)
        if not (cut or arrived):
            share = max(SHRINK * share, NARROWEST)
            cut = budget.spent - first >= AT_ONCE and budget.exhausted
        if cut or arrived:
            state = PathState(lam, r, trust, share, ENOUGH_NARROW if arrived else 0)
            return PathEnd(state, taken + budget.spent - first, Width(share, length, NARROWER), cut)


def _meet(search: EffortSearch, lam: Array, r: Array, width: Widths) -> tuple[Array, Array, bool]:
    """Forces (3 m,) that meet the smoothed law at efforts, their slope (3 m, n_a), and whether they do.

    Args:
        search: the problem.
        lam: (n_a,) efforts.
        r: (3 m,) forces to start from.
        width: of the law.
    """
    begin = search.budget.time.clock()
    found, slope, error, spent = meet_law(search.contacts, lam, r, width, LAW_STEPS)
    search.budget.count(spent, begin)
    return found, slope, error <= 10.0 * MET


@kernel
def meet_law(
    contacts: InverseContacts, lam: Array, r: Array, width: Widths, systems: int
) -> tuple[Array, Array, float, int]:
    """Forces (3 m,) under the smoothed law, slope (3 m, n_a), error of the law, and linear systems.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        r: (3 m,) forces to start from.
        width: of the law.
        systems: at most.
    """
    cones = cones_at(contacts, lam)
    law = linear_law(cones, contacts.G, r, width, contacts.W_ca)
    spent, error = 1, law_error(width, law.F)
    while error > MET and spent < systems:
        _, r, _ = shortened(cones, r, law, width)
        law = linear_law(cones, contacts.G, r, width, contacts.W_ca)
        spent, error = spent + 1, law_error(width, law.F)
    return r, law.slope, error, spent
