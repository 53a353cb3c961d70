"""The certificate of a step with friction, and the step under given friction.

What decides without friction takes that of the last step as a load.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tauten.model.friction import (
    PROJECTIONS,
    FrictionCertificate,
    FrictionProblem,
    certify_friction,
    moving_contacts,
)
from tauten.model.step.compliance import Compliance
from tauten.model.step.condensed_step import NO_AXES, CondensedStep
from tauten.model.step.enrichment import PredictedStep
from tauten.model.step.forces import Forces
from tauten.model.step.friction_law import unit_start

QUICK = PROJECTIONS // 20  # of the certificate that a node computes between two ticks


def step_certificate(solved: PredictedStep, quickly: bool = False) -> FrictionCertificate | None:
    """The certificate of the contacts with friction of a solved step; None where none pushes.

    Its W is that under given efforts, so that forces are indeterminate where others give the same motion
    without a change of the efforts. Its error is that of all candidates in range: one without force has an
    error where it is predicted to penetrate. Quickly, contacts that are jammed are looked for with a
    twentieth of the projections.
    """
    step, projections = solved.step, QUICK if quickly else PROJECTIONS
    if not step.frictional or not solved.contacts_push:
        return None
    c = slice(step.layout.n_e + step.layout.n_a + len(step.reduced), None)
    W, r, delta = step.compliance.W[c, c], solved.lam[c], solved.delta[c]
    mu = step.rows.contacts.found.friction[step.extra]
    moves, rows = moving_contacts(W)
    W, r = W[rows[:, None], rows], r[rows]
    found = certify_friction(FrictionProblem(W, delta[rows] - W @ r, mu[moves]), r, projections)
    gaps = step.rows.contacts.rows.after(step.system.h, step.system.v + solved.dv)
    gaps[step.extra] = 0.0  # these are rows of the problem, or on what is fixed
    return replace(found, error=max(found.error, -float(gaps.min(initial=0.0))))


def under_friction(step: CondensedStep, previous: Forces) -> CondensedStep:
    """A step with the friction of the last step as a load, in which contacts have their normal row alone.

    It is returned as it is where no contact in range has friction.
    """
    if not step.frictional:
        return step
    known, system = step.compliance, step.system
    first = step.layout.n_e + step.layout.n_a + len(step.reduced)
    units = first + np.arange(len(known) - first)
    normal, across = units[::3], units.reshape(-1, 3)[:, 1:].ravel()
    kept = np.concatenate([np.arange(first), normal])
    load = unit_start(step, previous).reshape(-1, 3)[:, 1:].ravel()  # (2 r,) N
    compliance = Compliance(
        known.H[kept],
        known.Y[kept],
        known.W[kept[:, None], kept],
        known.delta_free[kept] + known.W[kept[:, None], across] @ load,
        known.halves,
    )
    v_free = system.v_free + system.h * known.pushed(load, across)
    pushed = replace(system, v_free=v_free)
    contacts = replace(step.rows.contacts, relative=None)
    rows = replace(step.rows, contacts=contacts)
    return replace(
        step, system=pushed, rows=rows, axes=NO_AXES, compliance=compliance, frictional=False,
        slid=None,
    )  # fmt: skip
