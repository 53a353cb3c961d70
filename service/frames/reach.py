"""The reach of an effector, computed by a process of its own while one looks at the robot."""

from __future__ import annotations

import multiprocessing
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess
from multiprocessing.queues import Queue

import numpy as np

from tauten.controller import Order
from tauten.model import Simulator, one_blas_thread
from tauten.model.numerics import Array
from tauten.reduction.campaign import interrupts_blocked
from tauten.service.plant import reach_plan, reached
from tauten.service.process import drained


@dataclass(slots=True)
class ReachSet:
    """Positions that an effector was found at.

    Attributes:
        points: (m, 3) [m].
        is_curve: whether they are along a curve, in their order.
        wanted: how many commands are tried; 0: not known yet.
        complete: whether all have been.
        failed: whether the search broke off.
    """

    points: Array = field(default_factory=lambda: np.zeros((0, 3)))
    is_curve: bool = False
    wanted: int = 0
    complete: bool = False
    failed: bool = False


class ReachSearch:
    """Computes the reach of effectors of a model, one after another, when asked for it."""

    def __init__(self, robot: str, order: Order | None = None, basis: str | None = None) -> None:
        """Start nothing; arguments as of `Simulator.of`."""
        self._model = robot, order, basis
        self._found: dict[int, ReachSet] = {}
        self._process: BaseProcess | None = None
        self._queue: Queue[object] | None = None
        self._effector = 0

    def of(self, effector: int) -> ReachSet:
        """What is known of an effector's reach; it is computed where nobody has asked for it yet."""
        if effector not in self._found and self._process is None:
            self._start(effector)
        self._take()
        return self._found.get(effector, ReachSet())

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.terminate()
            self._process.join()
            self._process = None

    def _start(self, effector: int) -> None:
        context = multiprocessing.get_context("spawn")
        self._effector, self._found[effector] = effector, ReachSet()
        self._queue = context.Queue()
        self._process = context.Process(
            target=_search, args=(*self._model, effector, self._queue), daemon=True
        )
        with interrupts_blocked():  # the viewer ends the process
            self._process.start()

    def _take(self) -> None:
        """Take what the process has found."""
        process, queue = self._process, self._queue
        if process is None or queue is None:
            return
        ended, found = not process.is_alive(), self._found[self._effector]
        points = []
        for item in drained(queue):
            if isinstance(item, np.ndarray):
                points.append(item)
            elif isinstance(item, tuple):
                found.wanted, found.is_curve = item
        if points:
            found.points = np.concatenate([found.points, np.array(points)])
        if ended:
            found.complete = True
            process.join()
            found.failed = process.exitcode != 0
            self._process = None


def _search(
    robot: str, order: Order | None, basis: str | None, effector: int, queue: Queue[object]
) -> None:
    with one_blas_thread():
        simulator = Simulator.of(robot, order, basis)
        plan = reach_plan(simulator, effector)
        queue.put((len(plan.shares), plan.is_curve))
        for position in reached(simulator, plan):
            queue.put(position)
