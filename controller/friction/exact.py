"""Exact contact forces at efforts, and their derivative on the piece that they belong to.

Newton's steps on the exact law fail at some efforts where contacts are redundant. The smoothed law (I4) at
these efforts, with widths that shrink, has a system that is never singular: its end is a start from which the
exact law takes a step or two.
"""

from __future__ import annotations

import numpy as np

from tauten.controller.friction.law import Widths, linear_law, smoothed_law, widths
from tauten.controller.friction.problem import InverseContacts
from tauten.controller.qpcc import Budget
from tauten.model.friction import solve_friction
from tauten.model.numerics import Array, kernel

NEWTON = 30  # steps on the exact law, at most
SMOOTHED = 60  # steps on the smoothed law, at most
NARROWEST = 1e-5  # κ at the end of the smoothed law
FASTER, SLOWER = 0.25, 0.5  # factors of κ after a full step, and after a shortened one
LENGTH = 1e-2  # of the largest |q|: displacement that sets the widths
INSIDE = 0.05  # share of a normal force that a step leaves
SHORTEST = 1.0 / 64.0  # of a step's line search
STILL = 1e-7  # of the largest |q|, slip that counts as none
OPEN = 1e-8  # of the largest |q|, w r_n that counts as none
PROXIMAL = 1e-10  # of the largest compliance, by which redundant contacts yield


def exact_forces(
    contacts: InverseContacts, lam: Array, start: Array, budget: Budget, smoothed: bool = True
) -> Array | None:
    """Contact forces (3 m,) at efforts; None where none are found that are exact.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        start: (3 m,) forces to start from.
        budget: linear systems are counted; it does not end the solution.
        smoothed: whether the smoothed law is tried where the exact one fails.
    """
    problem = contacts.forward(lam)
    tolerance = contacts.tolerance(problem)
    found = solve_friction(problem, start, tolerance, NEWTON)
    budget.spent += found.newton
    if found.error > contacts.exact and smoothed:
        near = smoothed_forces(contacts, lam, start, budget)
        found = solve_friction(problem, near, tolerance, NEWTON)
        budget.spent += found.newton
    return found.r if found.error <= contacts.exact else None


def smoothed_forces(contacts: InverseContacts, lam: Array, start: Array, budget: Budget) -> Array:
    """Forces (3 m,) at efforts under the smoothed law, at the end of its widths.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        start: (3 m,) forces to start from.
        budget: linear systems are counted.
    """
    length = LENGTH * float(np.abs(contacts.q + contacts.W_ca @ lam).max())
    width = widths(contacts, start, 1.0, length)
    r = lifted(contacts, start, width)
    for _ in range(SMOOTHED):
        law = linear_law(contacts, lam, r, width)
        budget.spent += 1
        F, r, share = shortened(contacts, lam, r, law.residual, width, law.F)
        if width.error(F) <= 1.0:
            if width.share <= NARROWEST:
                break
            factor = FASTER if share > 0.9 else SLOWER
            width = widths(contacts, r, factor * width.share, length)
    return r


def lifted(contacts: InverseContacts, r: Array, width: Widths) -> Array:
    """Forces (3 m,) with normal forces that are positive, as the smoothed law has them.

    Args:
        contacts: the contacts.
        r: (3 m,) forces.
        width: of the law.
    """
    lifted = r.copy()
    lifted[::3] = np.maximum(r[::3], 0.1 * width.share * width.normal / contacts.w)
    return lifted


def inside(r: Array, change: Array, share: float) -> float:
    """The longest step, at most 1, that leaves a share of each normal force.

    Args:
        r: (3 m,) forces.
        change: (3 m,) of them.
        share: what is left at least.
    """
    normal, falling = r[::3], -change[::3]
    shrinks = falling > 0.0
    if not shrinks.any():
        return 1.0
    return min(
        1.0,
        float(
            ((1.0 - share) * np.maximum(normal, 0.0) / np.where(shrinks, falling, 1.0))[
                shrinks
            ].min()
        ),
    )


def shortened(
    contacts: InverseContacts, lam: Array, r: Array, change: Array, width: Widths, F: Array
) -> tuple[Array, Array, float]:
    """A step of the forces by line search on |F|: F (m, 3) and r (3 m,) after it, and its share.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        r: (3 m,) forces.
        change: (3 m,) of them.
        width: of the law.
        F: (m, 3) before.
    """
    share, before = inside(r, change, INSIDE), width.size(F)
    least = share * SHORTEST
    while True:
        there = r + share * change
        after = smoothed_law(contacts, lam, there, width)
        if width.size(after) < (1.0 - 1e-4 * share) * before or 0.5 * share < least:
            return after, there, share
        share *= 0.5


def exact_slope(contacts: InverseContacts, lam: Array, r: Array, budget: Budget) -> Array:
    """dr/dλ (3 m, n_a) on the piece of exact forces.

    Open contacts keep r = 0, sticking ones u; of slipping ones u_n = 0 and r_t = −μ d r_n, where the
    direction d = u_t / |u_t| turns. Redundant contacts yield a little, so that there is a solution.

    Args:
        contacts: the contacts.
        lam: (n_a,) efforts.
        r: (3 m,) exact forces.
        budget: a linear system is counted.
    """
    slope = np.zeros((len(r), len(lam)))
    u = contacts.displacements(lam, r)
    largest = float(np.abs(contacts.q + contacts.W_ca @ lam).max())
    closed = np.flatnonzero(contacts.w * r[::3] > OPEN * largest)
    if len(closed) == 0:
        return slope
    rows = (3 * closed[:, None] + np.arange(3)).ravel()
    W = contacts.W[rows[:, None], rows]
    W[np.diag_indices_from(W)] += PROXIMAL * contacts.w.max()
    w, mu, pushed = contacts.w[closed], contacts.mu[closed], contacts.W_ca[rows]
    J, b = piece_rows(u[closed], r.reshape(-1, 3)[closed], w, mu, W, pushed, STILL * largest)
    budget.spent += 1
    try:
        slope[rows] = np.linalg.solve(J, b)
    except np.linalg.LinAlgError:
        slope[rows] = np.linalg.lstsq(J, b, rcond=None)[0]
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
