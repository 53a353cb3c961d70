"""The gripper: three fingers close by different amounts.

python examples/06_gripper.py
"""

from __future__ import annotations

import numpy as np

from tauten.controller import Controller
from tauten.model import Simulator, load_robot

EFFORTS = [1.5, 1.0, 0.5]  # N


def main() -> None:
    """Take the places that some tensions lead to; the controller finds the tensions."""
    full = Simulator(load_robot("gripper"))
    assert full.settle(effort=EFFORTS).converged
    goal = full.effector
    controller = Controller.of("gripper")
    for _ in range(150):
        actuation = controller.step(goal)
        assert actuation.status.usable
    missed = 1e3 * np.linalg.norm(controller.effector - goal, axis=1).max()  # mm
    assert full.settle(effort=actuation.effort).converged
    apart = 1e3 * np.linalg.norm(full.effector - goal, axis=1).max()  # mm
    print(
        f"efforts {np.round(actuation.effort, 2)}: model {missed:.2f} mm, robot {apart:.2f} mm off"
    )
    assert missed < 0.3
    assert apart < 1.0


if __name__ == "__main__":
    main()
