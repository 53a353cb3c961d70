"""Networks of beams beside another body, in frames, against the same in the nodes of beams alone."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
from support.robots.bodies import box_mesh
from support.robots.short_arm import short_arm, write_short_arm

from tauten.model import Simulator, load_robot
from tauten.model.beams import BeamBody
from tauten.model.constraints import ConstrainedBody

BLOCK = """
[[bodies]]
name = "block"
mesh = { file = "block.vtu" }
position = [0.5, 0.0, 0.0]
fixed = [{ upper = [1e-6, 1.0, 1.0], lower = [-1e-6, -1.0, -1.0] }]
"""


def test_an_arm_bends_alike_beside_another_body(tmp_path: Path) -> None:
    """Masses of discs, tendons through them, and ribs that touch the next disc."""
    alone = short_arm(tmp_path)
    mesh = box_mesh((0.01, 0.01, 0.01), (1, 1, 1))
    meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]).write(tmp_path / "block.vtu")
    beside = load_robot(write_short_arm(tmp_path, BLOCK))
    assert isinstance(alone.body, BeamBody)
    assert isinstance(beside.body, ConstrainedBody)
    found = []
    for robot in (alone, beside):
        simulator = Simulator(robot, "full")
        assert simulator.settle(effort=np.array([80.0, 0.0, 0.0]), tolerance=1e-9).converged
        found.append((simulator.effector[0], simulator.position, simulator.lam_c.sum()))
    for one, other in zip(*found[:2], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-3, atol=1e-7)
    assert found[0][2] > 1.0  # N, between ribs and discs
