"""The inverse problem (T1): which efforts bring the effectors to their target within one step."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from tauten.controller.friction import CutPlan, no_slots
from tauten.controller.qpcc import Qpcc
from tauten.model import (
    Actuators,
    Clusters,
    CondensedStep,
    EffectorLayout,
    Grasp,
    Layout,
    Limits,
    PredictedStep,
    cable_actuators,
    row_layout,
)
from tauten.model.numerics import Array, Bools, Ints, kernel


@dataclass(frozen=True, slots=True)
class Aim:
    """What the effector rows of a plan are to do.

    Attributes:
        target: (n_e,) values.
        scale: (n_e,) weights times units; 0: the row is left free.
        equations: (n_e,) whether a row is to meet its target exactly.
        gamma: γ, weight on the change of the rows in each cluster (c,).
        grasp: limits of contact forces, and which of them count; None: there are none.
        cut: where the search of the last plan with friction was cut; None: it was not.
        pushed: slots of the unit columns that pushed in that plan.
        looking: whether contact is looked for, with what nothing touches yet.
    """

    target: Array
    scale: Array
    equations: Bools
    gamma: Array
    grasp: Grasp | None
    cut: CutPlan | None = None
    pushed: Ints = field(default_factory=no_slots)
    looking: bool = False

    def among(self, clusters: Clusters, chosen: Bools) -> Aim:
        """The same with the weights, equations and limits of contact forces of some clusters only.

        Args:
            clusters: of the robot.
            chosen: (c,) which of them.
        """
        if all(chosen.tolist()):
            return self
        rows, pairs = chosen[clusters.of_effectors], clusters.of_pairs
        scale, equations = np.where(rows, self.scale, 0.0), self.equations & rows
        own = (pairs >= 0) & chosen[pairs]
        grasp = None if self.grasp is None else self.grasp.among(own)
        return replace(self, scale=scale, equations=equations, grasp=grasp)


def inverse_problem(
    W: Array,
    delta_free: Array,
    target: Array,
    position_prev: Array,
    limits: Limits,
    h: float,
    weight: float,
    actuators: Actuators | None = None,
) -> Qpcc:
    """Build (T1); pure, nothing is solved.

    min  1/2 |δ_e|² + 1/2 ε s λ_a' W_aa λ_a,   δ_e = δ_e,free - target + W_ea λ_a + W_ec β
    s.t. limits on λ_a,   position and rate limits on δ_a,   0 <= δ_c ⟂ β >= 0

    Args:
        W: (m, m) compliance of effectors, actuators and contacts, in this order [m/N].
        delta_free: (m,) effector and actuator positions and gaps after a step without forces [m].
        target: (n_e,) positions [m].
        position_prev: (n_a,) actuator positions commanded last [m].
        limits: of the actuators.
        h: time step [s].
        weight: of the elastic energy, ε s [m/N]; `energy_scale` is s.
        actuators: what their limits are called; default: cables with numbers.
    """
    layout = row_layout(len(target), len(position_prev))
    actuators = numbered(layout.n_a) if actuators is None else actuators
    n, n_a = len(W) - len(target), len(position_prev)
    Q, c, (g_lo, g_hi) = np.zeros((n, n)), np.zeros(n), np.empty((2, n_a))
    by_rate = np.empty((n_a, 2), np.bool_)
    allowed = (limits.position_min, limits.position_max, h * limits.rate)
    constant = _objective(W, delta_free, target, n_a, weight, Q, c)
    _travel(delta_free[layout.actuators], position_prev, allowed, (g_lo, g_hi), by_rate)
    return Qpcc(
        Q=Q,
        c=c,
        lb=limits.effort_min,
        ub=limits.effort_max,
        G=W[layout.actuators, layout.acting],
        g_lo=g_lo,
        g_hi=g_hi,
        M=W[layout.contacts, layout.acting],
        m=delta_free[layout.contacts],
        constant=constant,
        bound_names=actuators.effort_names,
        row_names=position_names(actuators.position_names, by_rate.tobytes()),
    )


def without_rounding(problem: Qpcc, least: float) -> Qpcc:
    """The inverse problem in which contacts touch whose gaps without forces are rounding.

    A robot that lies on something, without weight and forces, has no other gaps, and a solver nothing to
    compare them with: it took them for gaps that no forces closed. The columns of a basis of which only
    entries next to zero are in range have gaps next to zero, too, wherever their contacts are: those count
    relative to the root of their compliance.

    Args:
        problem: from `inverse_problem`.
        least: gap, below which that of a single contact is rounding [m].
    """
    gaps = np.abs(problem.m)
    if not any((gaps < least).tolist()):
        return problem
    compliance = problem.M[:, len(problem.lb) :].diagonal()  # (k,)
    largest = np.maximum.reduce(compliance)
    with np.errstate(all="ignore"):  # of a model that has diverged, or nothing that moves
        rounding = gaps < least * np.sqrt(compliance / largest)
    if not any(rounding.tolist()):
        return problem
    return replace(problem, m=np.where(rounding, 0.0, problem.m))


def held_back(problem: Qpcc, W: Array, layout: Layout, weight: Array, held: Array) -> Qpcc:
    """The inverse problem with the part of its damping that acts on the efforts.

    With 1/2 ε s γ (λ_a − λ_held)' W_aa (λ_a − λ_held) added and all divided by 1 + γ, the energy is as before
    but for the term −γ / (1 + γ) ε s λ_held' W_aa λ_a.

    Args:
        problem: from `inverse_problem`.
        W: (m, m) as it was given there.
        layout: of its rows.
        weight: (n_a,) γ / (1 + γ) ε s of each actuator [m/N].
        held: (n_a,) efforts of a hold [N].
    """
    c = problem.c.copy()
    c[: layout.n_a] -= weight * (W[layout.actuators, layout.actuators] @ held)
    return replace(problem, c=c)


def including_hold(problem: Qpcc, held: Array) -> Qpcc:
    """The inverse problem with position limits that include what a hold leads to.

    A slack cable's path may be any shorter than its winch allows, and where the path becomes shorter faster
    than the winch turns there is no decision that keeps it longer. A supply that keeps its pressure does not
    bound its volume.

    Args:
        problem: from `inverse_problem`.
        held: (n_a,) positions in a hold, less those of a step without forces [m].
    """
    if all(((problem.g_lo <= held) & (held <= problem.g_hi)).tolist()):
        return problem
    return replace(
        problem, g_lo=np.minimum(problem.g_lo, held), g_hi=np.maximum(problem.g_hi, held)
    )


def with_efforts_limited(
    problem: Qpcc, step: CondensedStep, free: Ints, at: Array, limits: Limits, actuators: Actuators
) -> Qpcc:
    """The inverse problem with the limits of efforts where a stiffness is added along their actuators.

    The unknown is λ + ρ (δ_a − δ_a,0) there, see `tauten.model.CondensedStep.efforts`: a limit of λ is one of
    a row.

    Args:
        problem: from `inverse_problem`.
        step: of all actuators.
        free: (n_a,) numbers of those of the problem.
        at: (n_a,) their positions δ_a where the unknowns are zero [m].
        limits: of these.
        actuators: what the limits are called.
    """
    if step.rho is None:
        return problem
    rho = step.rho[free]
    (stiff,) = rho.nonzero()
    shift = rho * (at - step.rows.actuators.delta[free])
    rows = -rho[stiff, None] * problem.G[stiff]  # (s, n)
    rows[np.arange(len(stiff)), stiff] += 1.0
    names = [*map(actuators.effort_names.__getitem__, stiff.tolist())]
    lb, ub = problem.lb.copy(), problem.ub.copy()
    lb[stiff], ub[stiff] = -np.inf, np.inf
    least, most = (limits.effort_min + shift)[stiff], (limits.effort_max + shift)[stiff]
    return problem.limited(rows, least, most, zip(names, names, strict=True), (lb, ub))


def with_force_limits(
    problem: Qpcc, grasp: Grasp | None, step: CondensedStep, held: PredictedStep
) -> Qpcc:
    """The inverse problem with limits of contact forces.

    Args:
        problem: from `inverse_problem`, without or with locked actuators.
        grasp: limits of contact forces, and which of them count; None: there are none.
        step: whose contacts are the last rows of the problem.
        held: where it leads when the actuators hold.
    """
    rows = None if grasp is None else grasp.rows(step, held)
    if rows is None:
        return problem
    coefficients = np.zeros((len(rows.least), len(problem.c)))
    coefficients[:, len(problem.c) - rows.coefficients.shape[1] :] = rows.coefficients
    return problem.limited(coefficients, rows.least, rows.largest, rows.names)


def weighted_rows(W: Array, delta_free: Array, scale: Array) -> tuple[Array, Array]:
    """Compliance and values of a step with the effector rows in metres, times their weights.

    For points and centres with weight one these are the arguments themselves.

    Args:
        W: (m, m) compliance of effectors, cables and contacts, in this order.
        delta_free: (m,) row values after a step without forces.
        scale: (n_e,) weights times units.
    """
    if all((scale == 1.0).tolist()):
        return W, delta_free
    factor = np.ones(len(W))
    factor[: len(scale)] = scale
    return factor[:, None] * W * factor, factor * delta_free


def exact_problem(
    problem: Qpcc,
    W: Array,
    delta_free: Array,
    target: Array,
    rows: Ints,
    layout: EffectorLayout,
    tolerance: float,
) -> Qpcc:
    """The inverse problem with rows of exact effectors as limits, −tolerance <= δ_e <= tolerance.

    Args:
        problem: from `inverse_problem`.
        W: (m, m) as it was given there.
        delta_free: (m,) as it was given there.
        target: (n_e,) that the rows are to meet [m].
        rows: (r,) numbers of these rows.
        layout: of the effectors.
        tolerance: within which a target counts as met [m].
    """
    n_e = layout.n_rows
    wanted = target[rows] - delta_free[rows]
    names = [(name, name) for name in map(layout.row_name, rows.tolist())]
    return problem.limited(W[rows, n_e:], wanted - tolerance, wanted + tolerance, names)


@kernel
def _objective(
    W: Array, delta_free: Array, target: Array, n_a: int, weight: float, Q: Array, c: Array
) -> float:
    """Add (T1) to Q (n, n) and c (n,), n = n_a + k; returns its constant."""
    n_e, n, constant = len(target), len(c), 0.0
    for e in range(n_e):
        error = delta_free[e] - target[e]
        constant += 0.5 * error * error
        for i in range(n):
            c[i] += W[e, n_e + i] * error
            for j in range(n):
                Q[i, j] += W[e, n_e + i] * W[e, n_e + j]
    Q[:n_a, :n_a] += weight * W[n_e : n_e + n_a, n_e : n_e + n_a]
    return constant


@kernel
def _travel(
    free: Array, before: Array, allowed: tuple[Array, Array, Array], limits: tuple[Array, Array],
    by_rate: Bools,
) -> None:  # fmt: skip
    """Write limits of δ_a − δ_a,free, each (n_a,) [m], and whether the rate sets them (n_a, 2).

    Args:
        free: (n_a,) positions after a step without forces [m].
        before: (n_a,) those commanded last [m].
        allowed: (n_a,) least and largest positions, and largest change [m].
        limits: (n_a,) outputs, least and largest.
        by_rate: (n_a, 2) output.
    """
    position_min, position_max, step = allowed
    g_lo, g_hi = limits
    for a in range(len(free)):
        low, high = before[a] - step[a], before[a] + step[a]
        by_rate[a, 0], by_rate[a, 1] = low > position_min[a], high < position_max[a]
        # np.maximum and np.minimum propagate NaN, max and min do not
        g_lo[a] = np.maximum(position_min[a], low) - free[a]
        g_hi[a] = np.minimum(position_max[a], high) - free[a]


@lru_cache(maxsize=64)
def numbered(n_a: int) -> Actuators:
    """Cables that are called by their numbers."""
    return cable_actuators(tuple(str(i) for i in range(n_a)))


@lru_cache(maxsize=64)
def position_names(
    names: tuple[tuple[str, str, str], ...], by_rate: bytes
) -> tuple[tuple[str, str], ...]:
    """Names of the lower and the upper limit of each position: rate or position, whichever is tighter.

    Args:
        names: `Actuators.position_names`.
        by_rate: (n_a, 2) for the lower and the upper limit, whether the rate sets it.
    """
    pairs = zip(names, zip(by_rate[::2], by_rate[1::2], strict=True), strict=True)
    return tuple(
        [
            (rate if low else least, rate if high else largest)
            for (least, largest, rate), (low, high) in pairs
        ]
    )
