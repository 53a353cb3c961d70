"""The loop of a viewer of a log: frames are computed while one looks at them, and kept."""

from __future__ import annotations

import time
from collections.abc import Iterator

from tauten.service.frames import FrameHistory, RecordedRobot, ViewFrame
from tauten.service.node import Clock
from tauten.service.process import StopFlag
from tauten.service.view.charts import SPAN
from tauten.service.view.keeping import FILM, SaveButtons
from tauten.service.view.panel import Request, ViewPanel
from tauten.service.view.picture import TRAIL, RobotScene
from tauten.service.view.web import Guard, LoopbackServer
from tauten.service.view.words import frame_in_words

_RATE = 30.0  # pictures a second
_SHARE = 0.6  # of the time for computing frames
_PLOTS = 6  # pictures between two updates of the plots


class PlaybackSession:
    """One log in one server."""

    def __init__(self, recorded: RecordedRobot, server: LoopbackServer, guard: Guard) -> None:
        """Fill scene and panel.

        Raises:
            LogError: the log has no tick, or a damaged one at its start.
        """
        self._recorded, self._server = recorded, server
        self._history = FrameHistory(whole=True)
        self._frames: Iterator[ViewFrame | None] = recorded.frames()
        self._complete = False
        while not len(self._history):
            self._compute()
        self._panel = ViewPanel(server, recorded.look, targets=None)
        guard.for_all = self._panel.for_all
        SaveButtons(
            server.gui, recorded.look, guard, self._film, self._panel.viewing, operated=False
        )
        self._scene = RobotScene(server, recorded.look, draggable=False)
        self._shown = 0.0  # s
        self._drawn: tuple[ViewFrame, tuple[bool, bool]] | None = None  # with forces and strain
        self._pictures = 0

    def run(self, stop: StopFlag, seconds: float | None = None) -> int:
        """Show the log until a request to stop; returns the number of pictures.

        Raises:
            LogError: the log is damaged further on.
        """
        clock, begin = Clock(1.0 / _RATE), time.monotonic()
        while not stop.requested and (seconds is None or time.monotonic() - begin < seconds):
            clock.wait()
            end = time.monotonic() + _SHARE / _RATE
            while not self._complete and time.monotonic() < end:
                self._compute()
            self._move()
            self._draw()
        return self._pictures

    def _film(self) -> list[ViewFrame]:
        """The last seconds up to the frame that is shown."""
        return self._history.between(self._shown - FILM, self._shown)

    def _compute(self) -> None:
        """Compute one tick."""
        try:
            frame = next(self._frames)
        except StopIteration:
            self._complete = True
            return
        if frame is not None:
            self._history.add(frame)

    def _move(self) -> None:
        """Move the time that is shown."""
        panel, history = self._panel, self._history
        for request in panel.requests():
            if request is Request.NOW:
                self._shown = history.last
        scrubbed = panel.take_scrubbed()
        if scrubbed is not None:
            panel.pause(True)
            self._shown = scrubbed
        elif not panel.paused:
            self._shown += panel.speed / _RATE
        self._shown = min(max(self._shown, history.first), history.last)

    def _draw(self) -> None:
        frame = self._history.at(self._shown)
        if frame is None:
            return
        self._pictures += 1
        self._panel.show_onlookers(self._server.onlookers)
        looks = frame, self._panel.viewing.wanted
        if looks != self._drawn:
            self._drawn = looks
            with self._server.atomic():
                self._scene.draw(frame, self._history.between(frame.time - TRAIL, frame.time))
                self._panel.viewing.draw(frame, self._scene)
        if self._pictures % _PLOTS != 1:
            return
        history, panel = self._history, self._panel
        panel.charts.draw(history.between(frame.time - SPAN, frame.time))
        panel.show_time(history.first, history.last, self._shown)
        panel.say(frame_in_words(self._recorded.look, frame, self._notes(), advice=False))

    def _notes(self) -> tuple[str, ...]:
        if self._complete:
            return self._recorded.notes
        return (*self._recorded.notes, f"computed up to {self._history.last:.1f} s")
