"""The 45° bend of Bathe and Bolourchi as a robot: published tips, order of convergence, load increments.

A cantilever of radius 100 m and unit square cross-section under a force across its plane, E = 10⁷ Pa, ν = 0.
Int. J. Numerical Methods in Engineering 14, 1979.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation
from support.exact_rod import AXIS, Rod, stiffness
from support.robots.beam_robots import build, path_of_beams, rectangle, under_force, with_profile

from tauten.model import Robot
from tauten.model.beams import BeamBody, Material, Profile, bar
from tauten.model.numerics import Array

Z = np.array([0.0, 0.0, 1.0])
MATERIAL = Material(1e7, 0.0, 1.0)
SQUARE = bar(1.0, 1.0)
POLAR = replace(SQUARE, torsion=1.0 / 6.0)  # J = 1/6, twice the second moment of area

# Simo and Vu-Quoc, Computer Methods in Applied Mechanics and Engineering 58, 1986, at 450 N.
SIMO_450 = np.array([18.62, 52.32, 48.39])

# Displacement of the tip at 600 N that Kynema's and OpenFAST BeamDyn's high-order elements agree on, in
# Kynema's test `Static_CurvedCompositeBeamBending`. Its rod is not the circular arc but the parabola
# through three points of it, with E I = G J = 8.333e5 N m².
PARABOLA_600 = np.array([-13.72080060, -23.64597160, 53.57764506])
PARABOLA = np.polyfit([0.0, 38.2683, 70.7107], [0.0, 7.61205, 29.2893], 2)
ROUNDED = replace(SQUARE, torsion=0.16666, bending=(0.08333, 0.08333))


def arc(count: int) -> Array:
    """Nodes on the circle: (count + 1, 3)."""
    angle = np.linspace(0.0, np.pi / 4.0, count + 1)
    return 100.0 * np.stack([1.0 - np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)


def parabola(count: int) -> Array:
    """Nodes on the parabola: (count + 1, 3)."""
    y = np.linspace(0.0, 70.7107, count + 1)
    return np.stack([np.polyval(PARABOLA, y), y, 0.0 * y], axis=1)


def bend(folder: Path, nodes: Array, profile: Profile) -> Robot[BeamBody]:
    """The bend through these nodes."""
    last = len(nodes) - 1
    beams = path_of_beams(nodes, (0.0, 0.0, 1.0), "square")
    square = rectangle("square", 1.0, 1.0)
    robot = build(folder, nodes, beams, [square], (1e7, 0.0, 1.0), [0], last)
    return with_profile(robot, profile, MATERIAL)


def tip(robot: Robot[BeamBody], load: float, increments: int, tolerance: float = 1e-9) -> Array:
    """Position of the tip (3,) [m] under a load [N] in equal increments."""
    forces = [force * Z for force in np.linspace(0.0, load, increments + 1)[1:]]
    _, positions = under_force(robot, forces, tolerance)
    return positions[-1]


def exact_tip(profile: Profile, load: float, guess: Array) -> Array:
    """Position of the tip (3,) [m] of the circular rod."""
    section = stiffness(profile, MATERIAL)
    frame = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turning = np.array([0.0, 0.0, -0.01])
    rod = Rod(25.0 * np.pi, lambda t: 1.0, lambda t: turning, frame, lambda t: section)
    return rod.tip(load * Z, guess)


def simos_tip(profile: Profile, load: float) -> Array:
    """Position of the tip (3,) [m] with eight of the published elements: linear, one point of integration.

    Unknown is the rotation ψ of each element's end against its start; strains are those in its middle.
    """
    chords = np.diff(arc(8), axis=0)
    L = np.linalg.norm(chords[0])
    axes = [np.stack([d / L, np.cross(Z, d / L), Z], axis=1) for d in chords]  # in columns
    C, D = stiffness(profile, MATERIAL)

    def unbalanced(psi: Array, force: Array) -> tuple[Array, Array]:
        R, steps, moments = np.eye(3), [], []
        for A, turn in zip(axes, psi.reshape(-1, 3), strict=True):
            middle = R @ Rotation.from_rotvec(0.5 * (A @ turn)).as_matrix() @ A
            steps.append(L * middle @ (AXIS + (middle.T @ force) / C))
            moments.append(middle @ (D * turn) / L)
            R = R @ Rotation.from_rotvec(A @ turn).as_matrix()
        across = 0.5 * np.cross(np.array(steps), force)  # (8, 3)
        inner = np.array(moments)[1:] - np.array(moments)[:-1] + across[1:] + across[:-1]
        return np.vstack([inner, moments[-1] - across[-1]]).ravel() / D[1], np.sum(steps, axis=0)

    psi = np.zeros(24)
    for share in (0.5, 1.0):
        force = share * load * Z
        psi = root(lambda psi, force=force: unbalanced(psi, force)[0], psi, tol=1e-12).x
    residual, tip = unbalanced(psi, load * Z)
    assert np.abs(residual).max() < 1e-9
    return tip


def test_tip_at_450_is_simos_and_vu_quocs(tmp_path: Path) -> None:
    """Within 0.75 % with the torsion constant of a square, J = 0.141, and within 0.25 % with J = 1/6.

    The published digits are those of their eight elements with J = 1/6; the difference to ours is the error
    of theirs, which is several times ours.
    """
    np.testing.assert_allclose(simos_tip(POLAR, 450.0), SIMO_450, atol=0.006)
    for profile, allowed in ((replace(SQUARE, torsion=0.141), 7.5e-3), (POLAR, 2.5e-3)):
        found = tip(bend(tmp_path, arc(8), profile), 450.0, 3)
        assert np.linalg.norm(found - SIMO_450) < allowed * np.linalg.norm(SIMO_450)
        exact = exact_tip(profile, 450.0, found)
        theirs = np.linalg.norm(simos_tip(profile, 450.0) - exact)
        assert np.linalg.norm(found - exact) < 0.4 * theirs


def test_tip_at_600_converges_at_second_order_to_the_published_digits(tmp_path: Path) -> None:
    moved = [
        tip(bend(tmp_path, nodes, ROUNDED), 600.0, 3) - nodes[-1]
        for nodes in (parabola(8), parabola(16), parabola(32), parabola(64))
    ]
    errors = np.linalg.norm(np.array(moved) - PARABOLA_600, axis=1)
    order = np.log2(errors[:-1] / errors[1:])
    assert order == pytest.approx(2.0, abs=0.03)
    extrapolated = moved[-1] + (moved[-1] - moved[-2]) / 3.0
    np.testing.assert_allclose(extrapolated, PARABOLA_600, atol=1e-5)


def test_circular_bend_converges_to_the_exact_rod(tmp_path: Path) -> None:
    found = [tip(bend(tmp_path, arc(count), POLAR), 600.0, 3) for count in (8, 16, 32)]
    exact = exact_tip(POLAR, 600.0, found[-1])
    errors = np.linalg.norm(np.array(found) - exact, axis=1)
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(2.0, abs=0.03)
    np.testing.assert_allclose(found[-1] + (found[-1] - found[-2]) / 3.0, exact, atol=2e-4)
    # the published digits are those of the parabola
    assert np.linalg.norm(exact - arc(1)[-1] - PARABOLA_600) > 0.1


def test_tip_does_not_depend_on_the_load_increments(tmp_path: Path) -> None:
    robot = bend(tmp_path, arc(8), POLAR)
    reference = tip(robot, 600.0, 8)
    for increments in (3, 10):
        np.testing.assert_allclose(tip(robot, 600.0, increments), reference, atol=1e-7)
