"""Draws `docs/figures/film.gif`: a robot follows a target that moves along what its cable can reach.

    python docs/film.py --robot finger

Controller and simulated robot are those of `tauten demo`, in one process and without a network.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from tauten.controller import Controller
from tauten.model import Simulator
from tauten.service.plant import PathSettings, make_path
from tauten.service.setup import load_setup

mpl.use("Agg")
import matplotlib.pyplot as plt

OUT = Path(__file__).resolve().parent / "figures" / "film.gif"
FRAMES, FRAME_RATE, STEPS = 72, 18, 4  # frames, frames a second, control steps a frame
BODY, LINE, TARGET = "#9db8d9", "#5d7899", "#c0392b"


def run(robot_name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Surface points of each frame (f, P, 3), triangles, targets (f, 3), tips (f, 3) [m]."""
    setup = load_setup(robot_name)
    robot, steps = setup.robot, FRAMES * STEPS
    path = make_path("reach", robot, PathSettings(period=steps * robot.h, fraction=0.9))
    controller = Controller(robot, setup.contact, settings=setup.controller)
    plant = Simulator(robot, contact="full")
    surfaces, shown, tips = [], [], []
    for step in range(steps):
        target = path.at(step * robot.h)
        plant.step(position=controller.step(target).position)
        if step % STEPS == 0:
            surfaces.append(robot.points(plant.state))
            shown.append(target)
            tips.append(plant.effector[0])
    return np.array(surfaces), robot.triangles, np.array(shown), np.array(tips)


def draw(
    surfaces: np.ndarray, triangles: np.ndarray, targets: np.ndarray, tips: np.ndarray
) -> None:
    """Write the film.

    Args:
        surfaces: (f, P, 3) [m].
        triangles: (t, 3).
        targets: (f, 3) [m].
        tips: (f, 3) [m].
    """
    mm = 1e3
    figure = plt.figure(figsize=(4.8, 4.8), dpi=80)
    axes = figure.add_subplot(projection="3d", proj_type="ortho", computed_zorder=False)
    axes.view_init(elev=12.0, azim=-72.0)
    low, high = mm * surfaces.min(axis=(0, 1)), mm * surfaces.max(axis=(0, 1))
    body = Poly3DCollection([], facecolor=BODY, edgecolor=LINE, linewidths=0.15, shade=False)
    axes.add_collection3d(body)
    (trail,) = axes.plot([], [], [], color=TARGET, linewidth=1.0, zorder=2)
    (dot,) = axes.plot([], [], [], "o", color=TARGET, markersize=6, zorder=3)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    axes.set_axis_off()
    figure.subplots_adjust(0.0, 0.0, 1.0, 0.95)
    title = figure.suptitle("")

    def show(frame: int) -> list[object]:
        body.set_verts(list(mm * surfaces[frame][triangles]))
        trail.set_data_3d(*(mm * targets[: frame + 1]).T)
        dot.set_data_3d(*(mm * targets[frame : frame + 1]).T)
        error = mm * float(np.linalg.norm(tips[frame] - targets[frame]))
        title.set_text(f"tip to target: {error:.1f} mm")
        return [body, trail, dot, title]

    film = FuncAnimation(figure, show, frames=len(surfaces), interval=1000 / FRAME_RATE)
    film.save(OUT, writer=PillowWriter(fps=FRAME_RATE))


def main() -> None:
    """Run and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="finger", help="robot file or name of a shipped robot")
    draw(*run(parser.parse_args().robot))


if __name__ == "__main__":
    main()
