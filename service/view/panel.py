"""The panel beside the picture: what the operator sets, and what it says about the robot."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterator
from enum import Enum
from queue import SimpleQueue
from typing import Any

import numpy as np
import viser

from tauten.model.numerics import Array
from tauten.service.frames import ReachSet, RobotLook, ScalarScale, TargetStore, scalar_scale
from tauten.service.process import drained
from tauten.service.view.charts import Charts
from tauten.service.view.locks import LockPanel
from tauten.service.view.picture import legend_html
from tauten.service.view.program import WaypointProgram
from tauten.service.view.viewing import Viewing
from tauten.service.view.web import LoopbackServer
from tauten.service.view.words import Words
from tauten.service.wire import DescribedEffector, places_of

SPEEDS = {"1": 1.0, "1/2": 0.5, "1/4": 0.25, "1/10": 0.1}
# Buttons below a text that grows and shrinks would move under the mouse; what does not fit is scrolled to.
_STATUS = '<div style="height:192px;overflow-y:auto">{}</div>'


class Request(Enum):
    """What an operator asks for by a button; a node's commands are called as they are there."""

    HOLD = "hold"
    ENABLE = "enable"
    STOP = "stop"
    RESET = "reset"
    NOW = "now"
    UNDO = "undo"
    SAVE_CABLE = "save cable"


_FOR_ALL = frozenset({Request.STOP, Request.HOLD})


class ViewPanel:
    """Inputs of the operator. Callbacks of the browser only note what happened; the loop reads it.

    Attributes:
        for_all: inputs with the values that browsers that look on may give them, too: to stop, to hold, and
            how they look at the robot.
        viewing: how one looks at the robot.
        locks: of its actuators.
        program: waypoints of a robot that can be operated.
    """

    def __init__(
        self,
        server: LoopbackServer,
        look: RobotLook,
        targets: TargetStore | None,
        draws: bool = False,
        reaches: bool = False,
    ) -> None:
        """Add all elements.

        Args:
            server: whose panel is used.
            look: of the robot.
            targets: of a robot that can be operated; None: it cannot, as in a log.
            draws: whether cables can be drawn: only with a robot file of one's own.
            reaches: whether the reach of effectors can be shown: only with a model.
        """
        self._requests: SimpleQueue[Request] = SimpleQueue()
        self._scrubbed: float | None = None
        self.for_all: dict[str, frozenset[bool | str]] = {}
        self._notices: dict[int, viser.GuiHtmlHandle] = {}
        gui, effectors = server.gui, look.robot.effectors
        self._placed = tuple(one.has_position for one in effectors)
        reaches = reaches and any(self._placed)
        self._status = gui.add_html(_STATUS.format(""))
        self._follow: viser.GuiCheckboxHandle | None = None
        self._scalars: dict[int, tuple[viser.GuiSliderHandle[float], ScalarScale]] = {}
        if targets is not None:
            with gui.add_folder("Operate"):
                self._follow = gui.add_checkbox(
                    "follow", False, hint="The robot follows the target while this is on."
                )
                self._button(server, Request.STOP, "Release the actuators.")
                self._scalars = {
                    i: _scalar_slider(server, one, scalar_scale(one, look.robot.size))
                    for i, one in enumerate(effectors)
                    if not one.has_position
                }
                self._buttons(
                    server,
                    (Request.HOLD, Request.ENABLE, Request.RESET),
                    "hold: the actuators do not move. enable: follow again. reset: ready again after a stop.",
                )
        with gui.add_folder("Time"):
            self._pause = gui.add_checkbox("pause", False)
            self._speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="1")
            self._slider = gui.add_slider("time [s]", 0.0, 1.0, 0.02, 0.0)
            self._buttons(server, (Request.NOW,), "Show the newest moment.")
        self.program = None if targets is None else WaypointProgram(server, look, targets)
        self.locks = None if targets is None else LockPanel(gui, look)
        self.viewing = Viewing(server, look, reaches)
        self.for_all |= self.viewing.for_all
        self._drawing: viser.GuiCheckboxHandle | None = None
        if draws:
            with gui.add_folder("New cable", expand_by_default=False):
                self._drawing = gui.add_checkbox(
                    "draw", False, hint="Click points of the skin: first where the cable leaves."
                )
                self._cable = gui.add_text("name", "new_cable")
                self._buttons(
                    server,
                    (Request.UNDO, Request.SAVE_CABLE),
                    "undo: remove the last point. save cable: append it to the robot file.",
                )
                self._cable_words = gui.add_html("")
        self._ghost: viser.GuiCheckboxHandle | None = None
        with gui.add_folder("Legend", expand_by_default=False):
            if look.ghost is not None:
                self._ghost = gui.add_checkbox(
                    "show the model", False, hint="The model that decides, beside the robot."
                )
            gui.add_html(legend_html(look, reaches, operated=targets is not None))
        with gui.add_folder("Plots"):
            self.charts = Charts(server, look)
        self._slider.on_update(self._on_scrub)

    def on_follow(self, armed: Callable[[bool], None]) -> None:
        """Call a function when the operator switches *follow* on or off."""
        if self._follow is None:
            return

        async def callback(event: viser.GuiEvent[viser.GuiCheckboxHandle]) -> None:
            if event.client_id is not None:
                armed(bool(event.target.value))

        self._follow.on_update(callback)

    def on_scalar(self, moved: Callable[[int, Array], None]) -> None:
        """Call a function with the effector's number and goal value (1,) when a slider is moved."""
        for i, (slider, scale) in self._scalars.items():
            slider.on_update(_slid(i, scale, moved))

    def show_scalars(self, values: Array, look: RobotLook) -> None:
        """Show the targets of one number."""
        places = places_of(look.robot.effectors)
        for i, (slider, scale) in self._scalars.items():
            shown = round(float(values[places[i]][0]) / scale.one, 1)
            if abs(slider.value - shown) > 0.05:
                slider.value = min(max(shown, slider.min), slider.max)  # type: ignore[misc]

    def show_follow(self, armed: bool) -> None:
        """Show whether *follow* is on."""
        if self._follow is not None:
            self._follow.value = armed  # type: ignore[misc]  # viser types it so

    def requests(self) -> Iterator[Request]:
        """Requests since the last call, oldest first."""
        return drained(self._requests)

    @property
    def paused(self) -> bool:
        """Whether time stands still."""
        return bool(self._pause.value)

    def pause(self, paused: bool) -> None:
        """Show whether time stands still."""
        self._pause.value = paused  # type: ignore[misc]  # viser types it so

    @property
    def speed(self) -> float:
        """Speed of time, at most 1."""
        return SPEEDS.get(str(self._speed.value), 1.0)

    @property
    def effector(self) -> int:
        """Number of the effector that waypoints and reach are for."""
        return 0 if self.program is None else self.program.effector

    @property
    def shows_reach(self) -> bool:
        """Whether the reach of that effector is shown: only a position has one."""
        return self._placed[self.effector] and self.viewing.shows_reach

    @property
    def draws(self) -> bool:
        """Whether clicks add points to a new cable."""
        return self._drawing is not None and bool(self._drawing.value)

    @property
    def cable_name(self) -> str:
        """Name of the new cable."""
        return str(self._cable.value)

    def say_about_cable(self, words: str) -> None:
        """Show a text beside the new cable."""
        self._cable_words.content = Words(advice=words).html

    @property
    def shows_ghost(self) -> bool:
        """Whether the model is shown beside the robot."""
        return self._ghost is not None and bool(self._ghost.value)

    def take_scrubbed(self) -> float | None:
        """The time [s] that the operator has moved the slider to since the last call."""
        found, self._scrubbed = self._scrubbed, None
        return found

    def show_time(self, first: float, last: float, shown: float) -> None:
        """Set the slider.

        Args:
            first: earliest time that can be shown [s].
            last: latest time that can be shown [s].
            shown: the time that is shown [s].
        """
        first, last = round(first, 2), max(round(last, 2), round(first, 2) + 0.02)
        self._slider.min, self._slider.max = first, last
        self._slider.value = min(max(shown, first), last)  # type: ignore[misc]  # viser types it so

    def show_progress(self, found: ReachSet) -> None:
        """Show how much of the reach is known, and whether the effector has one."""
        self.viewing.show_progress(found, self._placed[self.effector])

    def say(self, words: Words) -> None:
        """Show a text."""
        self._status.content = _STATUS.format(words.html)

    def show_onlookers(self, onlookers: dict[int, viser.ClientHandle]) -> None:
        """Say to browsers that they look on, and what works there."""
        for number in self._notices.keys() - onlookers.keys():
            self._notices.pop(number).remove()
        for number in onlookers.keys() - self._notices.keys():
            works = "; “stop” and “hold” work here, too" if self.for_all else ""
            words = Words("You look on", f"another browser operates{works}")
            self._notices[number] = onlookers[number].gui.add_html(words.html, order=-1.0)

    async def _on_scrub(self, event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        if event.client_id is not None:
            self._scrubbed = float(event.target.value)

    def _button(self, server: viser.ViserServer, request: Request, hint: str) -> None:
        """A red button that puts a request into the queue."""

        async def callback(_event: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            self._requests.put(request)

        button = server.gui.add_button(request.value, hint=hint, color="red")
        button.on_click(callback)
        if request in _FOR_ALL:
            self.for_all[button._impl.uuid] = frozenset({True})

    def _buttons(self, server: viser.ViserServer, requests: tuple[Request, ...], hint: str) -> None:
        """Buttons in a row that put their requests into the queue."""
        names = {request.value: request for request in requests}

        async def callback(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            if event.target.value in names:
                self._requests.put(names[event.target.value])

        group = server.gui.add_button_group("", tuple(names), hint=hint)
        group.on_click(callback)
        if allowed := {request.value for request in requests if request in _FOR_ALL}:
            self.for_all[group._impl.uuid] = frozenset(allowed)


def _scalar_slider(
    server: viser.ViserServer, effector: DescribedEffector, scale: ScalarScale
) -> tuple[viser.GuiSliderHandle[float], ScalarScale]:
    """A slider of a target of one number."""
    percent = ", in percent of that at rest" * (scale.unit == "%")
    slider = server.gui.add_slider(
        f"{effector.name} [{scale.unit}]", scale.least, scale.largest, 0.1, effector.rest[0] / scale.one,
        hint=f"Target of the {effector.kind}{percent}.",
    )  # fmt: skip
    return slider, scale


def _slid(
    number: int, scale: ScalarScale, moved: Callable[[int, Array], None]
) -> Callable[[viser.GuiEvent[viser.GuiSliderHandle[float]]], Coroutine[Any, Any, None]]:
    async def callback(event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
        if event.client_id is not None:
            moved(number, np.array([scale.one * float(event.target.value)]))

    return callback
