"""The tripod: three servos give the plate a height and a tilt.

python examples/03_tripod.py
"""

from __future__ import annotations

import numpy as np

from tauten.controller import Controller
from tauten.model import Simulator, load_robot

ANGLES = (0.30, -0.10, 0.10)  # rad, of the servos, from which the target is made


def main() -> None:
    """Ask for the pose that some angles lead to; the controller finds these angles."""
    robot = load_robot("tripod")
    simulator = Simulator(robot)
    assert simulator.settle(position=ANGLES).converged
    goal = robot.effector_values(simulator.state)  # position [m] and quaternion w, x, y, z
    controller = Controller(robot, "none")
    for _ in range(100):
        actuation = controller.step(goal)
        assert actuation.status.usable
    reached = robot.effector_values(controller.state)
    tilt = 2.0 * np.arccos(min(abs(float(reached[3:] @ goal[3:])), 1.0))
    print(f"angles {np.round(actuation.position, 4)} rad, height off by {abs(reached[2] - goal[2]):.1e} m, "
          f"tilt by {tilt:.1e} rad")  # fmt: skip
    assert np.abs(actuation.position - ANGLES).max() < 0.01
    assert abs(reached[2] - goal[2]) < 1e-4
    assert tilt < 0.01


if __name__ == "__main__":
    main()
