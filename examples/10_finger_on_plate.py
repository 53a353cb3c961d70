"""A finger pressed on a plate: what sticks, what slides, and what friction leaves when it comes back.

python examples/10_finger_on_plate.py

The cable is pulled and let go by a part. With friction the tip does not come back the way it went.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tauten.model import Simulator

FILE = Path(__file__).with_name("finger_on_plate.toml")


def main() -> None:
    """Pull, pull farther, and let go: two equilibria under the same cable."""
    simulator, tips = Simulator.of(FILE, contact="full"), []
    for pulled in (0.01, 0.015, 0.02, 0.015):
        assert simulator.settle(position=[pulled]).converged
        contacts = simulator.contacts
        plate = contacts.contacts.pair == len(simulator.robot.pairs) - 1
        normal = float(contacts.normal_force[plate].sum())
        across = contacts.force[plate] - contacts.normal_force[plate, None] * [-1.0, 0.0, 0.0]
        friction = float(np.linalg.norm(across.sum(axis=0)))
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
