"""The way back to limits that a point exceeds.

Steps pull a point back on its exact piece. Where contacts begin to stick the piece is short, and its slope
may point away from where the limits are met; then steps along the slope of the smoothed law go beyond it.

The QP of the efforts pulls, too, but weighs what limits are exceeded by against the objective: it ends beside
a limit that the objective pushes against, by more than is allowed. Least contact forces are such limits
wherever an effector slides on what it presses on.
"""

from __future__ import annotations

import numpy as np

from tauten.controller.friction.dual_qp import solve_dual
from tauten.controller.friction.path import LAW_STEPS, displacement_scale, meet_law
from tauten.controller.friction.problem import EffortPoint
from tauten.controller.friction.search import EffortSearch
from tauten.controller.qpcc import UNBOUNDED
from tauten.model.friction import widths
from tauten.model.numerics import Array

WEIGHED = 3  # steps that weigh limits against the objective, at most
PULLS = 16  # steps that do not, at most
TRUST = 0.3  # of the span of the efforts, a step at first
TURNS = ((0.0, 1.0), (0.1, 1.0), (0.1, 4.0), (0.1, 12.0))  # κ of the slope, length of a step
SHORTER = 0.2  # of the last steps, after all of them
SHORT = 1e-6  # weight of a step's length: the shortest of those that come as near
BACK = (0.7, 0.5, 0.25, 0.1)  # shares of the way from hold to a point beyond the limits


def within_limits(
    search: EffortSearch, point: EffortPoint, held: EffortPoint
) -> EffortPoint | None:
    """A point within the limits near one that may exceed them; None where none is found.

    With the budget used up one step of each kind is tried, and one point on the way.

    Args:
        search: the problem.
        point: exact.
        held: exact and within the limits: the last resort is the way there.
    """
    if not search.feasible(point):
        point = nearest_to_limits(search, _weighed(search, point))
    for number, share in enumerate(BACK):
        if search.feasible(point):
            return point
        if number > 0 and search.budget.exhausted:
            return None
        lam = held.lam + share * (point.lam - held.lam)
        found = search.exact(lam, held.r + share * (point.r - held.r))
        point = point if found is None else found
    return point if search.feasible(point) else None


def _weighed(search: EffortSearch, point: EffortPoint) -> EffortPoint:
    """Where some steps lead that weigh what limits are exceeded by against the objective.

    Args:
        search: the problem.
        point: exact.
    """
    for number in range(WEIGHED):
        if search.feasible(point) or (number > 0 and search.budget.exhausted):
            break
        step = search.step(point.lam, point.r, point.slope, search.span)
        if step is None:
            break
        found = search.exact(point.lam + step.change, point.r + point.slope @ step.change)
        if found is None or found.excess >= point.excess:
            break
        point = found
    return point


def nearest_to_limits(search: EffortSearch, point: EffortPoint) -> EffortPoint:
    """The exact point that exceeds the limits least among those that some steps find.

    Args:
        search: the problem.
        point: exact, where the steps start.
    """
    best, trust, refused = point, TRUST * search.span, 0
    for number in range(PULLS):
        before = best.excess
        if before <= search.allowed or (number > 0 and search.budget.exhausted):
            break
        share, longer = TURNS[refused % len(TURNS)]
        slope = _slope(search, best, share)
        lam = search.bounded(best.lam + longer * _pull(search, best, slope, trust))
        found = search.exact(lam, best.r + slope @ (lam - best.lam))
        if found is not None and found.excess < max(before - search.allowed, search.allowed):
            best, refused = found, 0
            continue
        refused += 1
        if refused % len(TURNS) == 0:
            trust = SHORTER * trust
    return best


def _slope(search: EffortSearch, point: EffortPoint, share: float) -> Array:
    """dr/dλ (3 m, n_a) at an exact point, under the smoothed law where κ is not zero.

    Args:
        search: the problem.
        point: exact.
        share: κ; 0: the slope of its piece.
    """
    if share == 0.0:
        return point.slope
    width = widths(search.contacts.w, point.r, share, displacement_scale(search, point))
    begin = search.budget.time.clock()
    _, slope, _, systems = meet_law(search.contacts, point.lam, point.r, width, LAW_STEPS)
    search.budget.count(systems, begin)
    return slope


def _pull(search: EffortSearch, point: EffortPoint, slope: Array, trust: Array) -> Array:
    """The change of the efforts (n_a,) after which limits are exceeded least, in the first order.

    Those that are kept stay kept, and none becomes worse.

    Args:
        search: the problem.
        point: exact.
        slope: (3 m, n_a) of its contact forces.
        trust: (n_a,) largest change of each effort.
    """
    arrays, unit, n_a = search.arrays, search.span, len(point.lam)
    A = (arrays.G_a + arrays.G_c @ slope) * unit  # (p, n_a)
    rows = arrays.G_a @ point.lam + arrays.G_c @ point.r
    lo, hi = arrays.g_lo - rows, arrays.g_hi - rows
    gap = np.where(lo > search.allowed, lo, np.where(hi < -search.allowed, hi, 0.0))  # (p,)
    exceeded = gap != 0.0
    if not A[exceeded].any():
        return np.zeros(n_a)
    H = A[exceeded].T @ A[exceeded]
    H += SHORT * np.trace(H) * np.eye(n_a)
    f, bounds, largest = -(A[exceeded].T @ gap[exceeded]), search.problem.program, np.diag(H).max()
    size = float(np.abs(f).max()) / largest
    lower = np.concatenate([np.maximum(bounds.lb - point.lam, -trust) / unit, np.minimum(lo, 0.0)])
    upper = np.concatenate([np.minimum(bounds.ub - point.lam, trust) / unit, np.maximum(hi, 0.0)])
    within = np.maximum(lower / size, -UNBOUNDED), np.minimum(upper / size, UNBOUNDED)
    solved, y = solve_dual(H / largest, f / (largest * size), A, *within)
    return size * unit * y if solved else np.zeros(n_a)
