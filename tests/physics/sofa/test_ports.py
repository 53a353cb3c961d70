"""The robot files of `docs/coming_from/sofa` on the curves of SOFA, without any change to what they build.

Those of tripod, PneuNets and accordion are in `test_tripod` and `test_chambers`.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from support.robots.sofa_ports import FILES, SOURCES, port
from support.robots.sofa_robots import robots_folder
from support.sofa_elements import MM, assemble_with, large_frames

from tauten.model import Simulator, load_robot
from tauten.model.mesh import MeshError, checked, read_mesh
from tauten.model.numerics import Array
from tauten.model.tetra import solid as solid_module

SETTLED = 2e-6  # mm; rows of SOFA that moved more in their last step are no equilibria
DIGITS, FORCE_DIGITS = 3e-5, 5e-3  # mm and mN
slow = pytest.mark.slow


@pytest.fixture(scope="module")
def data(reference: Path) -> Path:
    return robots_folder(reference, "diamond_large_settled.csv")


def read_curve(file: Path) -> Array:
    curve: Array = np.genfromtxt(file, delimiter=",", names=True)
    return curve[curve["last_max_dx"] < SETTLED]


def numbers(row: Array, *names: str) -> Array:
    return np.array([row[name] for name in names])


def tip_of(row: Array, name: str = "tip") -> Array:
    return numbers(row, *(f"{name}_{axis}" for axis in "xyz"))


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=slow)])
def test_trunk(data: Path, tmp_path: Path, every: int) -> None:
    """Three of its cables, of which one is slack at times; SOFA leaves the others out."""
    robot = port(data, tmp_path, "trunk")
    simulator, wound = Simulator(robot, contact="none"), ("L0", "L1", "S1")
    places = [robot.actuators.names.index(name) for name in wound]
    for row in read_curve(data / "trunk_combo_fpolar.csv")[every::every]:
        pull, tension = np.full(robot.n_a, np.nan), np.zeros(robot.n_a)
        pull[places] = MM * numbers(row, *(f"imposed_{name}" for name in wound))
        tension[places] = np.nan
        assert simulator.settle(pull, tension, tolerance=1e-9).converged
        assert np.abs(simulator.effector[0] / MM - tip_of(row)).max() < DIGITS
        expected = numbers(row, *(f"tension_{name}" for name in wound))
        assert np.abs(simulator.tension[places] / MM - expected).max() < FORCE_DIGITS


@pytest.mark.parametrize("every", [12, pytest.param(1, marks=slow)])
def test_gripper_finger(data: Path, tmp_path: Path, every: int) -> None:
    """Tip and change of volume under pressures to 100 kPa."""
    robot = port(data, tmp_path, "gripper_finger")
    simulator = Simulator(robot, contact="none")
    for row in read_curve(data / "gripperfinger_fpolar.csv")[every::every]:
        assert simulator.settle(tension=[1e3 * row["pressure_kPa"]], tolerance=1e-9).converged
        assert np.abs(simulator.effector[0] / MM - tip_of(row)).max() < DIGITS
        assert simulator.pull[0] / MM**3 == pytest.approx(row["volume_growth"], abs=1e-3)


@pytest.mark.parametrize("states", [slice(1, 2), pytest.param(slice(None), marks=slow)])
def test_diamond(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, states: slice
) -> None:
    """Under the tensions of SOFA's inverse, whose 'large' elements are put in."""
    robot = port(data, tmp_path, "diamond")
    patched = assemble_with(large_frames, robot.mesh)
    monkeypatch.setattr(solid_module, "assemble_corotational", patched)
    simulator = Simulator(robot, contact="none")
    for row in read_curve(data / "diamond_large_settled.csv")[states]:
        tension = MM * numbers(row, *(f"tension{i}" for i in range(4)))
        assert simulator.settle(tension=tension, tolerance=1e-9).converged
        assert np.abs(simulator.effector[0] / MM - tip_of(row)).max() < DIGITS
        wound = numbers(row, *(f"L0L_{i}" for i in range(4)))
        assert np.abs(simulator.pull / MM - wound).max() < DIGITS


@pytest.mark.parametrize("every", [10, pytest.param(1, marks=slow)])
def test_finger_on_a_plate(data: Path, tmp_path: Path, every: int) -> None:
    """Contact without friction, held 1 mm off; from 14.5 mm of pull on with two or three nodes."""
    simulator = Simulator(port(data, tmp_path, "finger"), contact="full")
    touched = 0
    for row in read_curve(data / "plate_mu0_fpolar.csv")[::every]:
        assert simulator.settle(pull=[MM * row["imposed"]], tolerance=1e-9).converged
        assert np.abs(simulator.effector[0] / MM - tip_of(row)).max() < DIGITS
        assert abs(simulator.tension[0] / MM - row["tension"]) < FORCE_DIGITS
        push = simulator.lam_c / MM
        assert abs(push.sum() - row["sum_normal"]) < FORCE_DIGITS
        assert (push > 1e-3).sum() == row["active_contacts"]
        touched += row["active_contacts"] > 0
    assert touched > 3


def test_a_mesh_that_overlaps_loads_where_nothing_needs_its_boundary(
    data: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The accordion, with a warning; `test_chambers` has its equilibria. With a contact it is refused."""
    port(data, tmp_path, "accordion")
    assert "384 faces are like this" in caplog.text
    loaded = read_mesh(tmp_path / "Springy.vtk", "mm", overlaps=True)
    with pytest.raises(MeshError, match="are given more than once"):
        checked(loaded.nodes, np.vstack([loaded.tets, loaded.tets[:1]]), "twice", overlaps=True)
    path = tmp_path / "accordion.toml"
    path.write_text(path.read_text() + '[[contacts]]\nagainst = "itself"\n')
    with pytest.raises(MeshError, match="lie on the same side of their common face"):
        load_robot(path)


def test_every_file_has_a_robot_and_says_where_its_mesh_is() -> None:
    files = {path.stem: path.read_text() for path in FILES.glob("*.toml")}
    assert set(files) == set(SOURCES)
    for name, text in files.items():
        assert "github.com/SofaDefrost/" in text
        assert SOURCES[name].mesh in text
        assert tomllib.loads(text)["name"] == name
