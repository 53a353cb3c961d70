"""Targets on straight lines between messages, followed with a delay.

A stream of targets is slower than the loop, or its messages arrive unevenly: the latest target is then a
stairway. A course keeps the messages with the times when they were made, and the goal is where the straight
line between two of them is at the present less the delay. Rotations turn evenly about one axis (Shoemake,
"Animating rotation with quaternion curves", SIGGRAPH 1985).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from tauten.model import EffectorLayout
from tauten.model.numerics import Array

MOST = 4096  # messages of an effector that are kept


class TargetCourse:
    """The latest targets of each effector, and where the lines between them are at a time.

    Attributes:
        delay: with which the targets are followed [s].
    """

    def __init__(self, layout: EffectorLayout, delay: float, timeout: float) -> None:
        """Start without targets.

        Args:
            layout: kinds of the effectors.
            delay: with which the targets are followed [s].
            timeout: time between two targets from which on there is no line between them [s].
        """
        self.delay = delay
        self._layout = layout
        self._timeout = timeout
        self._knots: list[deque[tuple[float, Array]]] = [deque(maxlen=MOST) for _ in layout.names]

    def add(self, effector: int, made: float, values: Sequence[float]) -> None:
        """Add a target; it replaces those of its effector that were not made before it.

        Args:
            effector: its number.
            made: monotonic time when it was made [s].
            values: (v,) goal values of this effector.
        """
        knots = self._knots[effector]
        while knots and knots[-1][0] >= made:
            knots.pop()
        if knots and made - knots[-1][0] > self._timeout:
            knots.clear()  # a new stream: nothing was followed in between
        knots.append((made, np.array(values)))

    def at(self, now: float, default: Array, used: Sequence[bool]) -> Array:
        """Goal values (n_v,) at a time less the delay.

        Before the first target they are the first, and after the last one the last.

        Args:
            now: monotonic time [s]; earlier targets than those needed then are forgotten.
            default: (n_v,) of the effectors that are not used.
            used: of each effector, whether its targets are.
        """
        time, layout = now - self.delay, self._layout
        start, end, share = default.copy(), default.copy(), np.zeros(layout.n_rows)
        for effector, counts in enumerate(used):
            if not counts:
                continue
            knots, part = self._knots[effector], layout.values_of(effector)
            while len(knots) > 1 and knots[1][0] <= time:
                knots.popleft()
            (before, start[part]), (after, end[part]) = knots[0], knots[min(1, len(knots) - 1)]
            if after > before:
                share[layout.rows_of(effector)] = max((time - before) / (after - before), 0.0)
        return layout.moved(start, share * layout.difference(end, start))
