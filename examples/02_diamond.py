"""The diamond: its top goes round a circle, pulled by cables at its four knees.

python examples/02_diamond.py
"""

from __future__ import annotations

import numpy as np

from tauten.controller import Controller
from tauten.model import Simulator, load_robot

RADIUS, HEIGHT = 0.006, 0.071  # m


def main() -> None:
    """Follow the circle, then compare with equilibria of the full model."""
    controller = Controller.of("diamond")
    full = Simulator(load_robot("diamond"))
    apart, missed = [], []
    for step in range(300):  # 6 s: 3 s to the circle, and once round
        angle = np.pi * max(step - 150, 0) / 75
        radius = RADIUS * min(step / 100, 1.0)
        target = np.array([radius * np.cos(angle), radius * np.sin(angle), HEIGHT])
        actuation = controller.step(target)
        assert actuation.status.usable
        if step >= 150 and step % 30 == 29:
            assert full.settle(position=actuation.position).converged
            missed.append(np.linalg.norm(controller.effector[0] - target))
            apart.append(np.linalg.norm(full.effector[0] - target))
    print(
        f"model {1e3 * max(missed):.2f} mm, robot {1e3 * max(apart):.2f} mm from the circle at most"
    )
    assert max(missed) < 0.3e-3
    assert max(apart) < 0.6e-3


if __name__ == "__main__":
    main()
