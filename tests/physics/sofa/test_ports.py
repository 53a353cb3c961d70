"""The robot files of `docs/coming_from/sofa` on the curves of SOFA, without any change to what they build.

Equilibria of PneuNets and accordion, of which SOFA gives no curve, are in `test_chambers`.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from sofa_ports import CURVES, Curve, computed, draw
from sofa_robots import FILES, SOURCES, port
from support.robots.sofa_robots import robots_folder
from support.sofa.elements import assemble_with, large_frames

from tauten.model import load_robot
from tauten.model.mesh import MeshError, checked, read_mesh
from tauten.model.tetra import solid as solid_module

DIGITS, FORCE_DIGITS = 3e-5, 1e-6  # mm, and of the largest effort
slow = pytest.mark.slow


@pytest.fixture(scope="module")
def data(reference: Path) -> Path:
    return robots_folder(reference, "diamond_large_settled.csv")


@pytest.mark.parametrize("name", ["trunk", "gripper_finger", "tripod", "finger"])
@pytest.mark.parametrize("every", [6, pytest.param(1, marks=slow)])
def test_it_has_the_digits_of_sofa(data: Path, name: str, every: int) -> None:
    """Tips, and tensions, torques or changes of volume."""
    curve = computed(data, name, every if name != "finger" else 2 * every)
    assert len(curve.x) > 1
    assert np.ptp(curve.sofa, axis=0).max() > 5.0  # mm
    assert curve.tip_error < DIGITS
    assert curve.effort_error < FORCE_DIGITS


@pytest.mark.long
@pytest.mark.parametrize("every", [12, pytest.param(1, marks=slow)])
def test_the_diamond_has_them_with_the_elements_of_sofa(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, every: int
) -> None:
    """Under the tensions of SOFA's inverse; its mesh file has single precision."""
    robot = port(data, tmp_path, "diamond")
    monkeypatch.setattr(
        solid_module, "assemble_corotational", assemble_with(large_frames, robot.body.mesh)
    )
    curve = CURVES["diamond"](data, robot, every)
    assert curve.tip_error < DIGITS
    assert np.abs(curve.effort - curve.sofa_effort).max() < DIGITS  # mm, lengths of cables


@pytest.mark.long
def test_the_figure_is_drawn(tmp_path: Path) -> None:
    x = np.linspace(0.0, 1.0, 4)
    line = np.stack([x, x**2, -x], axis=1)
    curves = [Curve(name, "mm", x, line + 1e-6, line, line, line) for name in CURVES]
    draw(curves, tmp_path / "ports.png")
    assert (tmp_path / "ports.png").stat().st_size > 10_000


@pytest.mark.long
def test_a_mesh_that_overlaps_loads_where_nothing_needs_its_boundary(
    data: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The accordion, with a warning; `test_chambers` has its equilibria. With a contact it is refused."""
    port(data, tmp_path, "accordion")
    assert "384 pairs of tetrahedra" in caplog.text
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
