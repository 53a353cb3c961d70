"""Speed of this computer: the time of a control step, and the rate that it permits."""

from __future__ import annotations

import logging
from time import perf_counter

import numpy as np

from tauten.controller import Controller

log = logging.getLogger(__name__)

_STEPS = 25
_SHARE = 0.8  # of the period that a step may take at the rate that is recommended


class RateError(ValueError):
    """A rate that this computer cannot hold; the text names one that it can."""


def step_seconds(controller: Controller, steps: int = _STEPS) -> float:
    """Median time of a control step [s] towards a target beside the robot; ends at rest."""
    away = controller.shifted(0.1 * controller.robot.size / np.sqrt(3.0))
    times = []
    for _ in range(steps):
        begin = perf_counter()
        controller.step(away)
        controller.prepare()
        times.append(perf_counter() - begin)
    controller.reset()
    controller.prepare()
    return float(np.median(times))


def rate_for(seconds: float) -> float:
    """Rate [Hz] at which a step of this time leaves a fifth of the period, to two digits."""
    return float(f"{_SHARE / seconds:.2g}")


def check_rate(rate: float, seconds: float, requested: bool) -> None:
    """Make sure that the rate can be held.

    Args:
        rate: of the loop [Hz].
        seconds: time of a control step.
        requested: whether the rate was given on the command line; the robot file's gives only a warning.

    Raises:
        RateError: a rate given on the command line cannot be held.
    """
    if seconds * rate <= 1.0:
        return
    text = (
        f"{rate:g} Hz cannot be held: a control step takes {1e3 * seconds:.1f} ms here; use --rate "
        f"{rate_for(seconds):g} or less, a smaller basis, or pip install 'tauten[fast]'"
    )
    if requested:
        raise RateError(text)
    log.warning("%s", text)
