"""How much the energy of the actuators counts beside the distance of the effectors from their target."""

from __future__ import annotations

import numpy as np

from tauten.model import Clusters, Layout, Limits, row_layout
from tauten.model.numerics import Array, Bools, Ints, cholesky, kernel, solve_rows


def energy_scale(W: Array, layout: Layout, pushing: Bools, groups: Ints | None = None) -> float:
    """Scale of the actuation energy in (T1), s = |W̃_ea|² / tr W_aa [m/N].

    It makes ε unitless: ε is the share of the objective's curvature that the elastic energy of the
    actuators has. Where their efforts are in several units, s is the mean of those of the units, by their
    number of actuators. W̃ is the compliance with the pushing contacts kept closed: where a robot rests on
    itself its actuators move the effectors a hundred times less, and an energy weighted by the free motion
    would outweigh the target. Without any coupling s = tr W_aa / n_a. The scale is part of the prepared step:
    it is the same for every target, start of the solver and round of enrichment.

    Args:
        W: (m, m) compliance of effectors, actuators and contacts [m/N].
        layout: of its rows.
        pushing: (m − n_e − n_a,) contacts that pushed in the last step of the model.
        groups: (n_a,) number of the unit of each effort; None: there is one unit.
    """
    alike = np.zeros(layout.n_a, dtype=np.int64) if groups is None else groups
    return _energy_scale(W, layout.n_e, layout.n_a, pushing, alike)


def energy_scales(
    W: Array, layout: Layout, pushing: Bools, groups: Ints, clusters: Clusters
) -> Array:
    """`energy_scale` of every cluster: (c,) [m/N].

    Args:
        W: (m, m) compliance of effectors, actuators and contacts [m/N].
        layout: of its rows.
        pushing: (m − n_e − n_a,) contacts that pushed in the last step of the model.
        groups: (n_a,) number of the unit of each effort.
        clusters: of the robot.
    """
    if len(clusters.each) == 1:
        return np.array([_energy_scale(W, layout.n_e, layout.n_a, pushing, groups)])
    found, contacts = [], np.arange(layout.contacts.start, len(W))
    for one in clusters.each:
        rows = np.concatenate([one.rows, contacts])
        within = row_layout(len(one.effectors), len(one.actuators))
        alike = groups[one.actuators]
        moved = len(one.actuators) > 0
        found.append(energy_scale(W[rows[:, None], rows], within, pushing, alike) if moved else 0.0)
    return np.array(found)


def scale_of_all(scales: Array, clusters: Clusters, scale: Array) -> float:
    """The scale that the energies of all clusters get: the largest of those whose effectors count [m/N].

    Args:
        scales: of every cluster (c,) [m/N].
        clusters: of the robot.
        scale: (n_e,) weights times units of the effector rows.
    """
    counted = np.zeros(len(scales), np.bool_)
    counted[clusters.of_effectors[scale > 0.0]] = True
    found: list[float] = scales[counted & (scales > 0.0)].tolist()
    return max(found) if found else float(scales.max())


def relative_weights(scales: Array, scale: float) -> Array:
    """What effectors of clusters of scales (c,) count where the energies of all have another one: (c,)."""
    weights, known = np.ones_like(scales), scales > 0.0
    weights[known] = np.sqrt(scale / scales[known])
    return weights


def capped_scales(
    scales: Array, W_aa: Array, limits: Limits, size: float, clusters: Clusters
) -> Array:
    """Scales of the energy (c,) of which none is more than the largest efforts allow [m/N].

    With a scale at this limit the largest effort weighs as much as a way of the size of the largest part. An
    object that nothing touches is moved by no actuator: the scale that follows from what the actuators move
    would let the weight of a palm outweigh the target.

    Args:
        scales: of every cluster (c,) [m/N].
        W_aa: (n_a, n_a) compliance between actuators.
        limits: of the efforts.
        size: of the robot's largest part [m].
        clusters: of the robot.
    """
    found = scales.copy()
    for number, one in enumerate(clusters.each):
        a = one.actuators
        largest = _largest_energy(W_aa[a[:, None], a], limits.effort_min[a], limits.effort_max[a])
        if largest > 0.0:
            found[number] = min(found[number], size**2 / largest)
    return found


@kernel
def _largest_energy(W_aa: Array, effort_min: Array, effort_max: Array) -> float:
    """Largest finite product of a compliance and the square of its largest effort [N m]."""
    largest = 0.0
    for a in range(len(W_aa)):
        energy = W_aa[a, a] * max(abs(effort_min[a]), abs(effort_max[a])) ** 2
        if energy < np.inf:
            largest = max(largest, energy)
    return largest


@kernel
def _energy_scale(W: Array, n_e: int, n_a: int, pushing: Bools, groups: Ints) -> float:
    total = 0.0
    for a in range(n_e, n_e + n_a):
        total += W[a, a]
    if not total > 0.0:
        return 0.0
    W_ea = closed_compliance(W, n_e, n_a, pushing)
    scale = 0.0
    for group in range(np.max(groups) + 1):
        trace, coupling, count = 0.0, 0.0, 0
        for a in range(n_a):
            if groups[a] == group:
                trace += W[n_e + a, n_e + a]
                count += 1
        for e in range(n_e):
            for a in range(n_a):
                if groups[a] == group:
                    coupling += W_ea[e, a] * W_ea[e, a]
        if trace > 0.0:
            scale += count / n_a * (coupling / trace)
    return scale if scale > 0.0 else total / n_a


@kernel
def closed_compliance(W: Array, n_e: int, n_a: int, pushing: Bools) -> Array:
    """W̃_ea = W_ea − W_ec W_cc⁻¹ W_ca over the pushing contacts: (n_e, n_a) [m/N].

    Redundant contacts make W_cc singular, and so does one that no force opens; a regularisation leaves the
    product as it is.

    Args:
        W: (m, m) compliance of effectors, cables and contacts, in this order [m/N].
        n_e: effector rows.
        n_a: actuators.
        pushing: (m − n_e − n_a,) contacts that are kept closed.
    """
    W_ea = W[:n_e, n_e : n_e + n_a].copy()
    c = n_e + n_a + np.flatnonzero(pushing)
    m = len(c)
    W_cc, L, rows = np.empty((m, m)), np.zeros((m, m)), np.empty((n_a, m))
    for i in range(m):
        for j in range(m):
            W_cc[i, j] = W[c[i], c[j]]
        for j in range(n_a):
            rows[j, i] = W[n_e + j, c[i]]
    trace = np.trace(W_cc)
    for i in range(m):
        W_cc[i, i] += 1e-9 * trace / m if trace > 0.0 else 1.0
    if not cholesky(W_cc, L):  # not finite
        return W_ea
    forces = solve_rows(L, rows)  # (n_a, m)
    for i in range(n_e):
        for j in range(n_a):
            for k in range(m):
                W_ea[i, j] -= W[i, c[k]] * forces[j, k]
    return W_ea
