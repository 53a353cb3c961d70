"""What happens when a reduced model leaves where it was trained: the full one takes over, at its own rate."""

from __future__ import annotations

import logging
from dataclasses import dataclass

from tauten.controller import Controller
from tauten.model import load_robot
from tauten.reduction.state import ReducedRobot
from tauten.service.node.loop import ControlLoop
from tauten.service.node.model_watch import ModelWatch
from tauten.service.setup import Setup, warm_up

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class FallBack:
    """A reduced model, what watches it, and what replaces it.

    Attributes:
        watch: compares it with the full model.
        reduced: the reduced model.
        full: a warm controller of the full model; None: never replaced.
    """

    watch: ModelWatch
    reduced: ReducedRobot
    full: Controller | None

    @property
    def wanted(self) -> bool:
        """Whether the full model should take over now."""
        return self.full is not None and self.watch.wants_full

    def switch(self, loop: ControlLoop) -> float:
        """Let the full model go on from where the reduced one is; returns its period [s]."""
        full, reduced = self.full, loop.controller
        assert full is not None
        full.take_over(reduced, self.reduced.lifted(reduced.state))
        loop.take_over(full)
        full.prepare()
        self.watch.fallen_back = True
        log.warning(
            "the reduced model has left where it was trained: the full one goes on at %g Hz",
            1.0 / full.robot.h,
        )
        return full.robot.h


def make_fall_back(setup: Setup) -> FallBack | None:
    """What watches a setup's reduced model; None with the full one."""
    robot = setup.robot
    if not isinstance(robot, ReducedRobot):
        return None
    settings, full = robot.config.model, None
    if settings.fall_back:
        slower = load_robot(setup.path, rate=settings.fall_back_rate)
        full = warm_up(Controller(slower, setup.contact))
    return FallBack(ModelWatch(robot, setup.contact), robot, full)
