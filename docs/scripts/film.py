"""Draws `docs/figures/film-light.webp` and `film-dark.webp`: a finger follows a target, its notches close.

    python docs/scripts/film.py --robot finger

The controller is that of `tauten serve`; it moves a simulated robot of the full model with pointwise contact.
"""

from __future__ import annotations

import argparse
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from PIL import Image

from tauten.controller import Controller
from tauten.model import Simulator
from tauten.model.numerics import Array, Ints
from tauten.service.plant import PathSettings, make_path
from tauten.service.plots.body import Side, draw_body, draw_forces

FIGURES = Path(__file__).resolve().parents[1] / "figures"
FRAMES, FRAME_RATE, STEPS = 80, 20, 4  # frames, frames a second, control steps a frame
MM = 1e3
SIDE = Side()


@dataclass(frozen=True, slots=True)
class Theme:
    """Colours of a film.

    Attributes:
        paper: of the background.
        ink: of text and lines.
        body: red, green and blue of the robot.
        accent: of the target.
    """

    paper: str
    ink: str
    body: tuple[float, float, float]
    accent: str


THEMES = {
    "light": Theme("#ffffff", "#333333", (0.72, 0.80, 0.90), "#c0392b"),
    "dark": Theme("#0d1117", "#c9d1d9", (0.50, 0.60, 0.73), "#ff6b5b"),
}


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame.

    Attributes:
        points: (P, 3) of the surface [m].
        candidates: (n_c, 3) [m].
        forces: (n_c,) of the contacts [N].
        target: (3,) [m].
        error: from target to tip [m].
        tension: (n_a,) [N].
    """

    points: Array
    candidates: Array
    forces: Array
    target: Array
    error: float
    tension: Array


def run(name: str) -> tuple[list[Frame], Ints, float]:
    """The frames, the triangles of the surface (t, 3), and the time between two frames [s]."""
    controller = Controller.of(name)
    plant = Simulator.of(name, model="full", contact="full")
    robot, steps = plant.robot, FRAMES * STEPS
    settings = PathSettings(period=steps * controller.period, fraction=0.95)
    path = make_path("reach", controller.robot, settings)
    frames = []
    for step in range(steps):
        target = path.at(step * controller.period).reshape(-1)[:3]
        plant.move(position=controller.step(target).position, steps=2)
        if step % STEPS == 0:
            state, error = plant.state, float(np.linalg.norm(plant.tip - target))
            points, candidates = robot.points(state), robot.candidates(state)
            frames.append(Frame(points, candidates, plant.lam_c, target, error, plant.effort))
    return frames, robot.triangles, STEPS * controller.period


def draw(frames: list[Frame], triangles: Ints, spacing: float, theme: Theme) -> list[Image.Image]:
    """The pictures of a film.

    Args:
        frames: what they show.
        triangles: (t, 3).
        spacing: time between two frames [s].
        theme: their colours.
    """
    figure = Figure(figsize=(8.4, 4.2), dpi=100, facecolor=theme.paper)
    grid = figure.add_gridspec(
        3, 2, width_ratios=(1.15, 1.0), left=0.01, right=0.975, top=0.95, bottom=0.12, hspace=0.45
    )
    body = figure.add_subplot(grid[:, 0])
    plots = [figure.add_subplot(grid[row, 1]) for row in range(3)]
    every = MM * np.concatenate([frame.points for frame in frames])
    low, high = every.min(axis=0) - 4.0, every.max(axis=0) + 4.0
    time = spacing * np.arange(len(frames), dtype=float)
    largest = max(frame.forces.max(initial=0.0) for frame in frames)
    rows = (
        ("tip to target [mm]", [MM * frame.error for frame in frames]),
        ("tension [N]", [frame.tension[0] for frame in frames]),
        ("contact forces [N]", [frame.forces.sum() for frame in frames]),
    )
    way = MM * np.array([frame.target for frame in frames])
    pictures = []
    for now, frame in enumerate(frames):
        body.clear()
        body.set_axis_off()
        body.set(xlim=(low[0], high[0]), ylim=(low[2], high[2]), aspect="equal", anchor="C")
        draw_body(body, frame.points, triangles, SIDE, colour=np.array(theme.body))
        body.plot(way[:, 0], way[:, 2], color=theme.accent, lw=1.0, alpha=0.5)
        body.plot(*way[now, [0, 2]], "o", color=theme.accent, ms=7, zorder=5)
        draw_forces(body, frame.candidates, frame.forces, SIDE, max(largest, 1e-9))
        for axes, (title, values) in zip(plots, rows, strict=True):
            draw_course(axes, time, values, now, title, theme)
            axes.set_ylim(0.0, 1.1 * max(max(values), 1e-9))
            axes.tick_params(labelbottom=axes is plots[-1])
        plots[-1].set_xlabel("time [s]", fontsize=9, color=theme.ink)
        pictures.append(picture_of(figure))
    return pictures


def picture_of(figure: Figure) -> Image.Image:
    """The figure as it is now."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return Image.open(stream).convert("RGB")


def draw_course(
    axes: Axes, time: Array, values: ArrayLike, now: int, title: str, theme: Theme
) -> None:
    """Draw a quantity over time: what has been is bold, and its title says what it is now.

    Args:
        axes: to draw into.
        time: (m,) [s].
        values: (m,) of the quantity.
        now: number of the time that is shown.
        title: name and unit.
        theme: colours.
    """
    values = np.asarray(values)
    axes.clear()
    axes.set_facecolor(theme.paper)
    axes.plot(time, values, color=theme.ink, lw=0.8, alpha=0.35)
    axes.plot(time[: now + 1], values[: now + 1], color=theme.ink, lw=1.6)
    axes.plot(time[now], values[now], "o", color=theme.accent, ms=5, clip_on=False)
    shown = round(values[now], 2) + 0.0  # without a sign of zero
    axes.set_title(f"{title}: {shown:.2f}", loc="left", fontsize=10, color=theme.ink)
    axes.set_xlim(0.0, time[-1])
    axes.tick_params(colors=theme.ink, labelsize=8)
    for name, spine in axes.spines.items():
        spine.set(color=theme.ink, visible=name in ("left", "bottom"))


def main() -> None:
    """Run and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="finger", help="robot file or name of a shipped robot")
    shown = run(parser.parse_args().robot)
    for name, theme in THEMES.items():
        first, *others = draw(*shown, theme)
        first.save(
            FIGURES / f"film-{name}.webp", save_all=True, append_images=others, loop=0,
            duration=1000 // FRAME_RATE, quality=70, method=6,
        )  # fmt: skip


if __name__ == "__main__":
    main()
