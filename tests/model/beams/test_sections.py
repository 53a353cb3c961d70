"""Cross-sections by their stiffnesses: the same as by their shape, and the deflection of beam theory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.beam_robots import build, under_force

from tauten.model import Robot
from tauten.model.beams import BeamBody, tube
from tauten.model.load import make_robot
from tauten.model.schema import Changes, RobotFileError

E, NU, RHO = 2e9, 0.3, 1200.0
G = E / (2.0 * (1.0 + NU))
LENGTH, COUNT = 0.3, 6
NODES = np.stack([np.linspace(0.0, LENGTH, COUNT + 1), *np.zeros((2, COUNT + 1))], axis=1)
BEAMS = [{"ends": [i, i + 1], "profile": "spine", "up": [0.0, 0.0, 1.0]} for i in range(COUNT)]
SHAPE = tube(0.01, 0.006)
STIFFNESSES = {
    "kind": "section", "name": "spine", "diameter": 0.01,
    "axial": E * SHAPE.area,
    "bending": [E * value for value in SHAPE.bending],
    "torsion": G * SHAPE.torsion,
    "shear": [G * value for value in SHAPE.shear_area],
    "mass": RHO * SHAPE.area,
}  # fmt: skip


def cantilever(folder: Path, profile: dict[str, object], **changes: object) -> Robot[BeamBody]:
    return build(folder, NODES, BEAMS, [profile], (E, NU, RHO), [0], COUNT, **changes)


def test_stiffnesses_of_a_tube_make_the_tube(tmp_path: Path) -> None:
    by_shape = cantilever(
        tmp_path, {"kind": "tube", "name": "spine", "outer": 0.01, "inner": 0.006}
    )
    by_numbers = cantilever(tmp_path, STIFFNESSES)
    assert pytest.approx(by_shape.body.beams.D) == by_numbers.body.beams.D
    assert by_numbers.body.mass == pytest.approx(by_shape.body.mass)


def test_a_measured_bending_stiffness_gives_the_deflection(tmp_path: Path) -> None:
    """δ = P L³ / 3 E I, whatever the material of the file; without shear, stiff in all else."""
    EI, load = 0.02, 1e-4
    profile = {
        **STIFFNESSES, "axial": 1e6, "torsion": 10.0, "bending": [EI, 5.0 * EI], "shear": None,
    }  # fmt: skip
    robot = cantilever(tmp_path, profile)
    for axis, stiffness in ((2, EI), (1, 5.0 * EI)):
        force = np.zeros(3)
        force[axis] = load
        _, (tip,) = under_force(robot, [force], 1e-12)
        assert tip[axis] == pytest.approx(load * LENGTH**3 / (3.0 * stiffness), rel=1e-6)


def test_measured_stiffnesses_against_shear_give_the_deflection(tmp_path: Path) -> None:
    """δ = P L³ / 3 E I + P L / κ G A along each axis."""
    EI, GA, load = (0.02, 0.1), {1: 3.0, 2: 0.5}, 1e-4
    profile = {**STIFFNESSES, "axial": 1e6, "torsion": 10.0, "bending": EI, "shear": [GA[1], GA[2]]}
    robot = cantilever(tmp_path, profile)
    for axis, bending in ((2, EI[0]), (1, EI[1])):
        _, (tip,) = under_force(robot, [load * np.eye(3)[axis]], 1e-12)
        expected = load * (LENGTH**3 / (3.0 * bending) + LENGTH / GA[axis])
        assert tip[axis] == pytest.approx(expected, rel=1e-5)


def robot_file(material: dict[str, float]) -> dict[str, object]:
    """A robot file beside the beams of `cantilever`."""
    return {
        "name": "benchmark", "bodies": [{"name": "frame", "beam": {"file": "beams.json"}}],
        "profiles": [STIFFNESSES], "material": material,
        "fixed": [{"lower": [-1e-6] * 3, "upper": [1e-6] * 3}],
        "cables": [{
            "name": "cable", "points": [NODES[0].tolist(), NODES[-1].tolist()],
            "max_tension": 1.0, "max_pull": 1.0, "max_rate": 1.0,
        }],
        "effectors": [{"name": "tip", "point": NODES[-1].tolist()}],
    }  # fmt: skip


def test_the_scale_of_stiffness_applies_to_them(tmp_path: Path) -> None:
    robot = cantilever(tmp_path, STIFFNESSES)
    file = robot_file({"young_modulus": E, "poisson_ratio": NU, "density": RHO})
    stiffer = make_robot(file, tmp_path / "robot.toml", Changes(young_scale=3.0))
    assert isinstance(stiffer.body, BeamBody)
    assert pytest.approx(3.0 * robot.body.beams.D) == stiffer.body.beams.D


def test_a_stiffness_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match=r"profiles.0.section.axial: .* found 0.0"):
        cantilever(tmp_path, {**STIFFNESSES, "axial": 0.0})


def test_beams_weigh_what_the_file_says(tmp_path: Path) -> None:
    """The held end bears half of an element."""
    cantilever(tmp_path, STIFFNESSES)
    file = robot_file({"young_modulus": E, "poisson_ratio": NU, "total_mass": 0.05})
    robot = make_robot(file, tmp_path / "robot.toml", Changes())
    assert robot.body.moving_mass == pytest.approx(0.05 * (1.0 - 0.5 / COUNT))
