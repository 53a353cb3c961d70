"""The loop of a viewer: inputs of the operator, one period of the robot, and a picture 30 times a second."""

from __future__ import annotations

import time
from pathlib import Path
from queue import SimpleQueue

import numpy as np
import viser

from tauten.model.numerics import Array
from tauten.service.frames import (
    RESTED,
    FrameHistory,
    Miss,
    ReachSearch,
    ReachSet,
    ServedRobot,
    SimulatedRobot,
    TargetStore,
    ViewFrame,
    missed,
)
from tauten.service.node import Clock
from tauten.service.plant import TargetPath
from tauten.service.process import StopFlag, drained
from tauten.service.view.cable_drawing import CableDrawing
from tauten.service.view.charts import SPAN
from tauten.service.view.hand_pull import HandPull
from tauten.service.view.keeping import FILM, SaveButtons
from tauten.service.view.panel import Request, ViewPanel
from tauten.service.view.picture import (
    TRAIL,
    ReachDrawing,
    RobotScene,
    nearest_of,
)
from tauten.service.view.program import WaypointProgram
from tauten.service.view.web import Guard, LoopbackServer
from tauten.service.view.words import frame_in_words, in_the_past, without_node
from tauten.service.wire import OperatorCommand

FRAMES = 30.0  # a second
_PLOTS = 6  # frames between two updates of the plots


class ViewSession:
    """One robot in one server.

    Attributes:
        source: of the frames.
        targets: what is followed while it is armed.
        cable: that is being drawn; None: none can be.
    """

    def __init__(
        self,
        source: SimulatedRobot | ServedRobot,
        server: LoopbackServer,
        guard: Guard,
        robot_file: Path | None = None,
        reach: ReachSearch | None = None,
    ) -> None:
        """Fill scene and panel; without a robot file no cables are drawn, without a search no reach."""
        look = source.look
        self.source, self._server = source, server
        self.targets = TargetStore(look.robot.effectors, look.robot.size)
        self._panel = ViewPanel(
            server, look, self.targets, draws=robot_file is not None, reaches=reach is not None
        )
        self._scene = RobotScene(server, look, draggable=True)
        self._reach, self._reach_drawing = reach, ReachDrawing(server.scene, look.robot.size)
        self._history = FrameHistory(whole=False)
        self._shown: float | None = None  # time of the frame that is shown; None: the newest
        self._elapsed = 0.0  # s of the robot
        self._frames = 0
        # frame, ghost, points of a new cable, forces and strain
        self._looks: tuple[ViewFrame, bool, int, tuple[bool, bool]] | None = None
        self._plotted: ViewFrame | None = None
        self._clicks: SimpleQueue[tuple[Array, Array]] = SimpleQueue()
        self.cable: CableDrawing | None = None
        if robot_file is not None:
            self.cable = CableDrawing(server.scene, look, robot_file)
            server.scene.on_click()(self._clicked)
        self._scene.on_drag(self._dragged)
        self._panel.on_follow(self.targets.arm)
        self._panel.on_scalar(self._dragged)
        guard.operator_left = self._disarm
        guard.for_all = self._panel.for_all
        self._simulated = source if isinstance(source, SimulatedRobot) else None
        self._pushing = HandPull(server.scene, look, self._scene.skins) if self._simulated else None
        SaveButtons(server.gui, look, guard, self._film, self._panel.viewing, operated=True)
        guard.uploads = self.program.uploads

    @property
    def program(self) -> WaypointProgram:
        """Waypoints of the effector that is chosen in the panel."""
        assert self._panel.program is not None
        return self._panel.program

    @property
    def newest(self) -> ViewFrame | None:
        """The newest frame; None before the first."""
        return self._history.at(self._history.last)

    def arm(self) -> None:
        """Follow the target from now on."""
        self.targets.arm(True)

    def follow_path(self, path: TargetPath) -> None:
        """Move the first effector's target along a path from now on, until the operator moves it."""
        self.program.follow(path, self._elapsed)

    def run(self, stop: StopFlag, seconds: float | None = None) -> None:
        """Show the robot until a request to stop."""
        rate = self.source.look.robot.rate
        clock, period = Clock(1.0 / rate), 1.0 / rate
        begin, drawn = time.monotonic(), -1.0
        while not stop.requested and (seconds is None or time.monotonic() - begin < seconds):
            clock.wait()
            wanted = 1.0 / (self._panel.speed if self.source.pausable else 1.0) / rate
            if wanted != period:
                clock, period = Clock(wanted), wanted
            now = time.monotonic()
            due = now - drawn >= 1.0 / FRAMES - 0.25 * period
            self._period(due)
            if due:
                drawn = now
                self._draw()

    def _period(self, due: bool) -> None:
        """Requests of the operator, then one period of the robot."""
        for request in self._panel.requests():
            self._do(request)
        for order in self._panel.locks.orders() if self._panel.locks is not None else ():
            self.source.command(order)
        if (scrubbed := self._panel.take_scrubbed()) is not None:
            self._panel.pause(True)
            self._shown = scrubbed
        paused = self._panel.paused
        if paused and self._shown is None:
            self._shown = self._history.last
        if not paused and self.source.pausable:
            self._shown = None
        self.program.advance(self._elapsed, self._scene.show_waypoints)
        if paused and self.source.pausable:
            return
        if self.source.silence:  # a node that is started again is not to move the robot at once
            self.program.end()
            self._disarm()
        self._push()
        self._elapsed += 1.0 / self.source.look.robot.rate
        frame = self.source.advance(self.targets.goal(), due)
        if frame is not None:
            self._history.add(frame)
            self.targets.rest_at(frame.values)

    def _film(self) -> list[ViewFrame]:
        """The last seconds up to the frame that is shown."""
        end = self._history.last if self._shown is None else self._shown
        return self._history.between(end - FILM, end)

    def _push(self) -> None:
        """Pull the simulated robot where the mouse does."""
        if self._simulated is None or self._pushing is None or self.newest is None:
            return
        positions = self.source.look.positions(self.newest.values)
        effector, end = self._pushing.taken(positions) or (0, None)
        force = self._simulated.pull(effector, end)
        self._pushing.show(None if end is None else positions[effector], force)

    def _draw(self) -> None:
        history, panel = self._history, self._panel
        panel.show_onlookers(self._server.onlookers)
        if self._shown is not None and not panel.paused:  # the past, at the chosen speed
            self._shown += panel.speed / FRAMES
            if self._shown >= history.last:
                self._shown = None if panel.speed == 1.0 else history.last
        shown = history.last if self._shown is None else self._shown
        frame = history.at(shown)
        if frame is None:
            return
        self._frames += 1
        self._take_clicks(frame)
        self._scene.show_ghost(panel.shows_ghost)
        looks = frame, panel.shows_ghost, len(self.cable or ()), panel.viewing.wanted
        with self._server.atomic():
            if looks != self._looks:  # nothing is sent while nothing moves
                self._looks = looks
                self._scene.draw(frame, history.between(frame.time - TRAIL, frame.time))
                if self.cable is not None:
                    self.cable.draw(frame.geometry.vertices)
                panel.viewing.draw(frame, self._scene)
            self._scene.show_gizmos(frame.time >= history.last)
            self._scene.place_gizmos(self.targets.values)
        panel.show_follow(self.targets.armed)
        panel.show_scalars(self.targets.values, self.source.look)
        if self._frames % _PLOTS == 1:
            self._say(frame)

    def _say(self, frame: ViewFrame) -> None:
        """Update plots, slider and words: a few times a second are enough to read."""
        history, panel, look = self._history, self._panel, self.source.look
        if frame is not self._plotted:
            self._plotted = frame
            panel.charts.draw(history.between(frame.time - SPAN, frame.time))
        if panel.locks is not None:
            panel.locks.show(frame.position, self.source.locked)
        panel.show_time(history.first, history.last, frame.time)
        miss = self._show_reach(missed(look, history.between(frame.time - RESTED, frame.time)))
        words = frame_in_words(look, frame, self.source.notes, miss=miss)
        if self.source.silence:
            words = without_node(words, self.source.silence)
        panel.say(words if self._shown is None else in_the_past(words, frame.time, history.last))

    def _show_reach(self, miss: Miss | None) -> Miss | None:
        """Show the reach where it is wanted; the target that is missed, with the nearest point known."""
        found, panel = ReachSet(), self._panel
        if self._reach is not None and panel.shows_reach:
            found = self._reach.of(panel.effector)
        panel.show_progress(found)
        self._reach_drawing.show_reach(found)
        if miss is not None and miss.effector == panel.effector:
            miss = nearest_of(miss, found)
        self._reach_drawing.show_miss(miss)
        return miss

    def _do(self, request: Request) -> None:
        """Carry out a request of the operator."""
        if request.value in set(OperatorCommand):
            self._command(OperatorCommand(request.value))
        elif request is Request.NOW:
            self._shown = None
            self._panel.pause(False)
        elif request is Request.UNDO and self.cable is not None:
            self.cable.undo()
        elif request is Request.SAVE_CABLE and self.cable is not None:
            self._panel.say_about_cable(self.cable.save(self._panel.cable_name))

    def _take_clicks(self, frame: ViewFrame) -> None:
        """Take clicks as points of a new cable while one is drawn."""
        for origin, direction in drained(self._clicks):
            if self.cable is not None and self._panel.draws:
                self.cable.click(origin, direction, frame.geometry.vertices)

    def _clicked(self, event: viser.SceneClickEvent) -> None:
        self._clicks.put((np.array(event.ray_origin), np.array(event.ray_direction)))

    def _command(self, command: OperatorCommand) -> None:
        self.source.command(command)
        if command in (OperatorCommand.STOP, OperatorCommand.HOLD):
            self.program.end()
        if command is OperatorCommand.STOP:
            self._disarm()
        if self.source.pausable:
            self._panel.pause(False)

    def _dragged(self, effector: int, values: Array) -> None:
        self.program.end()
        self.targets.put(effector, values)

    def _disarm(self) -> None:
        """The dead man's switch: the browser that operated has left, or the node."""
        self.targets.arm(False)
        if self._pushing is not None:
            self._pushing.release()
