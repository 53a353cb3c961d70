"""Draws `docs/figures/NAME-light.webp` and `NAME-dark.webp` of the examples with friction.

    python docs/scripts/contact_films.py crawler

Forces of contacts that stick and of those that slide have different colours.
"""

from __future__ import annotations

import argparse
import runpy
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from film import FIGURES, MM, THEMES, Theme, draw_course, picture_of
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from PIL import Image

from tauten.model import ContactForces, Simulator
from tauten.model.load import load_robot
from tauten.model.numerics import Array, Bools, Ints
from tauten.model.robot import obstacles_of
from tauten.service.plots.body import Side, draw_body

EXAMPLES = FIGURES.parents[1] / "examples"
STICKS, SLIDES = "#2e9e5b", "#e6862a"
OBJECT = np.array([0.68, 0.56, 0.80])


@dataclass(frozen=True, slots=True)
class Scene:
    """What a film shows.

    Attributes:
        example: name of the program in examples/.
        run: from its names, the simulator after each step.
        plots: titles and what is plotted, from a simulator.
        every: steps between two frames.
        rate: frames a second.
        turn: from which side it is seen: azimuth and elevation [degrees].
        floor: x and y between which a floor at z = 0 is drawn [m]; None: none.
        force: length of an arrow [m/N].
        shape: of an obstacle, its points and triangles; None: none.
        pair: of surfaces whose forces are drawn; None: all.
    """

    example: str
    run: Callable[[dict[str, Any]], Iterator[Simulator]]
    plots: tuple[tuple[str, Callable[[Simulator], float]], ...]
    every: int
    rate: int
    turn: tuple[float, float]
    force: float
    floor: tuple[tuple[float, float], tuple[float, float]] | None = None
    shape: Callable[[], tuple[Array, Ints]] | None = None
    pair: int | None = None


@dataclass(slots=True)
class Film:
    """What a run has shown.

    Attributes:
        triangles: (t, 3) of the surface.
        coloured: (t,) which belong to an object.
        h: time between two frames [s].
        points: of the surface in each frame, (P, 3) [m].
        contacts: in each frame.
        values: of the plots in each frame.
    """

    triangles: Ints
    coloured: Bools
    h: float
    points: list[Array] = field(default_factory=list)
    contacts: list[ContactForces] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)


def crawler_scene() -> Scene:
    """The strip from the side, two cycles."""
    return Scene(
        example="07_crawler",
        run=function_of({}, "crawl", 2),
        plots=(
            ("front foot [mm]", lambda now: MM * now.tip[0]),
            ("tension, rear cable [N]", lambda now: now.effort[0]),
            ("tension, front cable [N]", lambda now: now.effort[1]),
        ),
        every=2, rate=15, turn=(-20.0, 14.0), force=0.4,
        floor=((-0.06, 0.08), (-0.015, 0.015)),
    )  # fmt: skip


def ring_scene() -> Scene:
    """The ring from the side, two half turns of the oval."""
    names: dict[str, Any] = {}

    return Scene(
        example="13_ring",
        run=function_of(names, "roll", 2),
        plots=(
            ("place of the middle [mm]", lambda now: MM * now.tip[0]),
            ("cosine of its angle", lambda now: float(np.cos(names["turned"](now)))),
            ("largest tension [N]", lambda now: now.effort.max()),
        ),
        every=3, rate=15, turn=(-20.0, 14.0), force=0.15,
        floor=((-0.04, 0.17), (-0.02, 0.02)),
    )  # fmt: skip


def plate_scene() -> Scene:
    """The finger and its plate: 20 mm of cable, and half of them back."""
    names: dict[str, Any] = {}
    corners = [
        [0.03, -0.01, -0.11],
        [0.03, 0.025, -0.11],
        [0.03, 0.025, -0.04],
        [0.03, -0.01, -0.04],
    ]

    def run(found: dict[str, Any]) -> Iterator[Simulator]:
        names.update(found)
        simulator = Simulator.of(found["FILE"], contact="full")
        yield simulator
        h = simulator.robot.integration.h
        for time in h * np.arange(1, round(2.0 / h) + 1):
            pulled = np.interp(time, [0.0, 1.0, 1.2, 1.8, 2.0], [0.0, 0.02, 0.02, 0.01, 0.01])
            assert simulator.move(position=[pulled]).converged
            yield simulator

    return Scene(
        example="10_finger_on_plate",
        run=run,
        plots=(
            ("tip along the plate [mm]", lambda now: MM * now.tip[2]),
            ("normal force of the plate [N]", lambda now: names["pressed"](now)[0]),
            ("friction of the plate [N]", lambda now: names["pressed"](now)[1]),
        ),
        every=2, rate=15, turn=(-25.0, 10.0), force=0.04,
        shape=lambda: (np.array(corners), np.array([[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]])),
        pair=len(load_robot(EXAMPLES / "finger_on_plate.toml").pairs) - 1,
    )  # fmt: skip


def function_of(
    names: dict[str, Any], name: str, *more: object
) -> Callable[[dict[str, Any]], Iterator[Simulator]]:
    """A scene's run by a function of its example, called with the robot of the example's file.

    Args:
        names: the example's names are kept here, for the plots.
        name: of the function, which gives the simulator after every step.
        more: what else it is called with.
    """

    def run(found: dict[str, Any]) -> Iterator[Simulator]:
        names.update(found)
        yield from found[name](load_robot(found["FILE"]), *more)

    return run


def grasp_scene() -> Scene:
    """The gripper from the side and above."""
    names: dict[str, Any] = {}

    return Scene(
        example="08_grasp",
        run=function_of(names, "carry"),
        plots=(
            ("height of the cube [mm]", lambda now: MM * names["cube"](now)[:, 2].mean()),
            ("force of the fingers, upwards [N]", lambda now: names["grip"](now)[2]),
            ("tension [N]", lambda now: now.effort[0]),
        ),
        every=2, rate=15, turn=(-25.0, 20.0), force=0.06,
        floor=((-0.11, 0.11), (-0.03, 0.03)),
    )  # fmt: skip


def post_scene() -> Scene:
    """The strip and the post, from the side and above."""
    names: dict[str, Any] = {}

    return Scene(
        example="09_post",
        run=function_of(names, "wind"),
        plots=(
            ("tension of the cable [N]", lambda now: now.effort[0]),
            ("way of the base [mm]", lambda now: MM * now.position[1]),
            ("force of the motor [N]", lambda now: names["drawn"](now)),
        ),
        every=1, rate=15, turn=(-15.0, 55.0), force=0.06,
        shape=lambda: outline(names["FILE"]),
    )  # fmt: skip


def push_scene() -> Scene:
    """The finger and the block from the side."""
    names: dict[str, Any] = {}

    return Scene(
        example="11_push",
        run=function_of(names, "push"),
        plots=(
            ("way of the block [mm]", lambda now: MM * (now.tip[0] - names["START"])),
            ("tension of the cable [N]", lambda now: now.effort[0]),
            ("force on the block [N]", lambda now: names["pushed"](now)),
        ),
        every=2, rate=15, turn=(-25.0, 15.0), force=0.4,
        floor=((-0.03, 0.05), (-0.02, 0.02)),
    )  # fmt: skip


def roll_scene() -> Scene:
    """The pad and the ball from the side."""
    names: dict[str, Any] = {}

    return Scene(
        example="14_roll",
        run=function_of(names, "roll"),
        plots=(
            ("way of the ball along x [mm]", lambda now: MM * names["moved"](now)[0]),
            ("its turn about y [degrees]", lambda now: float(np.degrees(names["turned"](now)[1]))),
            ("force of the pad on the ball [N]", lambda now: names["pressed"](now)),
        ),
        every=2, rate=15, turn=(-20.0, 8.0), force=0.02,
        floor=((-0.03, 0.03), (-0.03, 0.03)),
    )  # fmt: skip


def lift_scene() -> Scene:
    """The gripper that is told where its cube is to go."""
    names: dict[str, Any] = {}

    return Scene(
        example="12_lift",
        run=function_of(names, "lift"),
        plots=(
            ("height of the cube [mm]", lambda now: MM * now.tip[2]),
            ("force of the fingers, upwards [N]", lambda now: names["grip"](now)),
            ("tension [N]", lambda now: now.effort[0]),
        ),
        every=1, rate=15, turn=(-25.0, 20.0), force=0.02,
        floor=((-0.11, 0.02), (-0.03, 0.03)),
    )  # fmt: skip


SCENES = {
    "crawler": crawler_scene, "grasp": grasp_scene, "post": post_scene, "push": push_scene,
    "roll": roll_scene, "lift": lift_scene, "ring": ring_scene, "plate": plate_scene,
}  # fmt: skip


def filmed(scene: Scene) -> Film:
    """Run a scene."""
    names = runpy.run_path(str(EXAMPLES / f"{scene.example}.py"), run_name=scene.example)
    film: Film | None = None
    for number, simulator in enumerate(scene.run(names)):
        robot = simulator.robot
        if film is None:
            film = Film(
                robot.triangles,
                np.isin(np.arange(len(robot.triangles)), robot.body.of_objects),
                scene.every * robot.h,
            )
        if number % scene.every == 0:
            film.points.append(robot.points(simulator.state))
            film.contacts.append(simulator.contacts)
            film.values.append([value(simulator) for _, value in scene.plots])
    assert film is not None
    return film


def outline(file: Path) -> tuple[Array, Ints]:
    """Points (v, 3) [m] and triangles (t, 3) of the first obstacle of a robot."""
    found = obstacles_of(load_robot(file))[0]
    return found.vertices, found.triangles


def turned(turn: tuple[float, float]) -> Array:
    """The rotation (3, 3) after which the eye looks along y."""
    a, e = np.radians(turn)
    azimuth = np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])
    tilt = np.array([[1, 0, 0], [0, np.cos(e), -np.sin(e)], [0, np.sin(e), np.cos(e)]])
    found: Array = tilt @ azimuth
    return found


def draw_floor(axes: Axes, scene: Scene, R: Array, theme: Theme) -> None:
    """A floor with a line every centimetre."""
    if scene.floor is None:
        return
    (x0, x1), (y0, y1) = scene.floor
    corners = np.array([[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0]]) @ R.T
    axes.add_collection(
        PolyCollection([MM * corners[:, [0, 2]]], facecolors=theme.ink, alpha=0.12, zorder=-2)
    )
    at = np.arange(np.ceil(100 * x0), np.floor(100 * x1) + 1) / 100
    ends = np.stack([np.stack([at, 0 * at + y, 0 * at], axis=1) @ R.T for y in (y0, y1)], axis=1)
    axes.add_collection(
        LineCollection(
            list(MM * ends[:, :, [0, 2]]), colors=theme.ink, lw=0.6, alpha=0.4, zorder=-1
        )
    )


def draw_arrows(axes: Axes, found: ContactForces, scene: Scene, R: Array) -> None:
    """The forces on what touches, by stick and slip."""
    pushing = found.pushing & (np.linalg.norm(found.force, axis=1) * scene.force > 2e-4)
    if scene.pair is not None:
        pushing &= found.contacts.pair == scene.pair
    start = found.contacts.point[pushing] @ R.T
    end = start + scene.force * found.force[pushing] @ R.T
    colours = np.where(found.sliding[pushing], SLIDES, STICKS)
    lines = MM * np.stack([start, end], axis=1)[:, :, [0, 2]]
    axes.add_collection(LineCollection(list(lines), colors=list(colours), lw=1.8, zorder=4))
    axes.scatter(MM * start[:, 0], MM * start[:, 2], c=list(colours), s=6.0, zorder=5)


def draw(film: Film, scene: Scene, theme: Theme) -> list[Image.Image]:
    """The pictures of a film.

    Args:
        film: what they show.
        scene: how.
        theme: their colours.
    """
    R, count = turned(scene.turn), len(scene.plots)
    figure = Figure(figsize=(8.4, 3.2), dpi=100, facecolor=theme.paper)
    grid = figure.add_gridspec(
        count, 2, width_ratios=(1.6, 1.0), left=0.01, right=0.975, top=0.92, bottom=0.14, hspace=0.6
    )
    body = figure.add_subplot(grid[:, 0])
    plots = [figure.add_subplot(grid[row, 1]) for row in range(count)]
    shape = scene.shape() if scene.shape else None
    seen = [points @ R.T for points in film.points]
    every = np.concatenate([*seen, *([shape[0] @ R.T] if shape else [])])
    low, high = MM * every.min(axis=0) - 4.0, MM * every.max(axis=0) + 4.0
    time, values = film.h * np.arange(len(seen), dtype=float), np.array(film.values)
    colour = np.where(film.coloured[:, None], OBJECT, np.array(theme.body))
    if shape:
        colour = np.concatenate([colour, np.full((len(shape[1]), 3), 0.6)])
    pictures = []
    for now, points in enumerate(seen):
        body.clear()
        body.set_axis_off()
        body.set(xlim=(low[0], high[0]), ylim=(low[2], high[2]), aspect="equal", anchor="C")
        draw_floor(body, scene, R, theme)
        drawn, triangles = points, film.triangles
        if shape:  # together, sorted by depth
            drawn = np.concatenate([points, shape[0] @ R.T])
            triangles = np.concatenate([film.triangles, shape[1] + len(points)])
        draw_body(body, drawn, triangles, Side(), colour=colour)
        draw_arrows(body, film.contacts[now], scene, R)
        body.plot([], [], color=STICKS, lw=2, label="sticks")
        body.plot([], [], color=SLIDES, lw=2, label="slides")
        body.legend(
            loc="upper left", frameon=False, labelcolor=theme.ink, fontsize=9, ncols=2,
            bbox_to_anchor=(0.0, 1.08),
        )  # fmt: skip
        for axes, (title, _), row in zip(plots, scene.plots, values.T, strict=True):
            draw_course(axes, time, row, now, title, theme)
            space = 0.08 * max(float(np.ptp(row)), 1e-9)
            axes.set_ylim(row.min() - space, row.max() + space)
            axes.tick_params(labelbottom=axes is plots[-1])
        plots[-1].set_xlabel("time [s]", fontsize=9, color=theme.ink)
        pictures.append(picture_of(figure))
    return pictures


def main() -> None:
    """Run and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=list(SCENES), choices=[*SCENES, []])
    parser.add_argument("--folder", type=Path, default=FIGURES, help="where the films go")
    arguments = parser.parse_args()
    for name in arguments.names:
        scene = SCENES[name]()
        film = filmed(scene)
        for theme, colours in THEMES.items():
            first, *others = draw(film, scene, colours)
            first.save(
                arguments.folder / f"{name}-{theme}.webp", save_all=True, append_images=others,
                loop=0, duration=1000 // scene.rate, quality=65, method=4,
            )  # fmt: skip


if __name__ == "__main__":
    main()
