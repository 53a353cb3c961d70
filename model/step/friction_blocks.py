"""A step with friction as blocks between its contacts, actuators and effectors, and under given friction.

What decides for a target with friction needs the blocks; what decides without friction takes that of the last
step as a load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tauten.model.friction import (
    PROJECTIONS,
    FrictionCertificate,
    FrictionProblem,
    certify_friction,
    moving_contacts,
)
from tauten.model.numerics import Array, Ints
from tauten.model.step.compliance import Compliance
from tauten.model.step.condensed_step import CondensedStep
from tauten.model.step.enrichment import PredictedStep
from tauten.model.step.forces import Forces
from tauten.model.step.friction_law import unit_start

QUICK = PROJECTIONS // 20  # of the certificate that a node computes between two ticks


@dataclass(frozen=True, slots=True)
class FrictionBlocks:
    """The working set of a step with friction, its unit columns: k contacts of three rows each.

    With forces r (3 k,) and λ_a (n_a,):

        u   = q_c + W_cc r + W_ca λ_a         gap and slip of each contact at the end of the step
        δ_a = q_a + W_caᵀ r + W_aa λ_a        positions of the actuators
        δ_e = q_e + W_ec r + W_ea λ_a         effector rows

    The rows of a contact follow one another: its normal, then its two tangents. Contacts without friction
    have tangents too, and μ = 0. Columns of a contact basis are not among them.

    Attributes:
        W_cc: (3 k, 3 k) compliance between contacts [m/N].
        W_ca: (3 k, n_a) of contacts under efforts.
        W_aa: (n_a, n_a) of actuators, those with springs at the motor.
        W_ec: (n_e, 3 k) of effectors under contact forces.
        W_ea: (n_e, n_a) of effectors under efforts.
        q_c: (3 k,) gaps, and slip since the start of the step, without forces [m].
        q_a: (n_a,) positions of the actuators without forces [m, m³].
        q_e: (n_e,) effector rows without forces.
        mu: (k,) coefficients of friction.
        slots: (k,) slots of the contacts.
        normals: (k, 3) and
        tangents: (k, 2, 3) unit directions of the rows.
        r: (3 k,) forces of the last step on these rows [N], where a solver may start.
    """

    W_cc: Array
    W_ca: Array
    W_aa: Array
    W_ec: Array
    W_ea: Array
    q_c: Array
    q_a: Array
    q_e: Array
    mu: Array
    slots: Ints
    normals: Array
    tangents: Array
    r: Array


def friction_blocks(step: CondensedStep, previous: Forces) -> FrictionBlocks:
    """The blocks of a step with friction.

    More contacts join with `CondensedStep.with_unit_columns`, those that `worst_rows` names.

    Args:
        step: `Prepared.step` over a tick, `Prepared.farther` over the horizon.
        previous: forces of the last step.

    Raises:
        ValueError: no contact in range has friction.
    """
    if not step.frictional:
        raise ValueError("friction_blocks: no contact in range has friction")
    W, free = step.compliance.W, step.compliance.delta_free
    e, a = step.layout.effectors, step.layout.actuators
    c = slice(a.stop + len(step.reduced), None)
    found = step.rows.contacts.found
    return FrictionBlocks(
        W[c, c], W[c, a], W[a, a], W[e, c], W[e, a], free[c], free[a], free[e],
        found.friction[step.extra], found.slots[step.extra], found.normal[step.extra],
        found.tangents(step.extra), unit_start(step, previous),
    )  # fmt: skip


def step_certificate(solved: PredictedStep, quickly: bool = False) -> FrictionCertificate | None:
    """The certificate of the contacts with friction of a solved step; None where none pushes.

    Its W is that under given efforts, so that forces are indeterminate where others give the same motion
    without a change of the efforts. Its error is that of all candidates in range: one without force has an
    error where it is predicted to penetrate.

    Args:
        solved: the step and its forces.
        quickly: whether contacts that are jammed are looked for with a twentieth of the projections.
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

    Args:
        step: the step; it is returned as it is where no contact in range has friction.
        previous: forces of the last step.
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
    contacts = replace(step.rows.contacts, tangents=None)
    rows = replace(step.rows, contacts=contacts)
    return replace(
        step, system=pushed, rows=rows, compliance=compliance, frictional=False, slid=None
    )
