"""Natural frequencies against beam theory and against one mass on a spring."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from support.robots.bodies import beam_config, box_mesh
from support.robots.joined import ARM, LINK, SIDE, linked

from tauten.model.beams import Material, Profile, bar, make_beams, tube
from tauten.model.body import natural_frequencies
from tauten.model.load import build_robot
from tauten.model.load.beam_bodies import with_masses
from tauten.model.mesh import quadratic_mesh
from tauten.model.numerics import FactorisationError
from tauten.model.schema import Disc, RobotConfig, SolidMaterialSettings

LENGTH, WIDTH, HEIGHT = 0.2, 0.01, 0.014
E, DENSITY = 1e6, 1000.0


def test_a_slender_cantilever_vibrates_as_beam_theory_says() -> None:
    """Bending about both axes, f = (β L)² / (2 π L²) √(E I / (ρ A)); ν = 0, slender: L / height = 14."""
    size = (LENGTH, WIDTH, HEIGHT)
    config = RobotConfig.model_validate(
        beam_config(
            size,
            mesh={"file": "beam.vtu", "element": "quadratic"},
            material={"young_modulus": E, "poisson_ratio": 0.0, "density": DENSITY},
        )
    )
    robot = build_robot(config, quadratic_mesh(box_mesh(size, (20, 1, 1))), "beam")
    found = natural_frequencies(robot.body, robot.rest(), 4)
    theory = [
        root**2 / (2.0 * np.pi * LENGTH**2) * np.sqrt(E * side**2 / (12.0 * DENSITY))
        for root in (1.87510407, 4.69409113)
        for side in (WIDTH, HEIGHT)
    ]
    np.testing.assert_allclose(found, sorted(theory), rtol=0.04)
    assert found[0] == pytest.approx(theory[0], rel=0.015)


@pytest.mark.parametrize("elements", [4, 16])
@pytest.mark.parametrize(
    ("profile", "moments", "torsion"),
    [
        (tube(4e-3), (np.pi / 64 * 4e-3**4,) * 2, np.pi / 32 * 4e-3**4),
        (tube(12e-3, 8e-3), (np.pi / 64 * (12e-3**4 - 8e-3**4),) * 2, np.pi / 32 * (12e-3**4 - 8e-3**4)),
        (bar(12e-3, 4e-3), (12e-3 * 4e-3**3 / 12, 4e-3 * 12e-3**3 / 12), bar(12e-3, 4e-3).torsion),
    ],
)  # fmt: skip
def test_a_soft_rod_twists_as_beam_theory_says(
    profile: Profile, moments: tuple[float, float], torsion: float, elements: int
) -> None:
    """f = √(G J / ρ I_p) / 4 L with one end held, whatever the elements: all nodes turn about the rod."""
    nodes = np.outer(np.linspace(0.0, LENGTH, elements + 1), [1.0, 0.0, 0.0])
    ends = np.stack([np.arange(elements), np.arange(1, elements + 1)], axis=1)
    material = Material(E, 0.3, DENSITY)
    up = np.tile([0.0, 0.0, 1.0], (elements, 1))
    beams = make_beams(nodes, ends, up, [profile] * elements, material)
    K = np.zeros((elements + 1, elements + 1))  # of turns about the rod
    for (a, b), stiffness in zip(ends, beams.D[:, 3], strict=True):
        K[np.ix_([a, b], [a, b])] += stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
    squares = eigh(K[1:, 1:], np.diag(beams.inertia[1:]), eigvals_only=True)
    G = E / (2.0 * (1.0 + 0.3))
    expected = np.sqrt(G * torsion / (DENSITY * sum(moments))) / (4.0 * LENGTH)
    assert np.sqrt(squares[0]) / (2.0 * np.pi) == pytest.approx(expected, rel=0.01)


def test_a_disc_on_a_thin_rod_is_a_torsion_pendulum() -> None:
    """f = √(G J / L I) / 2 π with I = m r² / 2 of the disc."""
    radius, thickness, steel, density = 0.01, 0.002, 60e9, 6450.0
    nodes, up = np.array([[0.0, 0.0, 0.0], [LENGTH, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    beams = make_beams(nodes, np.array([[0, 1]]), up, [tube(1e-3)], Material(steel, 0.3, density))
    disc = Disc(name="disc", node=1, radius=radius, thickness=thickness, axis=(1.0, 0.0, 0.0))
    material = SolidMaterialSettings(young_modulus=steel, poisson_ratio=0.3, density=density)
    inertia = with_masses(beams, [disc], material).inertia[1]
    of_disc = 0.5 * density * np.pi * radius**4 * thickness
    stiffness = steel / 2.6 * np.pi / 32.0 * 1e-3**4 / LENGTH  # N m
    assert beams.D[0, 3] == pytest.approx(stiffness)
    assert np.sqrt(beams.D[0, 3] / inertia) == pytest.approx(np.sqrt(stiffness / of_disc), rel=0.01)
    total = 3.0 * (
        density * np.pi * (radius**2 * thickness + 0.25e-6 * LENGTH)
    )  # three times as heavy
    weighed = material.model_copy(update={"total_mass": total})
    heavy = with_masses(beams, [disc], weighed)
    assert heavy.mass.sum() == pytest.approx(total)
    assert heavy.inertia[1] == pytest.approx(3.0 * inertia)


def test_frequencies_are_those_of_the_dense_problem() -> None:
    size = (0.06, 0.02, 0.02)
    config = RobotConfig.model_validate(beam_config(size))
    robot = build_robot(config, box_mesh(size, (3, 1, 1)), "beam")
    _, values = robot.forces(robot.rest(), exact=True)
    K = np.zeros((robot.n, robot.n))
    columns = np.repeat(np.arange(robot.n), np.diff(robot.body.pattern.indptr))
    K[robot.body.pattern.indices, columns] = values
    scaled = K / np.sqrt(np.outer(robot.body.tetrahedra.mass, robot.body.tetrahedra.mass))
    expected = np.sqrt(np.linalg.eigvalsh(scaled)[:5]) / (2.0 * np.pi)
    np.testing.assert_allclose(
        natural_frequencies(robot.body, robot.rest(), 5), expected, rtol=1e-8
    )


def test_a_link_between_two_springs_vibrates_about_its_hinge() -> None:
    """f = √(2 k r² / I) / 2 π, with the inertia of the box about the middle of its end; without them none."""
    stiffness = 2000.0
    robot = linked(1, {"spring": {"stiffness": stiffness, "pretension": 1.0}}, integration={})
    inertia = DENSITY * LINK * SIDE**2 * (LINK**2 / 3.0 + SIDE**2 / 12.0)
    rest = robot.rest()
    found = natural_frequencies(robot.body, rest, 1, robot.spring_rows(rest))
    assert found[0] == pytest.approx(
        np.sqrt(2.0 * stiffness * ARM**2 / inertia) / (2.0 * np.pi), rel=1e-6
    )
    with pytest.raises(FactorisationError):
        natural_frequencies(robot.body, rest, 1)
    slack = linked(1, {"min_pull": -0.01, "spring": {"stiffness": stiffness}}, integration={})
    assert slack.spring_rows(rest).shape == (0, robot.n)


def test_a_long_strip_of_fine_cells_is_held() -> None:
    """f is as 1 / L² of a strip of spring steel; it was not held where that was 1e7 below a cell's own f."""
    found = []
    for length in (0.5, 1.0):
        size = (length, 1e-3, 1e-4)
        steel = {"young_modulus": 2e11, "poisson_ratio": 0.3, "density": 7800.0}
        config = RobotConfig.model_validate(beam_config(size, material=steel))
        robot = build_robot(config, box_mesh(size, (round(1000 * length), 2, 1)), "strip")
        found.append(natural_frequencies(robot.body, robot.rest(), 1)[0])
    assert found[0] == pytest.approx(4.0 * found[1], rel=0.02)
