"""The trunk: its tip goes round a circle. The reduced model decides, the full model shows where that leads.

python examples/01_trunk.py
"""

from __future__ import annotations

import numpy as np

from tauten.controller import Controller
from tauten.model import Simulator, load_robot

RADIUS, DEPTH = 0.030, -0.152  # m


def main() -> None:
    """Follow the circle, then compare with equilibria of the full model."""
    controller = Controller.of("trunk")
    full = Simulator(load_robot("trunk"))
    apart, missed = [], []
    for step in range(300):  # 6 s: 3 s to the circle, and once round
        angle = np.pi * max(step - 150, 0) / 75
        radius = RADIUS * min(step / 100, 1.0)
        target = np.array([radius * np.cos(angle), radius * np.sin(angle), DEPTH])
        actuation = controller.step(target)
        assert actuation.status.usable
        if step >= 150 and step % 30 == 29:
            assert full.settle(position=actuation.position).converged
            missed.append(np.linalg.norm(controller.effector[0] - target))
            apart.append(np.linalg.norm(full.effector[0] - target))
    print(
        f"model {1e3 * max(missed):.2f} mm, robot {1e3 * max(apart):.2f} mm from the circle at most"
    )
    assert max(missed) < 0.5e-3
    assert max(apart) < 1.5e-3


if __name__ == "__main__":
    main()
