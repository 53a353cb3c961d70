"""The picture shows an obstacle that moves where its path leads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import viser
from support.processes import ROBOT, write_robot

from tauten.model import Simulator, skin_of
from tauten.service.describing import describe
from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.plant import free_ports
from tauten.service.setup import load_setup
from tauten.service.view.picture.scene import RobotScene
from tauten.service.wire import Cause, Mode

LIFT = """
[[surfaces]]
name = "below"
box = { lower = [0.08, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
normal = [0.0, 0.0, -1.0]

[[obstacles]]
name = "lift"
shape = "cylinder"
parameters = { start = [0.0, -0.03, 0.0], end = [0.0, 0.03, 0.0], radius = 0.01 }

[[obstacles.path.waypoints]]
time = 0.0
position = [0.09, 0.01, -0.011]

[[obstacles.path.waypoints]]
time = 0.2
position = [0.09, 0.01, -0.007]
rotation = { axis = [0.0, 0.0, 1.0], angle_deg = 90.0 }

[[contacts]]
candidates = "below"
against = "lift"
points = 25
"""


def test_a_lift_is_drawn_where_it_is(tmp_path: Path) -> None:
    setup = load_setup(write_robot(tmp_path, ROBOT + LIFT), basis="full")
    simulator, skin = Simulator(setup.robot, "full"), skin_of(setup.robot)

    def frame() -> ViewFrame:
        state, values = simulator.state, simulator.effector_values
        geometry = skin.geometry(simulator.robot, state, simulator.contacts)
        return ViewFrame(
            0.0, Mode.IDLE, Cause.NO_TARGET, "", geometry, simulator.position, simulator.effort, values,
            values, 0.0, obstacles=simulator.obstacles.by_name,
        )  # fmt: skip

    look = RobotLook(describe(setup), frame().geometry.vertices)
    server = viser.ViserServer(host="127.0.0.1", port=free_ports(), verbose=False)
    try:
        scene = RobotScene(server, look, draggable=False)
        (drawn,) = scene._obstacles
        np.testing.assert_allclose(drawn.position, [0.09, 0.01, -0.011])
        for height, turn in ((-0.009, 45.0), (-0.007, 90.0)):
            for _ in range(5):
                simulator.step(position=[0.0, 0.0])
            scene.draw(frame(), [])
            np.testing.assert_allclose(drawn.position, [0.09, 0.01, height], atol=1e-12)
            half = np.radians(0.5 * turn)
            np.testing.assert_allclose(drawn.wxyz, [np.cos(half), 0.0, 0.0, np.sin(half)])
        assert simulator.contact_forces[:, 2].sum() > 0.0, "the lift carries the tip"
    finally:
        server.stop()
