"""`tauten check --no-compare`: bodies that are walls one element thick."""

from __future__ import annotations

import pytest

from tauten.model.load import mesh_files, robot_path
from tauten.model.mesh import read_unchecked_mesh
from tauten.model.schema import RobotConfig, model_tables, read_toml, validated
from tauten.service.check import Finding
from tauten.service.check.mesh_findings import thin_layers


def found_of(robot: str, element: str) -> list[Finding]:
    """What is found about a shipped robot whose mesh has these elements."""
    path = robot_path(robot)
    config = validated(RobotConfig, model_tables(read_toml(path)), path).with_element(element)  # type: ignore[arg-type]
    meshes = [read_unchecked_mesh(file) for file in mesh_files(config, path) if file is not None]
    return list(thin_layers(config, meshes))


@pytest.mark.parametrize(
    ("robot", "element", "count"),
    [
        ("pneumatic_finger", "smoothed", 1),
        ("pneumatic_finger", "quadratic", 0),
        ("trunk", "smoothed", 0),
        ("finger", "linear", 0),
    ],
)
def test_walls_one_element_thick_are_doubtful(robot: str, element: str, count: int) -> None:
    """A mesh of one layer was fine in every line where it was not compared with better ones."""
    found = found_of(robot, element)
    assert [one.level for one in found] == count * ["doubtful"]
    assert all("two elements over the thickness" in one.advice for one in found)
