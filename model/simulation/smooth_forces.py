"""Contact forces of nearly least norm, which do not depend on which candidates pushed before."""

from __future__ import annotations

import numpy as np

from tauten.model.layout import row_layout
from tauten.model.numerics import Array, solve_lcp
from tauten.model.robot import Robot
from tauten.model.state import State
from tauten.model.step import Forces, row_compliance

# Regularisation of smooth forces relative to the diagonal of W; larger is smoother.
SMOOTHING = 1e-6


def smooth_contact_forces(robot: Robot, state: State, forces: Forces) -> Array:
    """Normal forces of nearly least norm at an equilibrium, with its friction as a load: (n_c,) [N]."""
    rows = robot.rows(state)
    contacts = rows.contacts
    lam_c = np.zeros(robot.n_c)
    if len(contacts) == 0:
        return lam_c
    system = robot.static_system(state, forces.effort)
    H = np.vstack([rows.actuators.dense(), contacts.rows.dense()])
    response = row_compliance(
        system, H, np.concatenate([rows.actuators.delta, contacts.rows.delta])
    )
    layout = row_layout(0, robot.n_a)
    a, c = layout.actuators, layout.contacts
    W = response.W[c, c]
    delta = response.delta_free[c] + response.W[c, a] @ forces.effort
    if forces.friction is not None and contacts.relative is not None:
        _, own, at = np.intersect1d(contacts.slots, forces.extra, return_indices=True)
        axes = contacts.found.axes(own)
        across = np.einsum("rti,ri->rt", axes, forces.friction.force[at]).ravel()
        delta += system.h**2 * (response.X[c] @ (contacts.relative.along(axes, own).T @ across))
    lam_c[contacts.slots] = solve_lcp(W, delta, rho=SMOOTHING).lam
    return lam_c
