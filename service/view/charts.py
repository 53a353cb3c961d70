"""Plots of the last seconds: travel of the actuators, forces against limits, error, step time."""

from __future__ import annotations

import html

import numpy as np
import viser
from viser import uplot

from tauten.model import ActuatorKind
from tauten.model.numerics import Array
from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.wire import DescribedActuator

SPAN = 10.0  # s
_POINTS = 150  # of a line at most
_HEIGHT = 140  # pixels
_NAMED = 3  # lines that the plot itself names; more cover it
# pixels above and to the right of the axes: else the numbers at their ends are cut
_PADDING = (10, 10, 0, 0)
_NOISE = 0.02  # of the distance between limits, or of the robot's size: plots are no narrower
_ROOM = 0.08  # of a range, above and below the values
_TIGHT = 0.3  # of a range, which is made smaller where the values need less
_COLOURS = (
    "#2a5ca0", "#d0402b", "#1f9a5c", "#8a3fa0", "#c78a1a", "#3aa3b8", "#7a5230", "#e07ab0", "#5a6570",
    "#9ab83a",
)  # fmt: skip
_LONGEST = 40  # characters of a name
_NAMES = (
    '<div style="display:flex;flex-wrap:wrap;gap:0 12px;margin:0 12px 6px;font-size:12px">{}</div>'
)
_NAME = '<span><b style="color:{}">—</b> {}</span>'


class _Chart:
    """One plot, whose range changes by leaps and does not show noise as large as the plot is high."""

    def __init__(
        self, server: viser.ViserServer, title: str, names: list[str], least: float
    ) -> None:
        self._handle, self._least = _plot(server, title, names), least
        self._range: tuple[float, float] | None = None

    def draw(self, time: Array, *lines: Array) -> None:
        found = padded_range(np.concatenate(lines), self._least, self._range)
        if found != self._range:
            self._range = found
            self._handle.scales = _scales(found)
        # zeros where there is none: uPlot would not draw NaN
        self._handle.data = (time, *(np.nan_to_num(line, nan=0.0) for line in lines))


class Charts:
    """The plots of a robot, which share the time and its cursor."""

    def __init__(self, server: viser.ViserServer, look: RobotLook) -> None:
        self._look = look
        # of each kind: its actuators, the largest effort of all of them, plots of travel and force
        self._groups: list[tuple[ActuatorKind, list[int], float | None, _Chart, _Chart]] = []
        for kind, numbers in groups(look.robot.actuators).items():
            own = [look.robot.actuators[i] for i in numbers]
            position, effort = kind.position, kind.effort
            shown = [one.name for one in own]
            least = position.scale * _least([one.position for one in own])
            travel = _Chart(server, position.label, shown, least)
            limit = _common_limit(kind, own)
            lines = shown if limit is None else [*shown, "limit"]
            least = effort.scale * _least([one.effort for one in own])
            # decisions are within limits; what a robot that keeps positions has may be beyond them
            of = "" if look.ghost is None else ", simulated"
            force = _Chart(server, f"{effort.label}{of}", lines, least)
            self._groups.append((kind, numbers, limit, travel, force))
            if len(lines) > _NAMED:
                server.gui.add_html(names_html(lines))
        self._error = _Chart(
            server, "distance to target [mm]", ["error"], 1e3 * _NOISE * look.robot.size
        )
        self._step = _Chart(server, "step [ms]", ["step", "period"], 1e3 / look.robot.rate)

    def draw(self, frames: list[ViewFrame]) -> None:
        """Show frames of the last `SPAN` seconds."""
        if len(frames) < 2:
            return
        frames = frames[:: max(len(frames) // _POINTS, 1)]
        time = np.array([frame.time for frame in frames])  # (m,)
        position = np.array([frame.position for frame in frames])  # (m, n_a)
        effort = np.array([frame.effort for frame in frames])  # (m, n_a)
        for kind, numbers, limit, travel, force in self._groups:
            travel.draw(time, *(kind.position.scale * position[:, i] for i in numbers))
            lines = [kind.effort.scale * effort[:, i] for i in numbers]
            if limit is not None:
                lines.append(np.full(len(time), limit))
            force.draw(time, *lines)
        self._error.draw(time, 1e3 * np.array([self._look.error(frame) for frame in frames]))
        step = 1e3 * np.array([frame.step for frame in frames])
        self._step.draw(time, step, np.full(len(time), 1e3 / self._look.robot.rate))


def _least(limits: list[tuple[float, float]]) -> float:
    """Least width of a plot of quantities with these limits, of which some may be infinite [SI]."""
    widths = [high - low for low, high in limits if np.isfinite([low, high]).all()]
    return _NOISE * max(widths, default=0.0) or 1e-9


def _scales(shown: tuple[float, float]) -> dict[str, uplot.Scale]:
    return {
        "x": uplot.Scale(time=False, auto=True),
        "y": uplot.Scale(auto=False, range=shown),
    }


def groups(actuators: tuple[DescribedActuator, ...]) -> dict[ActuatorKind, list[int]]:
    """Numbers of the actuators by their kind, in the order in which the kinds appear."""
    found: dict[ActuatorKind, list[int]] = {}
    for i, actuator in enumerate(actuators):
        found.setdefault(actuator.kind, []).append(i)
    return found


def _common_limit(kind: ActuatorKind, actuators: list[DescribedActuator]) -> float | None:
    """Largest effort of all actuators of a kind as shown; None where they differ."""
    found = {one.effort[1] for one in actuators}
    limit = kind.effort.scale * found.pop()
    return limit if not found and np.isfinite(limit) else None


def _colour(number: int, name: str) -> str:
    """The colour of a line."""
    return "#c00000" if name in ("limit", "period") else _COLOURS[number % len(_COLOURS)]


def names_html(names: list[str]) -> str:
    """The names of lines in their colours, as HTML."""
    shown = (
        _NAME.format(_colour(i, name), html.escape(name[:_LONGEST])) for i, name in enumerate(names)
    )
    return _NAMES.format("".join(shown))


def _plot(server: viser.ViserServer, title: str, names: list[str]) -> viser.GuiUplotHandle:
    """An empty plot."""
    lines = tuple(
        uplot.Series(
            label=name,
            stroke=_colour(i, name),
            width=1.5,
        )
        for i, name in enumerate(names)
    )
    empty = np.array([0.0, 1.0])
    return server.gui.add_uplot(
        (empty, *(np.zeros(2) for _ in names)),
        (uplot.Series(label="time [s]"), *lines),
        title=title,
        scales=_scales((0.0, 1.0)),
        cursor=uplot.Cursor(sync={"key": "time"}),
        legend=uplot.Legend(show=len(names) <= _NAMED),
        height=_HEIGHT,
        padding=_PADDING,
    )


def padded_range(
    values: Array, least: float, before: tuple[float, float] | None
) -> tuple[float, float]:
    """A range around values; where none is negative, hardly anything below zero.

    Args:
        values: that are drawn, finite ones among them.
        least: its least width.
        before: the range so far, which stays where the values are within it and take much of it.
    """
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
    if before is not None and before[0] <= low and high <= before[1]:
        width = before[1] - before[0]
        if width <= max(least, (high - low) / _TIGHT) * (1.0 + 1e-9):
            return before
    width = max(least, (high - low) * (1.0 + 2.0 * _ROOM))
    begin = 0.5 * (low + high - width)
    if low >= 0.0:
        begin = max(begin, -_ROOM * width)
    return begin, begin + width
