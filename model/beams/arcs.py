"""How the nodes of a tree of beams move in a step: along arcs.

A node that moves along a straight line while its beam turns by Δθ stretches the beam by the share Δθ²/2,
which its axial stiffness and damping resist. A step is therefore taken in the natural strains: with their
changes B δ, equation (B2), where δ are displacements and turns of the nodes, the configuration is rebuilt
from the fixed nodes outwards,

    q ⊕ δ = x(ε(q) + B(q) δ)                                                      (B6)

To first order in δ it is the straight one. Its inverse is h v = J(q₀) (ε(q₁) − ε(q₀)), J = B⁻¹, and forces
g that do work on δ at the start are the forces J(q₁)⁻ᵀ J(q₀)ᵀ g at the end.
"""

from __future__ import annotations

import numpy as np

from tauten.model.beams.elements import (
    BeamArrays,
    offset_forces,
    offset_slopes,
    stretch_functions,
    stretch_moment,
    stretched,
    turn_functions,
)
from tauten.model.beams.motion import follow, place_end, strain_forces
from tauten.model.beams.tree import element_frame, natural_strains, strain_rates
from tauten.model.numerics import Array, add, cross, dot, kernel, rotate, scale, subtract


@kernel
def moved_along_arcs(x: Array, Q: Array, step: Array, beams: BeamArrays) -> tuple[Array, Array]:
    """Positions (n_nodes, 3) [m] and rotations (n_nodes, 4) of all nodes after a step, (B6).

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        step: (n_nodes, 6) displacements [m] and turns of the nodes, those of fixed nodes zero.
        beams: the elements, each after the one that leads to it.
    """
    strains = natural_strains(x, Q, beams) + strain_rates(x, Q, step, beams)
    end, turned = x.copy(), Q.copy()
    for k in range(beams.ends.shape[0]):
        place_end(strains, beams, k, end, turned)
    return end, turned


@kernel
def step_along_arcs(x: Array, Q: Array, end: Array, turned: Array, beams: BeamArrays) -> Array:
    """The displacements and turns (n_nodes, 6) of a step that ends at given positions and rotations.

    Args:
        x: (n_nodes, 3) positions [m].
        Q: (n_nodes, 4) rotations, unit quaternions.
        end: (n_nodes, 3) positions at the end [m].
        turned: (n_nodes, 4) rotations at the end.
        beams: the elements, each after the one that leads to it.
    """
    strains = natural_strains(x, Q, beams)
    change = natural_strains(end, turned, beams) - strains
    step = np.zeros((6 * x.shape[0], 1))
    follow(strains, change.reshape(-1, 1), beams, x.copy(), Q.copy(), step)
    return step.reshape(-1, 6)


@kernel
def forces_at_end(
    x: Array, Q: Array, end: Array, turned: Array, load: Array, beams: BeamArrays
) -> Array:
    """Forces and moments (n_nodes, 6) at the end of a step that do the work of given ones at its start.

    Args:
        x: (n_nodes, 3) positions at the start [m].
        Q: (n_nodes, 4) rotations at the start, unit quaternions.
        end: (n_nodes, 3) positions at the end [m].
        turned: (n_nodes, 4) rotations at the end.
        load: (n_nodes, 6) forces [N] and moments [N m] at the start.
        beams: the elements, each after the one that leads to it.
    """
    forces = strain_forces(x, Q, load.copy(), beams)
    found = np.zeros_like(load)
    for k in range(beams.ends.shape[0]):
        a, b, s = beams.ends[k, 0], beams.ends[k, 1], 6 * k
        frame, phi, u = element_frame(end, turned, beams, k)
        theta = dot(phi, phi) ** 0.5
        gamma, eta, d_gamma, d_eta, _, _ = stretch_functions(theta)
        tau, _ = turn_functions(theta)
        slopes = offset_slopes(beams, k, stretched(u, phi, gamma, eta))
        P = offset_forces((forces[s], forces[s + 1], forces[s + 2]), slopes)
        bent = (forces[s + 3], forces[s + 4], forces[s + 5])
        N = stretched(P, phi, gamma, eta)
        M = stretched(add(bent, stretch_moment(u, phi, P, eta, d_gamma, d_eta)), phi, gamma, eta)
        t = cross(N, u)
        c = add(scale(0.5 * tau, cross(phi, t)), M)
        position = rotate(frame, N)
        on_a, on_b = rotate(frame, subtract(scale(0.5, t), c)), rotate(frame, add(scale(0.5, t), c))
        for i in range(3):
            found[a, i] -= position[i]
            found[b, i] += position[i]
            found[a, 3 + i] += on_a[i]
            found[b, 3 + i] += on_b[i]
    return found
