"""The figure of `tauten compare`: a robot with and without contact, as the paper's Figs. 5 and 11."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tauten.model import Robot, State
from tauten.service.bench import Equilibrium
from tauten.service.plots.body import Side, draw_body, draw_forces, frame
from tauten.service.plots.saving import save_figure

_WIDTH = 13.0 / 3.0  # of a panel, with its margins [inch]
_MARGINS = 0.7, 0.9  # beside the axes of a panel, and above and below them [inch]
_HEIGHTS = 2.2, 6.4  # least and largest of a figure [inch]


def draw_comparison(
    robot: Robot, touching: Equilibrium, passing: Equilibrium, side: Side, path: Path
) -> None:
    """Draw the robot at rest, without contact and with contact on one scale.

    A robot without contact candidates is drawn at rest and under the command only.
    """
    rest = robot.rest()
    if robot.n_c == 0:
        figure, _ = draw_states(robot, {"at rest": rest, "under the command": passing.state}, side)
        save_figure(figure, path, dpi=150)
        return
    apart = 1e3 * np.linalg.norm(touching.effector - passing.effector, axis=1).max()
    with_contact = f"with contact, effector {apart:.1f} mm away"
    states = {"at rest": rest, "without contact": passing.state, with_contact: touching.state}
    figure, panels = draw_states(robot, states, side)
    largest = float(touching.lam_c.max(initial=0.0))
    if largest > 0.0:
        forces = draw_forces(
            panels[2], robot.candidates(touching.state), touching.lam_c, side, largest
        )
        figure.colorbar(forces, ax=panels[2], label="contact force [N]", shrink=0.7)
    ghost = 1e3 * passing.effector
    panels[2].plot(ghost[:, side.right], ghost[:, side.up], "x", ms=6, color="0.4")
    save_figure(figure, path, dpi=150)


def draw_states(robot: Robot, states: dict[str, State], side: Side) -> tuple[Figure, list[Axes]]:
    """Draw states of a robot side by side on one scale: the figure and its panels."""
    everything = np.concatenate([robot.points(state) for state in states.values()])
    extent = np.ptp(everything, axis=0)
    height = (_WIDTH - _MARGINS[0]) * extent[side.up] / extent[side.right] + _MARGINS[1]
    size = _WIDTH * len(states), float(np.clip(height, *_HEIGHTS))
    figure = Figure(figsize=size, layout="constrained")
    panels = list(figure.subplots(1, len(states), sharey=True))
    for axes, (title, state) in zip(panels, states.items(), strict=True):
        draw_body(axes, robot.points(state), robot.triangles, side)
        frame(axes, everything, side)
        axes.set_title(title)
        tips = 1e3 * robot.effector(state)
        axes.plot(tips[:, side.right], tips[:, side.up], "o", ms=5, mfc="none", mec="k")
    return figure, panels
