"""The payload of training and of comparisons: a share of the weight that does not fold the robot."""

from __future__ import annotations

import numpy as np

from tauten.model import Robot, static_compliance

PAYLOAD = 0.2  # as a share of the weight
FARTHEST = 0.5  # how far it moves an effector of the undeformed robot, of its size, to first order
STANDARD_GRAVITY = 9.81  # m/s², by which payloads are chosen where a robot file has no gravity


def payload(robot: Robot, effectors: int) -> float:
    """`PAYLOAD` of the weight, spread evenly over the first effectors: the force on each of them [N].

    It is smaller where that would move one of them by more than `FARTHEST` of the robot's size, to first
    order: a soft robot whose file has no gravity may not bear its own weight.
    """
    size = float(np.linalg.norm(robot.gravity)) or STANDARD_GRAVITY
    heavy = PAYLOAD * robot.body.moving_mass * size / max(effectors, 1)
    places = robot.effectors.places(robot.body.motion(robot.rest()))
    W = static_compliance(robot, places.dense())  # (3 p, 3 p) [m/N]
    softest = max(
        (np.linalg.eigvalsh(W[i : i + 3, i : i + 3])[-1] for i in range(0, 3 * effectors, 3)),
        default=0.0,
    )
    return min(heavy, FARTHEST * robot.size / softest) if softest > 0.0 else heavy
