"""A finger that presses on an obstacle with friction: whole inverse steps of its models."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, thread_time
from typing import Literal

import numpy as np

from tauten.controller import Controller

FILE = Path(__file__).parents[2] / "examples" / "finger_on_plate.toml"
STEPS, WARM_UP = 200, 20
PERIOD = 100  # steps, in which the target goes behind the plate and comes back
NEAR, FAR, UP = 0.02, 0.05, -0.01  # m, of the target from the tip at the start


@dataclass(frozen=True, slots=True)
class PressedRun:
    """Inverse steps of one model; medians and 99 % are of all steps after the first ones.

    Attributes:
        model: which.
        n: its unknowns.
        in_range: contact candidates in range, median.
        touching: share of the steps in which a contact pushes.
        thread_ms: of prepare, decide, advance and of all three, median and 99 % of the thread's time [ms].
        clock_ms: of all three, the same on the clock.
        cut: decisions that did not come to an end.
    """

    model: str
    n: int
    in_range: float
    touching: float
    thread_ms: tuple[tuple[float, float], ...]
    clock_ms: tuple[float, float]
    cut: int


def pressed_run(model: Literal["full", "reduced"], steps: int = STEPS) -> PressedRun:
    """Inverse steps towards a target that goes behind the plate and comes back.

    Args:
        model: of the controller.
        steps: how many.
    """
    controller = Controller.of(FILE, model)
    rest, times, clock = controller.tip, [], []
    in_range, touching, cut = list[int](), list[bool](), 0
    for step in range(steps):
        share = np.sin(2.0 * np.pi * step / PERIOD) ** 2
        goal = rest + np.array([NEAR + (FAR - NEAR) * share, 0.0, UP])
        begin, at = perf_counter(), [thread_time()]
        controller.prepare()
        at.append(thread_time())
        found = controller.decide(goal)
        at.append(thread_time())
        controller.advance()
        at.append(thread_time())
        if step >= WARM_UP:
            times.append([*np.diff(at), at[-1] - at[0]])
            clock.append(perf_counter() - begin)
            contacts = controller.contacts
            in_range.append(len(contacts))
            touching.append(bool(contacts.pushing.any()))
            cut += not found.status.ok
    return PressedRun(
        model=model,
        n=controller.robot.n,
        in_range=float(np.median(in_range)),
        touching=float(np.mean(touching)),
        thread_ms=tuple(_middle_and_end(np.array(column)) for column in zip(*times, strict=True)),
        clock_ms=_middle_and_end(np.array(clock)),
        cut=cut,
    )


def _middle_and_end(
    values: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
) -> tuple[float, float]:
    return 1e3 * float(np.median(values)), 1e3 * float(np.percentile(values, 99))
