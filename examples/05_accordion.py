"""The accordion: three tensions and a pressure are found for a place of its top.

python examples/05_accordion.py
"""

from __future__ import annotations

import numpy as np

from tauten.controller import Controller
from tauten.model import Simulator, load_robot

EFFORTS = [2.0, 0.5, 0.0, 10e3]  # N of the cables, Pa of the air


def main() -> None:
    """Take the place that some efforts lead to; the controller finds efforts for it."""
    full = Simulator(load_robot("accordion"))
    assert full.settle(effort=EFFORTS).converged
    goal = full.effector
    controller = Controller.of("accordion")
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
