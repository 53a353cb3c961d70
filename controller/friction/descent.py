"""Descent from exact point to exact point, on the derivative of the piece that each belongs to."""

from __future__ import annotations

import numpy as np

from tauten.controller.friction.exact import TRIED
from tauten.controller.friction.nearest import within_limits
from tauten.controller.friction.path import displacement_scale
from tauten.controller.friction.problem import EffortPoint
from tauten.controller.friction.search import EffortSearch

TRUST = 0.15  # of the span of the efforts, a step at first
LEAST = 1e-5  # of the objective, predicted gain below which a point counts as stationary
WORTH = 0.05  # of the predicted gain that a step must bring
GOOD = 0.5  # of the predicted gain, above which the trust region grows
ON_PIECE = 6  # steps on the exact law, at most, from a point that is lower than holding
ENDED = 50.0  # of the way to the target, error of forces after a step, beyond which its piece ends
GONE = 1e-12  # of the objective of holding, below which there is nothing left to gain


def descend(
    search: EffortSearch,
    start: EffortPoint,
    held: EffortPoint,
    forwards: int,
    at_least: int = 0,
    brief: bool = False,
) -> EffortPoint:
    """The lowest exact point within the limits that some steps find.

    Args:
        search: the problem.
        start: exact and within the limits.
        held: that of holding.
        forwards: exact solutions, at most.
        at_least: of these, whatever the budget.
        brief: whether it ends where the piece does not go on, once it is lower than holding.
    """
    best, trust, way = start, TRUST * search.span, displacement_scale(search, held)
    for number in range(forwards):
        spent = number >= at_least and search.budget.exhausted
        if spent or best.objective <= GONE * held.objective:
            break
        step = search.step(best.lam, best.r, best.slope, trust)
        if step is None or step.gain <= LEAST * best.objective:
            break
        better = best.objective < held.objective
        if brief:
            found = search.along(best, step.change, ON_PIECE if better else TRIED, ENDED * way)
        else:
            found = search.exact(best.lam + step.change, best.r + best.slope @ step.change)
        if found is not None:
            found = within_limits(search, found, held)
        if found is not None and found.objective < best.objective - WORTH * step.gain:
            if found.objective < best.objective - GOOD * step.gain:
                trust = 2.0 * trust
            best = found
        elif brief and better and found is None:
            break
        else:
            largest = float((np.abs(step.change) / search.span).max())
            trust = 0.25 * np.minimum(trust, largest * search.span)
    return best


def predicted_gain(search: EffortSearch, point: EffortPoint) -> float:
    """Share of its objective by which the piece of an exact point promises to fall.

    Args:
        search: the problem.
        point: exact.
    """
    step = search.step(point.lam, point.r, point.slope, 2.0 * TRUST * search.span)
    if step is None or not point.objective > 0.0:
        return 0.0
    return step.gain / point.objective
