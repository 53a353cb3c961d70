"""Beams against the benchmarks of the literature."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.beam_frames import Frame, chain

from tauten.model.beams import Material, bar, tube
from tauten.model.numerics import Array

Z = np.array([0.0, 0.0, 1.0])


def tip_load(frame: Frame, force: Array | None = None, moment: Array | None = None) -> Array:
    load = np.zeros(frame.pattern.n)
    if force is not None:
        load[-6:-3] = force
    if moment is not None:
        load[-3:] = moment
    return load


# Tip positions under forces of 300 and 600: Simo and Vu-Quoc, Computer Methods in Applied Mechanics and
# Engineering 58, 1986; Cardona and Géradin, Int. J. Numerical Methods in Engineering 26, 1988; Crisfield,
# Computer Methods in Applied Mechanics and Engineering 81, 1990.
BEND = {
    300.0: ((22.33, 58.84, 40.08), (22.14, 58.64, 40.35), (22.16, 58.53, 40.53)),
    600.0: ((15.79, 47.23, 53.37), (15.55, 47.04, 53.50), (15.61, 46.84, 53.71)),
}


@pytest.mark.parametrize("load", [300.0, 600.0])
def test_bathe_and_bolourchi_bend(load: float) -> None:
    """A 45° bend of radius 100 under a force across its plane.

    Problem: Bathe and Bolourchi, Int. J. Numerical Methods in Engineering 14, 1979.
    """
    angle = np.linspace(0.0, np.pi / 4, 9)
    nodes = 100.0 * np.stack([1.0 - np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    frame = Frame(chain(nodes, Z, bar(1.0, 1.0), Material(1e7, 0.0, 1.0)))
    assert frame.x[-1] == pytest.approx([29.29, 70.71, 0.0], abs=5e-3)
    for force in np.linspace(0.0, load, 7)[1:]:
        moved = frame.solve(tip_load(frame, force * Z))
    for tip in BEND[load]:
        assert np.linalg.norm(frame.x[-1] - tip) < 0.01 * np.linalg.norm(tip)
    # the end of Newton's method squares the error
    assert moved[-2] < 1e-4
    assert moved[-1] < 10.0 * moved[-2] ** 2 + 1e-11


@pytest.mark.parametrize("count", [2, 8])
@pytest.mark.parametrize("strain", [0.01, 0.1])
def test_a_soft_rod_under_tension_is_as_long_and_as_stiff_as_theory_says(
    count: int, strain: float
) -> None:
    """Tension N stretches by N / E A and stiffens it against a force F aside, also where 12 E I / L² ≪ N.

    E I θ'' = (1 + ε) (N θ − F), θ(0) = 0, θ'(l) = 0.
    """
    L, material, profile = 0.2, Material(1e6, 0.3, 1.0), tube(4e-3)
    N, EI = strain * 1e6 * profile.area, 1e6 * profile.bending[0]
    frame = Frame(
        chain(np.outer(np.linspace(0.0, L, count + 1), [1.0, 0, 0]), Z, profile, material)
    )
    frame.solve(tip_load(frame, np.array([N, 0.0, 1e-3 * N])))
    k = np.sqrt((1.0 + strain) * N / EI)
    aside = 1e-3 * (1.0 + strain) * (L - np.tanh(k * L) / k)
    assert frame.x[-1, 0] / L - 1.0 == pytest.approx(strain, rel=1e-4)
    assert frame.x[-1, 2] == pytest.approx(aside, rel=0.1 if count == 2 else 0.01)


@pytest.mark.parametrize("count", [3, 16])
def test_end_moment_rolls_a_beam_into_a_circle(count: int) -> None:
    """Every element is an exact arc, also one of 120°."""
    L, material, profile = 2.0, Material(1e7, 0.3, 1.0), bar(0.05, 0.05)
    EI = material.young_modulus * profile.bending[1]
    nodes = np.outer(np.linspace(0.0, L, count + 1), [1.0, 0.0, 0.0])
    frame = Frame(chain(nodes, Z, profile, material))
    for share in np.linspace(0.0, 1.0, 21)[1:]:
        frame.solve(tip_load(frame, moment=share * 2.0 * np.pi * EI / L * Z))
    assert np.abs(frame.x[-1]).max() < 1e-9 * L, "the end is back at the start"
    centre = np.array([0.0, L / (2.0 * np.pi), 0.0])
    radius = np.linalg.norm(frame.x[:-1] - centre, axis=1)
    assert radius == pytest.approx(L / (2.0 * np.pi), rel=1e-8)
    _, _, energy = frame.forces()
    assert energy == pytest.approx(0.5 * EI / L * (2.0 * np.pi) ** 2, rel=1e-9)


@pytest.mark.parametrize("count", [1, 4])
def test_cantilever_bends_as_in_euler_bernoulli_theory(count: int) -> None:
    """Small deflection of a thin beam, whatever the number of elements and the direction."""
    L, material, profile = 1.0, Material(2e11, 0.3, 7800.0), tube(0.004, 0.003)
    EI = material.young_modulus * profile.bending[0]
    turn = Rotation.from_rotvec([0.3, 1.1, -0.4])
    nodes = turn.apply(np.outer(np.linspace(0.0, L, count + 1), [1.0, 0.0, 0.0]))
    frame = Frame(chain(nodes, turn.apply(Z), profile, material))
    F = 1e-4
    frame.solve(tip_load(frame, F * turn.apply(Z)))
    moved = turn.inv().apply(frame.x[-1] - nodes[-1])
    assert moved[2] == pytest.approx(F * L**3 / (3.0 * EI), rel=1e-4)
    assert abs(moved[1]) < 1e-12


def test_elastica_of_a_cantilever() -> None:
    """Large deflection under a dead tip force, P L² / E I = 5 and 10.

    Tip positions from elliptic integrals: Mattiasson, Int. J. Numerical Methods in Engineering 17,
    1981, table II.
    """
    L, material, profile = 1.0, Material(1e9, 0.0, 1.0), bar(0.01, 0.01)
    EI = material.young_modulus * profile.bending[0]
    frame = Frame(chain(np.outer(np.linspace(0.0, L, 21), [1.0, 0.0, 0.0]), Z, profile, material))
    for load, (u, w) in ((5.0, (0.38763, 0.71379)), (10.0, (0.55500, 0.81061))):
        for share in np.linspace(load / 2.0, load, 5):
            frame.solve(tip_load(frame, share * EI / L**2 * Z), tolerance=1e-9)
        assert L - frame.x[-1, 0] == pytest.approx(u * L, rel=2e-3)
        assert frame.x[-1, 2] == pytest.approx(w * L, rel=2e-3)


def test_torsion_turns_the_end() -> None:
    L, material, profile = 0.5, Material(2e11, 0.3, 7800.0), tube(0.02)
    frame = Frame(chain(np.outer([0.0, 0.2, L], [1.0, 0, 0]), Z, profile, material))
    torque = 30.0
    frame.solve(tip_load(frame, moment=np.array([torque, 0.0, 0.0])))
    angle = 2.0 * np.arctan2(frame.Q[-1, 1], frame.Q[-1, 0])
    assert angle == pytest.approx(torque * L / (material.shear_modulus * profile.torsion), rel=1e-9)


def test_work_of_loads_is_the_energy_stored() -> None:
    """Slow loading in space: ∫ F dx over the path is the elastic energy, whatever the path."""
    material = Material(1e7, 0.2, 1.0)
    nodes = np.array([[0.0, 0, 0], [0.5, 0, 0], [0.9, 0.3, 0], [1.0, 0.8, 0.2]])
    stored = []
    for order in ((0, 1), (1, 0)):
        frame = Frame(chain(nodes, Z, bar(0.05, 0.08), material))
        work, before, load = 0.0, frame.x[-1].copy(), np.zeros(3)
        for direction in order:
            for _ in range(40):
                step = np.array([[0.0, 0.5, 4.0], [-6.0, 0.0, 1.0]])[direction] / 40.0
                frame.solve(tip_load(frame, load + step))
                work += float((load + 0.5 * step) @ (frame.x[-1] - before))
                before, load = frame.x[-1].copy(), load + step
        _, _, energy = frame.forces()
        assert work == pytest.approx(energy, rel=2e-3)
        stored.append(energy)
    assert stored[0] == pytest.approx(stored[1], rel=1e-9)
