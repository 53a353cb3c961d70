"""A reduced model compared with the full one in a separate process, and replaced by it where they differ.

The loop only sends a state at intervals and reads the result when there is one; the process uses processor
time that nothing else needs, and ends with the loop. Where the results show that the reduced model has left
the states it was trained with, the full one takes over, at its own rate.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Literal

from tauten.controller import Controller, ModelSettings, warm_controller
from tauten.model import ContactSpace, Robot, load_robot, one_blas_thread
from tauten.reduction.campaign import interrupts_blocked
from tauten.reduction.state import ReducedBody, ReducedParts, TipCheck
from tauten.service.node.loop import ControlLoop
from tauten.service.process import give_lower_priority
from tauten.service.setup import Setup
from tauten.service.wire import Diagnostic, Level

log = logging.getLogger(__name__)

_GLANCE = 0.02  # s between reads of the pipe: each is a system call
_PROCESSOR = 36  # field of /proc/…/stat after the name
_SILENT = 60.0  # s without a result after which health warns
_IN_A_ROW = 3  # results beyond the bound before the full model takes over


class ModelWatch:
    """Compares a reduced model with the full one at intervals: the distance of their tips.

    Attributes:
        error: the last result [m]; None before the first.
        largest: of all results [m].
        exceeded: results in a row that were beyond the bound.
        fallen_back: whether the full model has taken over: nothing is compared any more.
    """

    def __init__(
        self,
        robot: Robot[ReducedBody | ReducedParts],
        contact: Literal["none", "full"] | ContactSpace,
        settings: ModelSettings,
    ) -> None:
        """Start the process, and wait neither for its interpreter nor until it has read the model."""
        self._settings = settings
        self._pipe, far = get_context("spawn").Pipe()
        self._process = get_context("spawn").Process(
            target=compare_models, args=(far,), daemon=True, name="tauten model watch"
        )
        with interrupts_blocked():  # the loop ends the process
            self._process.start()
        far.close()
        assert self._process.pid is not None
        with suppress(OSError):  # it has ended
            give_lower_priority(self._process.pid)
        self._pending = False
        self._next = self._due = self._heard = time.monotonic()
        # pickled here, which takes the interpreter longer than a tick may wait; the pipe takes seconds
        model = ForkingPickler.dumps((robot, contact))
        self._sending = threading.Thread(
            target=_send, args=(self._pipe, model), daemon=True, name="model"
        )
        self._sending.start()
        self.error: float | None = None
        self.largest = 0.0
        self.exceeded = 0
        self.fallen_back = False

    def look(self, controller: Controller) -> None:
        """Read the result if there is one; send a state when it is time. Never blocks, never raises."""
        now = time.monotonic()
        if self.fallen_back or now < self._next:
            return
        self._next = now + _GLANCE
        if self._sending.is_alive():
            return
        try:
            if self._pending and self._pipe.poll():
                self._take(float(self._pipe.recv()))
            if not self._pending and now >= self._due:
                state, poses = controller.state, controller.obstacles.poses
                self._pipe.send((state, controller.effort, controller.position, poses))
                self._pending, self._due = True, now + self._settings.check_period
        except (OSError, EOFError):  # the process is gone
            self.error, self._pending, self._next = None, False, float("inf")

    def _take(self, error: float) -> None:
        self._pending, self.error, self._heard = False, error, time.monotonic()
        self.largest = max(self.largest, error)
        self.exceeded = self.exceeded + 1 if error > self._settings.max_tip_error else 0

    def diagnostic(self) -> Diagnostic:
        """As health."""
        allowed = 1e3 * self._settings.max_tip_error
        values = {"allowed_mm": f"{allowed:.3g}", "largest_mm": f"{1e3 * self.largest:.3g}"}
        silence, alive = time.monotonic() - self._heard, self._process.is_alive()
        level = Level.WARN
        if self.fallen_back:
            text = f"the full model has taken over at {self._settings.fall_back_rate:g} Hz"
        elif silence > _SILENT + self._settings.check_period and alive:
            text = f"reduced, not compared for {silence:.0f} s: the machine is too busy for the full model"
        elif self.error is None and not alive:
            text = "reduced, the process that compares it has ended"
        elif self.error is None:
            level, text = Level.OK, "reduced, not compared yet"
        else:
            values["error_mm"] = f"{1e3 * self.error:.3g}"
            level, text = Level.OK, "reduced, within the states it was trained with"
            if self.exceeded:
                level = Level.WARN
                text = (
                    f"reduced, outside of the states it was trained with: the full model has the tip "
                    f"{1e3 * self.error:.3g} mm elsewhere, allowed are {allowed:.3g} mm"
                )
        return Diagnostic("model", level, text, values)

    def close(self) -> None:
        """End the process, also on a machine that leaves an idle-class process no time."""
        assert self._process.pid is not None
        leave_idle_class(self._process.pid)
        if self._sending.is_alive():  # the pipe ends with its reader
            self._process.kill()
            self._sending.join()
        self._pipe.close()
        self._process.join(1.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


@dataclass(frozen=True, slots=True, eq=False)
class FallBack:
    """A reduced model, its comparison with the full one, and the controller that replaces it.

    Attributes:
        watch: compares it with the full model.
        reduced: the reduced model.
        full: a warm controller of the full model; None: never replaced.
    """

    watch: ModelWatch
    reduced: Robot[ReducedBody | ReducedParts]
    full: Controller | None

    @property
    def wanted(self) -> bool:
        """Whether the full model should take over now."""
        watch = self.watch
        return self.full is not None and not watch.fallen_back and watch.exceeded >= _IN_A_ROW

    @property
    def period(self) -> float:
        """Of the full model's ticks [s]; 0: it never takes over."""
        return 0.0 if self.full is None else self.full.robot.h

    def switch(self, loop: ControlLoop) -> float:
        """Continue with the full model from the state of the reduced one; returns its period [s]."""
        full, reduced = self.full, loop.controller
        assert full is not None
        full.take_over(reduced, self.reduced.body.lifted(reduced.state))
        full.prepare()  # where this fails, the loop has the reduced one for the release
        loop.take_over(full)
        self.watch.fallen_back = True
        log.warning(
            "the reduced model has left the states it was trained with: the full one takes over at %g Hz",
            1.0 / full.robot.h,
        )
        return full.robot.h


def _send(pipe: Connection, content: memoryview) -> None:
    """Send what may take until the reader has started; not at all where it ends before."""
    with suppress(OSError):
        pipe.send_bytes(content)


def make_fall_back(setup: Setup) -> FallBack | None:
    """The comparison of a setup's reduced model; None with the full one."""
    robot = setup.reduced
    if robot is None:
        return None
    settings, full = setup.model, None
    if settings.fall_back:
        slower = load_robot(setup.path, rate=settings.fall_back_rate)
        full = warm_controller(replace(setup, robot=slower, states=(), reduced=None))
    return FallBack(ModelWatch(robot, setup.contact, settings), robot, full)


def compare_models(pipe: Connection) -> None:
    """The separate process: tip errors of the states that arrive, until the pipe is closed."""
    with one_blas_thread(), suppress(EOFError, OSError):
        models = pipe.recv()  # the sender waits
        _give_way()
        check, allowed = TipCheck(*models), os.sched_getaffinity(0)
        while True:
            state = pipe.recv()
            _leave_processor(os.getppid(), allowed)
            pipe.send(check(*state))


def _give_way() -> None:
    """Run only where nothing else is ready to run.

    A processor that runs an idle-class process counts as free: threads that wake up go there, and not to
    the processor of the loop.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    except OSError:  # some sandboxes
        give_lower_priority(0)


def leave_idle_class(process: int) -> None:
    """Give a process the ordinary class again: on a busy machine an idle one cannot even be killed."""
    with suppress(OSError):  # it has ended, or never was of that class
        os.sched_setscheduler(process, os.SCHED_OTHER, os.sched_param(0))


def _leave_processor(process: int, allowed: set[int]) -> None:
    """Run on other allowed processors than the one where another process's main thread ran last.

    On the loop's processor even an idle-class process gets a time slice at times, several ticks long.
    """
    with suppress(OSError):
        status = Path(f"/proc/{process}/stat").read_text()
        seen = int(status.rpartition(")")[2].split()[_PROCESSOR])
        os.sched_setaffinity(0, allowed - {seen} or allowed)
