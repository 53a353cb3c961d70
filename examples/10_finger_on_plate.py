"""A finger pressed on a plate: what sticks, what slides, and what friction leaves when it comes back.

python examples/10_finger_on_plate.py

The cable is pulled and let go by a part. With friction the tip does not come back the way it went.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from tauten.model import Simulator

FILE = Path(__file__).with_name("finger_on_plate.toml")
PULLED = (0.01, 0.015, 0.02, 0.015)  # m of the cable: pull, pull farther, let go by a part


def press(course: Sequence[float] = PULLED) -> Iterator[Simulator]:
    """The simulator in one equilibrium after another.

    Args:
        course: pulled lengths of the cable [m].
    """
    simulator = Simulator.of(FILE, contact="full")
    for pulled in course:
        assert simulator.settle(position=[pulled]).converged
        yield simulator


def pressed(simulator: Simulator) -> tuple[float, float]:
    """Normal force and friction of the plate on the finger [N]."""
    contacts = simulator.contacts
    plate = contacts.contacts.pair == len(simulator.robot.pairs) - 1
    normal = contacts.normal_force[plate]
    across = contacts.force[plate] - normal[:, None] * [-1.0, 0.0, 0.0]
    return float(normal.sum()), float(np.linalg.norm(across.sum(axis=0)))


def main() -> None:
    """Two equilibria under the same cable."""
    tips = []
    for pulled, simulator in zip(PULLED, press(), strict=True):
        contacts = simulator.contacts
        normal, friction = pressed(simulator)
        print(
            f"{1e3 * pulled:4.0f} mm of cable: {normal:.3f} N on the plate, friction {friction:.3f} N, "
            f"{contacts.margin.max(initial=0.0):.3f} N to slip at most"
        )
        assert friction <= 0.5 * normal + 1e-9
        tips.append(simulator.tip)
    left = np.linalg.norm(tips[3] - tips[1])
    print(f"back at 15 mm the tip is {1e3 * left:.2f} mm from where it was")
    assert 1e-5 < left < 1e-3


if __name__ == "__main__":
    main()
