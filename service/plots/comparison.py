"""The figure of `tauten compare`: a robot with and without contact, as the paper's Figs. 5 and 11."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tauten.model import Robot, State
from tauten.service.bench import Equilibrium
from tauten.service.plots.body import Side, draw_body, draw_forces, frame


def draw_comparison(
    robot: Robot, touching: Equilibrium, passing: Equilibrium, side: Side, path: Path
) -> None:
    """Draw the robot at rest, without contact and with contact on one scale.

    A robot without contact candidates is drawn at rest and under the command only.
    """
    rest = robot.rest()
    if robot.n_c == 0:
        draw_states(robot, {"at rest": rest, "under the command": passing.state}, side, path)
        return
    states = (rest, passing.state, touching.state)
    points = [robot.points(state) for state in states]
    everything = np.concatenate(points)
    figure = Figure(figsize=(13.0, 6.4), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    apart = 1e3 * np.linalg.norm(touching.effector - passing.effector, axis=1).max()
    titles = ("at rest", "without contact", f"with contact, effector {apart:.1f} mm away")
    for axes, body, title in zip(panels, points, titles, strict=True):
        draw_body(axes, body, robot.triangles, side)
        frame(axes, everything, side)
        axes.set_title(title)
    largest = float(touching.lam_c.max(initial=0.0))
    if largest > 0.0:
        forces = draw_forces(
            panels[2], robot.candidates(touching.state), touching.lam_c, side, largest
        )
        figure.colorbar(forces, ax=panels[2], label="contact force [N]", shrink=0.7)
    for equilibrium, axes, colour in ((passing, panels[1], "k"), (touching, panels[2], "k")):
        tips = 1e3 * equilibrium.effector
        axes.plot(tips[:, side.right], tips[:, side.up], "o", ms=5, mfc="none", mec=colour)
    ghost = 1e3 * passing.effector
    panels[2].plot(ghost[:, side.right], ghost[:, side.up], "x", ms=6, color="0.4")
    figure.savefig(path, dpi=150)


def draw_states(robot: Robot, states: dict[str, State], side: Side, path: Path) -> None:
    """Draw states of a robot side by side on one scale."""
    everything = np.concatenate([robot.points(state) for state in states.values()])
    figure = Figure(figsize=(4.4 * len(states), 4.4), layout="constrained")
    panels = figure.subplots(1, len(states), sharey=True)
    for axes, (title, state) in zip(panels, states.items(), strict=True):
        draw_body(axes, robot.points(state), robot.triangles, side)
        frame(axes, everything, side)
        axes.set_title(title)
        tips = 1e3 * robot.effector(state)
        axes.plot(tips[:, side.right], tips[:, side.up], "o", ms=5, mfc="none", mec="k")
    figure.savefig(path, dpi=110, bbox_inches="tight")
