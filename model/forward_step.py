"""One forward step: given tensions or pulled lengths, what moves and what touches.

A cable wound to a length obeys the same law as a contact: its path may be shorter than the winch allows
but never longer, and it only pulls, 0 ≤ δ_a − pull ⟂ λ_a ≥ 0. One LCP contains both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.condensed_step import CondensedStep, Forces
from tauten.model.enrichment import Enrichment, EnrichmentLoop, PredictedStep
from tauten.model.numerics import Array, solve_lcp


@dataclass(frozen=True, slots=True)
class ForwardStep:
    """A solved forward step.

    Attributes:
        prediction: forces and motion.
        residual: complementarity of the LCP [m].
        converged: whether the LCP met its tolerance.
    """

    prediction: PredictedStep
    residual: float
    converged: bool


def forward_step(
    step: CondensedStep,
    enrichment: Enrichment,
    previous: Forces,
    pull: Array | None = None,
    tension: Array | None = None,
) -> ForwardStep:
    """Solve a step under pulled lengths or under tensions, one of the two.

    Args:
        step: system, rows and compliance.
        enrichment: when unit columns are added.
        previous: forces of the last step, where the LCP starts.
        pull: (n_a,) pulled lengths [m].
        tension: (n_a,) tensions [N].
    """
    loop = EnrichmentLoop(step, enrichment)
    lam = np.concatenate(
        [
            np.zeros(step.n_e),
            previous.tension,
            previous.beta[step.reduced.modes],
            np.zeros(len(step.extra)),
        ]
    )
    while loop.prediction is None:
        start = np.append(lam, np.zeros(len(loop.step.compliance) - len(lam)))
        lam, residual, converged = solve_forces(loop.step, start, pull, tension)
        loop.check(lam)
    return ForwardStep(loop.prediction, residual, converged)


def solve_forces(
    step: CondensedStep, start: Array, pull: Array | None, tension: Array | None
) -> tuple[Array, float, bool]:
    """Forces (m,) [N] under pulled lengths or tensions, complementarity residual [m], convergence.

    Args:
        step: system, rows and compliance.
        start: (m,) forces to start from [N].
        pull: (n_a,) pulled lengths [m].
        tension: (n_a,) tensions [N], where `pull` is None.
    """
    a, c = step.n_e, step.n_e + step.n_a
    W, delta, lam = step.compliance.W, step.compliance.delta_free.copy(), np.zeros_like(start)
    if pull is not None:
        delta[a:c] -= pull
        result = solve_lcp(W[a:, a:], delta[a:], start[a:])
        lam[a:] = result.lam
    else:
        assert tension is not None
        lam[a:c] = tension
        result = solve_lcp(W[c:, c:], delta[c:] + W[c:, a:c] @ tension, start[c:])
        lam[c:] = result.lam
    return lam, result.residual, result.converged
