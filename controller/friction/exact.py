"""Exact contact forces at efforts, and their derivative on the piece that they belong to."""

from __future__ import annotations

import numpy as np

from tauten.controller.friction.effort_step import EffortArrays, effort_measures
from tauten.controller.friction.problem import EffortPoint, InverseContacts, cones_at
from tauten.controller.qpcc import Budget
from tauten.model.friction import Width, error_of, newton_forces, smoothed_forces, velocities
from tauten.model.numerics import Array, kernel, solve_linear

PRECISELY = 0.3  # of the error that counts as exact: what is asked for, so that it stays exact
TRIED = 15  # steps on the exact law, at most
NEWTON = 45  # the same where forces are needed: contacts that are redundant may take as many
SMOOTHED = 60  # steps on the smoothed law, at most
LENGTH = 1e-2  # of the largest |q|: displacement that sets the widths
NARROWER = 0.25  # of κ, after a full step on the smoothed law
STILL = 1e-7  # of the largest |q|, slip that counts as none
OPEN = 1e-8  # of the largest |q|, w r_n that counts as none
PROXIMAL = 1e-10  # of the largest compliance, by which redundant contacts yield
# Of the smoothed law; a length of zero: `LENGTH` of the largest |q|.
WIDE = Width(1.0, 0.0, NARROWER)


def exact_point(
    contacts: InverseContacts,
    arrays: EffortArrays,
    lam: Array,
    start: Array,
    budget: Budget,
    wide: Width,
    needed: bool,
) -> EffortPoint | None:
    """The exact point at efforts, brought within their bounds; None where none is found.

    Args:
        contacts: the contacts.
        arrays: objective and limits.
        lam: (n_a,) efforts.
        start: (3 m,) forces to start from.
        budget: linear systems are counted; where it has none left, the smoothed law is not tried.
        wide: of the smoothed law that is tried where the exact one fails.
        needed: whether the smoothed law is tried in any case.
    """
    begin, newton = budget.time.clock(), NEWTON if needed else TRIED
    found, point, spent = point_at(contacts, arrays, lam, start, newton, np.inf)
    budget.count(spent, begin)
    if not found and (needed or (not budget.exhausted and budget.allows(SMOOTHED + TRIED))):
        begin = budget.time.clock()
        near, systems = smoothed_at(contacts, point.lam, start, wide)
        found, point, spent = point_at(contacts, arrays, lam, near, newton, np.inf)
        budget.count(systems + spent, begin)
    return point if found else None


@kernel
def point_at(
    contacts: InverseContacts,
    arrays: EffortArrays,
    lam: Array,
    start: Array,
    newton: int,
    farthest: float,
) -> tuple[bool, EffortPoint, int]:
    """Whether the forces at efforts within their bounds are exact, the point there, and linear systems.

    Args:
        contacts: the contacts.
        arrays: objective and limits.
        lam: (n_a,) efforts.
        start: (3 m,) forces to start from.
        newton: steps on the exact law, at most.
        farthest: error of the natural map at the start, beyond which none is taken.
    """
    within = np.minimum(np.maximum(lam, arrays.lb), arrays.ub)
    error, r, systems = forces_at(contacts, within, start, newton, farthest)
    if not error <= contacts.exact:
        return False, EffortPoint(within, r, error, np.empty((0, 0)), np.inf, np.inf), systems
    slope = slope_at(contacts, within, r)
    objective, excess = effort_measures(arrays, within, r)
    return True, EffortPoint(within, r, error, slope, objective, excess), systems + 1


@kernel
def smoothed_at(
    contacts: InverseContacts, lam: Array, start: Array, wide: Width
) -> tuple[Array, int]:
    """Forces (3 m,) at efforts at the end of a path through smoothed laws, and linear systems.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        start: (3 m,) forces to start from.
        wide: at first.
    """
    cones = cones_at(contacts, lam)
    length = wide.length if wide.length > 0.0 else LENGTH * np.abs(cones.q).max()
    return smoothed_forces(
        cones, contacts.G, start, Width(wide.share, length, wide.shrink), SMOOTHED
    )


@kernel
def forces_at(
    contacts: InverseContacts, lam: Array, start: Array, newton: int, farthest: float
) -> tuple[float, Array, int]:
    """Error of the natural map of the best forces found at efforts, these (3 m,), and linear systems.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        start: (3 m,) forces to start from; where they are exact they are returned.
        newton: steps on the exact law, at most.
        farthest: error at the start, beyond which none is taken.
    """
    cones = cones_at(contacts, lam)
    before = error_of(cones, start)
    if before <= contacts.exact or before > farthest:
        return before, start, 0
    error = PRECISELY * contacts.exact
    found = newton_forces(cones, start, error, contacts.exact, newton, bool(np.any(start)))
    return found.error, found.r, found.newton


@kernel
def slope_at(contacts: InverseContacts, lam: Array, r: Array) -> Array:
    """dr/dλ (3 m, n_a) on the piece of exact forces; one linear system.

    Open contacts keep r = 0, sticking ones u; of slipping ones u_n = 0 and r_t = −μ d r_n, where the
    direction d = u_t / |u_t| turns. Redundant contacts yield a little, so that there is a solution.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        r: (3 m,) exact forces.
    """
    slope, cones = np.zeros((len(r), len(lam))), cones_at(contacts, lam)
    u, largest = velocities(cones, r), np.abs(cones.q).max()
    closed = np.flatnonzero(contacts.w * r[::3] > OPEN * largest)
    if len(closed) == 0:
        return slope
    rows = np.empty(3 * len(closed), np.int64)
    for i, contact in enumerate(closed):
        for j in range(3):
            rows[3 * i + j] = 3 * contact + j
    W, yielding = np.empty((len(rows), len(rows))), PROXIMAL * contacts.w.max()
    for i, row in enumerate(rows):
        for j, column in enumerate(rows):
            W[i, j] = contacts.W[row, column]
        W[i, i] += yielding
    w, mu, pushed = contacts.w[closed], contacts.mu[closed], contacts.W_ca[rows]
    forces = r[rows].reshape((len(closed), 3))
    J, b = piece_rows(u[closed], forces, w, mu, W, pushed, STILL * largest)
    _, found = solve_linear(J, b)
    for i, row in enumerate(rows):
        slope[row] = found[i]
    return slope


@kernel
def piece_rows(
    u: Array, r: Array, w: Array, mu: Array, W: Array, W_ca: Array, still: float
) -> tuple[Array, Array]:
    """J (3 m, 3 m) and b (3 m, n_a) with J dr = b dλ for contacts that push.

    Args:
        u: (m, 3) displacements.
        r: (m, 3) forces.
        w: (m,) compliances.
        mu: (m,) coefficients of friction.
        W: (3 m, 3 m) compliance.
        W_ca: (3 m, n_a) of contacts under efforts.
        still: slip that counts as none.
    """
    J, b = W.copy(), -W_ca
    for i in range(len(w)):
        row, n, t = 3 * i, 3 * i + 1, 3 * i + 2
        speed = np.sqrt(u[i, 1] ** 2 + u[i, 2] ** 2)
        if speed <= still:
            continue
        d_1, d_2 = u[i, 1] / speed, u[i, 2] / speed
        # across d: θ w p·dr_t + (1 − θ) p·du_t = 0, which does not divide by the slip
        theta = speed / (speed + mu[i] * w[i] * r[i, 0])
        across = (1.0 - theta) * (d_1 * W[t] - d_2 * W[n])
        J[n], b[n] = 0.0, 0.0
        J[t] = across
        b[t] = -(1.0 - theta) * (d_1 * W_ca[t] - d_2 * W_ca[n])
        J[n, row], J[n, n], J[n, t] = mu[i] * w[i], d_1 * w[i], d_2 * w[i]
        J[t, n] -= theta * w[i] * d_2
        J[t, t] += theta * w[i] * d_1
    return J, b
