"""Closed loop: the measured effectors correct the target by integral action on top of the model.

With target x_t, measurement x_m, the model's effector x_e and the goal x_g = x_t + c asked of the model, the
correction c obeys

    dc/dt = g ((x_t − x_m) + (x_e − x_g)) = g (x_e − x_m − c).

The first term integrates the tracking error. The second is the anti-windup by back-calculation (Åström
and Hägglund, PID Controllers, 1995, section 3.5): what the model cannot reach, because a limit or a
contact is in the way, is taken back. So c never grows beyond the distance of model and robot,
whatever the target, and in equilibrium x_m = x_t where the model reaches its goal.
"""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import Array

# A model that is farther off than this part of the robot's size is wrong, not inexact.
LARGEST = 0.25


class Feedback:
    """Integral correction of targets.

    Attributes:
        correction: (p, 3) added to the targets [m].
    """

    def __init__(self, effectors: int, gain: float, largest: float) -> None:
        """Start without correction.

        Args:
            effectors: their number p.
            gain: g [1/s].
            largest: no correction is longer [m].
        """
        self._gain = gain
        self._largest = largest
        self.correction: Array = np.zeros((effectors, 3))

    def observe(self, model: Array, measured: Array, seconds: float) -> None:
        """Take a measurement in.

        Args:
            model: (p, 3) the model's effectors [m].
            measured: (p, 3) where they really are [m].
            seconds: since the measurement before.
        """
        if not np.isfinite(model).all():
            return
        # exact for constant x_e - x_m, so that no gain and no pause makes it overshoot
        share = 1.0 - np.exp(-self._gain * seconds)
        correction = self.correction + share * (model - measured - self.correction)  # (p, 3)
        length = np.linalg.norm(correction, axis=1, keepdims=True)  # (p, 1)
        self.correction = correction * np.minimum(1.0, self._largest / np.maximum(length, 1e-300))

    def reset(self) -> None:
        """No correction."""
        self.correction = np.zeros_like(self.correction)
