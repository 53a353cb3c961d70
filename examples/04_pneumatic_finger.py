"""The pneumatic finger: a pressure is found for a place of its tip.

python examples/04_pneumatic_finger.py
"""

from __future__ import annotations

import numpy as np

from tauten.controller import Controller
from tauten.model import Simulator, load_robot

EFFORTS = [12e3]  # Pa


def main() -> None:
    """Take the place that a pressure leads to; the controller finds the pressure."""
    full = Simulator(load_robot("pneumatic_finger"))
    assert full.settle(effort=EFFORTS).converged
    goal = full.effector
    controller = Controller.of("pneumatic_finger")
    for _ in range(150):
        actuation = controller.step(goal)
        assert actuation.status.usable
    missed = 1e3 * np.linalg.norm(controller.effector - goal, axis=1).max()  # mm
    assert full.settle(effort=actuation.effort).converged
    apart = 1e3 * np.linalg.norm(full.effector - goal, axis=1).max()  # mm
    print(
        f"efforts {np.round(actuation.effort, 2)}: model {missed:.2f} mm, robot {apart:.2f} mm off"
    )
    assert missed < 0.5
    assert apart < 1.5


if __name__ == "__main__":
    main()
