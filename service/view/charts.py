"""Plots of the last seconds: travel of the actuators, forces against limits, error, step time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import viser
from viser import uplot

from tauten.model import ActuatorKind
from tauten.model.numerics import Array
from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.wire import DescribedActuator

SPAN = 10.0  # s
_POINTS = 150  # of a line at most
_HEIGHT = 130  # pixels
_COLOURS = (
    "#2a5ca0", "#d0402b", "#1f9a5c", "#8a3fa0", "#c78a1a", "#3aa3b8", "#7a5230", "#e07ab0", "#5a6570",
    "#9ab83a",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Group:
    """Actuators of one kind."""

    kind: ActuatorKind
    numbers: tuple[int, ...]


class Charts:
    """The plots of a robot."""

    def __init__(self, server: viser.ViserServer, look: RobotLook) -> None:
        """Add them to the panel.

        Args:
            server: whose panel is used.
            look: of the robot.
        """
        self._look = look
        self._groups = groups(look.robot.actuators)
        names = [actuator.name for actuator in look.robot.actuators]
        self._travel, self._force = [], []
        for group in self._groups:
            shown = [names[i] for i in group.numbers]
            self._travel.append(_plot(server, group.kind.position.label, shown))
            limit = _common_limit(look, group)
            lines = shown if limit is None else [*shown, "limit"]
            self._force.append(_plot(server, group.kind.effort.label, lines))
        self._error = _plot(server, "distance to target [mm]", ["error"])
        self._step = _plot(server, "step [ms]", ["step", "period"])

    def draw(self, frames: list[ViewFrame]) -> None:
        """Show frames of the last `SPAN` seconds."""
        if len(frames) < 2:
            return
        frames = frames[:: max(len(frames) // _POINTS, 1)]
        time = np.array([frame.time for frame in frames])  # (m,)
        position = np.array([frame.position for frame in frames])  # (m, n_a)
        effort = np.array([frame.effort for frame in frames])  # (m, n_a)
        for group, travel, force in zip(self._groups, self._travel, self._force, strict=True):
            travel.data = (
                time,
                *(group.kind.position.scale * position[:, i] for i in group.numbers),
            )
            lines = [group.kind.effort.scale * effort[:, i] for i in group.numbers]
            limit = _common_limit(self._look, group)
            if limit is not None:
                lines.append(np.full(len(time), limit))
            force.data = (time, *lines)
        self._error.data = (
            time,
            _gaps_filled(1e3 * np.array([self._look.error(frame) for frame in frames])),
        )
        step = 1e3 * np.array([frame.step for frame in frames])
        self._step.data = (time, step, np.full(len(time), 1e3 / self._look.robot.rate))


def groups(actuators: tuple[DescribedActuator, ...]) -> tuple[_Group, ...]:
    """Actuators by their kind, in the order in which the kinds appear."""
    found: dict[ActuatorKind, list[int]] = {}
    for i, actuator in enumerate(actuators):
        found.setdefault(actuator.kind, []).append(i)
    return tuple(_Group(kind, tuple(numbers)) for kind, numbers in found.items())


def _common_limit(look: RobotLook, group: _Group) -> float | None:
    """Largest effort of all actuators of a group as shown; None where they differ."""
    found = {look.robot.actuators[i].effort[1] for i in group.numbers}
    limit = group.kind.effort.scale * found.pop()
    return limit if not found and np.isfinite(limit) else None


def _gaps_filled(values: Array) -> Array:
    """Values with zeros where there is none: uPlot would not draw NaN."""
    return np.nan_to_num(values, nan=0.0)


def _plot(server: viser.ViserServer, title: str, names: list[str]) -> viser.GuiUplotHandle:
    """An empty plot.

    Args:
        server: whose panel is used.
        title: with the unit.
        names: of its lines.
    """
    lines = tuple(
        uplot.Series(
            label=name,
            stroke="#c00000" if name in ("limit", "period") else _COLOURS[i % len(_COLOURS)],
            width=1.5,
        )
        for i, name in enumerate(names)
    )
    empty = np.array([0.0, 1.0])
    return server.gui.add_uplot(
        (empty, *(np.zeros(2) for _ in names)),
        (uplot.Series(label="time [s]"), *lines),
        title=title,
        scales={"x": uplot.Scale(time=False, auto=True)},
        legend=uplot.Legend(show=len(names) <= 3),
        height=_HEIGHT,
    )
