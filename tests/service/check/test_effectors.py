"""`tauten check` on effectors of every kind."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.processes import ROBOT, write_robot
from support.robots.bodies import box_mesh

from tauten.model import Simulator, load_robot
from tauten.model.numerics import Array
from tauten.service.check import CheckSettings, MeshErrorEstimate, check_robot
from tauten.service.process import StopFlag

EFFECTORS = """\
[[effectors]]
name = "tool"
kind = "frame"
region = { lower = [0.099, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
point = [0.15, 0.01, 0.01]

[[effectors]]
name = "span"
kind = "distance"
point = [0.1, 0.01, 0.018]
other = [0.05, 0.01, 0.018]
"""


def test_a_frame_may_have_its_origin_outside_and_distances_their_points(tmp_path: Path) -> None:
    robot = write_robot(tmp_path, ROBOT.split("[[effectors]]", maxsplit=1)[0] + EFFECTORS)
    settings = CheckSettings(str(robot), shares=())
    checked = check_robot(settings, StopFlag(), lambda _share, _what: None)
    found = {finding.subject: finding for finding in checked.findings}
    assert not checked.refused
    assert found["cables and effectors"].level == "fine"
    assert "all 6 points" in found["cables and effectors"].found
    assert found["region effectors.0.region"].found.startswith("4 nodes")


END = "region = { lower = [0.06, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }"


def uneven(folder: Path, effector: str) -> Path:
    """The beam with another effector, on a mesh that is finer towards its end."""
    file = write_robot(folder, ROBOT.split("[[effectors]]", maxsplit=1)[0] + effector)
    mesh = box_mesh((0.1, 0.02, 0.02), (8, 1, 1))
    x = mesh.nodes * 1.0
    x[:, 0] = 0.1 * np.sqrt(x[:, 0] / 0.1)
    meshio.Mesh(x, {"tetra": np.asarray(mesh.tets)}).write(folder / "beam.vtu")
    return file


def mesh_error(file: Path, share: float) -> MeshErrorEstimate:
    """The error of the mesh against quadratic elements, with the cables at a share of their pull."""
    settings = CheckSettings(str(file), shares=(share,), refinements=0)
    found = check_robot(settings, StopFlag(), lambda _share, _what: None).estimate
    assert found is not None
    return found


def test_a_mean_that_lies_elsewhere_on_a_finer_mesh_is_no_error(tmp_path: Path) -> None:
    """Pulled by 0.02 mm the beam moves by no more than some hundredths of a millimetre on any mesh."""
    file = uneven(tmp_path, f'[[effectors]]\nname = "end"\nkind = "centre"\n{END}\n')
    error = mesh_error(file, 0.001).variants[0]
    assert error.variant.element == "linear"
    assert error.tip is not None
    assert 0.0 < error.tip < 2e-5


def test_the_error_of_a_frame_includes_its_rotation(tmp_path: Path) -> None:
    """A radian counts as the size of the robot, as in decisions."""
    file = uneven(tmp_path, f'[[effectors]]\nname = "end"\nkind = "frame"\n{END}\n')
    error = mesh_error(file, 0.25).variants[0].errors[0]  # with the lower cable pulled

    def bent(element: str) -> tuple[Array, Rotation]:
        text = file.read_text(encoding="utf-8")
        other = tmp_path / f"{element}.toml"
        wanted = f'mesh = {{ file = "beam.vtu", element = "{element}" }}'
        other.write_text(text.replace('mesh = { file = "beam.vtu" }', wanted), encoding="utf-8")
        simulator = Simulator(load_robot(other), contact="none")
        rest = simulator.effector_values
        simulator.settle(position=np.array([0.25 * 0.02, 0.0]), tolerance=1e-8)
        values = simulator.effector_values
        return values[:3] - rest[:3], Rotation.from_quat(values[[4, 5, 6, 3]])

    (moved, turn), (reference, exact) = bent("linear"), bent("quadratic")
    angle = float((turn.inv() * exact).magnitude())
    size = float(np.linalg.norm([0.1, 0.02, 0.02]))
    assert size * angle > 2.0 * np.linalg.norm(moved - reference)
    assert error.tip == pytest.approx(size * angle, rel=0.02)
