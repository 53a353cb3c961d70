"""A reduced model watched by the full one, in a process of its own: is it still where it was trained?

The loop only sends a state now and then and looks whether an answer is back; the process runs where
nothing else wants to, and ends with the loop.
"""

from __future__ import annotations

import os
import time
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Literal

from tauten.controller import Controller
from tauten.model import ContactSpace
from tauten.reduction.state import ReducedRobot, TipCheck
from tauten.service.process import one_blas_thread
from tauten.service.wire import Diagnostic, Level

_NICE = 10  # where the idle class is not permitted
_GLANCE = 0.02  # s between looks for an answer: a look is a system call
_PROCESSOR = 36  # field of /proc/…/stat after the name
_SILENT = 60.0  # s without an answer that health speaks of
_IN_A_ROW = 3  # answers beyond the bound before the full model is called for


class ModelWatch:
    """Asks the full model at intervals how far it would move the tip.

    Attributes:
        error: the last answer [m]; None before the first.
        largest: of all answers [m].
        exceeded: answers in a row that were beyond the bound.
        fallen_back: whether the full model has taken over.
    """

    def __init__(
        self, robot: ReducedRobot, contact: Literal["none", "full"] | ContactSpace
    ) -> None:
        """Start the process.

        Args:
            robot: the reduced model; its robot file says how often to ask and what is allowed.
            contact: what its controller knows of contact.
        """
        self._settings = robot.config.model
        self._pipe, far = get_context("spawn").Pipe()
        self._process = get_context("spawn").Process(
            target=answer, args=(far,), daemon=True, name="tauten model watch"
        )
        self._process.start()
        far.close()
        self._asked = False
        self._next = self._due = self._heard = time.monotonic()
        # by the pipe, not as an argument: sending to a process that dies while it starts must not block
        with suppress(OSError):
            self._pipe.send((robot, contact))
        self.error: float | None = None
        self.largest = 0.0
        self.exceeded = 0
        self.fallen_back = False

    @property
    def wants_full(self) -> bool:
        """Whether the full model should take over now."""
        return self._settings.fall_back and not self.fallen_back and self.exceeded >= _IN_A_ROW

    def look(self, controller: Controller) -> None:
        """Take the answer if it is back; ask again when it is time. Never blocks, never raises."""
        now = time.monotonic()
        if self.fallen_back or now < self._next:
            return
        self._next = now + _GLANCE
        try:
            if self._asked and self._pipe.poll():
                self._take(float(self._pipe.recv()))
            if not self._asked and now >= self._due:
                self._pipe.send((controller.state, controller.tension, controller.pull))
                self._asked, self._due = True, now + self._settings.check_period
        except (OSError, EOFError):  # the process is gone
            self.error, self._asked, self._next = None, False, float("inf")

    def _take(self, error: float) -> None:
        self._asked, self.error, self._heard = False, error, time.monotonic()
        self.largest = max(self.largest, error)
        self.exceeded = self.exceeded + 1 if error > self._settings.max_tip_error else 0

    def diagnostic(self) -> Diagnostic:
        """As health."""
        allowed = 1e3 * self._settings.max_tip_error
        values = {"allowed_mm": f"{allowed:.3g}", "largest_mm": f"{1e3 * self.largest:.3g}"}
        if self.fallen_back:
            rate = f"{self._settings.fall_back_rate:g} Hz"
            return Diagnostic(
                "model", Level.WARN, f"the full model has taken over at {rate}", values
            )
        silence = time.monotonic() - self._heard
        if silence > _SILENT + self._settings.check_period and self._process.is_alive():
            text = f"reduced, not compared for {silence:.0f} s: the machine is too busy for the full model"
            return Diagnostic("model", Level.WARN, text, values)
        if self.error is None:
            alive = self._process.is_alive()
            text = "reduced, not compared yet" if alive else "reduced, nothing compares it any more"
            return Diagnostic("model", Level.OK if alive else Level.WARN, text, values)
        values["error_mm"] = f"{1e3 * self.error:.3g}"
        if self.exceeded:
            text = (
                f"reduced, outside of what it was trained for: the full model has the tip "
                f"{1e3 * self.error:.3g} mm elsewhere, allowed are {allowed:.3g} mm"
            )
            return Diagnostic("model", Level.WARN, text, values)
        return Diagnostic("model", Level.OK, "reduced, where it was trained", values)

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.join(1.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def answer(pipe: Connection) -> None:
    """What the process does: tip errors of the states it is sent, until the pipe is closed."""
    with one_blas_thread(), suppress(EOFError, OSError, KeyboardInterrupt):
        models = pipe.recv()  # who sends them waits
        _give_way()
        check, allowed = TipCheck(*models), os.sched_getaffinity(0)
        while True:
            asked = pipe.recv()
            _leave_processor(os.getppid(), allowed)
            pipe.send(check(*asked))


def _give_way() -> None:
    """Run only where nothing else wants to.

    A processor that runs an idle-class process counts as free: threads that wake up go there, and not to
    the one the loop is on.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    except OSError:  # some sandboxes
        os.nice(_NICE)


def _leave_processor(process: int, allowed: set[int]) -> None:
    """Run on other allowed processors than the one where this process's main thread was seen last.

    Beside the loop even an idle-class process is now and then given a slice, of several ticks' length.
    """
    with suppress(OSError):
        status = Path(f"/proc/{process}/stat").read_text()
        seen = int(status.rpartition(")")[2].split()[_PROCESSOR])
        os.sched_setaffinity(0, allowed - {seen} or allowed)
