"""`tauten bench steps`: forward and inverse steps, also of robots whose effectors are not points."""

from pathlib import Path

import pytest
from support.processes import ROBOT, write_robot

from tauten.service.bench import bench_steps
from tauten.service.tables import steps_page

POSE = """
[[effectors]]
name = "pose"
kind = "frame"
region = { kind = "half_space", point = [0.09, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
"""


@pytest.mark.long
def test_steps_of_a_robot_with_a_frame_and_a_point_are_timed(tmp_path: Path) -> None:
    """Only points were targets of the inverse steps: of the tripod the benchmark ended with an exception."""
    shares: list[float] = []
    robot = write_robot(tmp_path, ROBOT[: ROBOT.rindex("[[effectors]]")] + POSE)
    result = bench_steps(str(robot), 1, "superlu", 5, lambda share, what="": shares.append(share))
    assert sum(shares) == 1.0
    coarse, fine = (mesh.sizes.elements for mesh in result.meshes)
    assert fine == 8 * coarse
    (table,) = steps_page(result).tables
    assert [row[2] for row in table.rows] == ["superlu", "superlu"]
    for mesh in result.meshes:
        assert mesh.forward_ms.p50 is not None
        assert mesh.inverse_ms.p50 is not None
