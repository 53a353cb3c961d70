"""Pictures and films of a robot to keep: with its name, time, legend and scale."""

from __future__ import annotations

import html
import io
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from tauten.reduction import write_text
from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.view.picture import (
    STRAINS,
    TRAIL,
    RobotScene,
    above,
    legend_html,
    legend_rows,
    scale_text,
)
from tauten.service.view.web import open_server

_LAST = 1.0  # s for which the last frame remains
_INCH = 100.0  # pixels
_LINE = 22.0  # pixels of a row of the legend
_COLUMN = 320.0  # pixels of a column of it
_STYLE = (
    "<style>.about{position:fixed;left:12px;top:12px;max-width:20em;padding:8px 0;border-radius:4px;"
    "background:rgba(255,255,255,0.85);color:#222;font:14px sans-serif;pointer-events:none}"
    "@media (prefers-color-scheme:dark){.about{background:rgba(40,40,40,0.85);color:#ddd}}</style>"
)
# after viser's own configuration, which is light or dark whatever the browser prefers
_COLOURS = (
    "<script>window.__VISER_EMBED_CONFIG__.darkMode="
    'matchMedia("(prefers-color-scheme: dark)").matches</script>'
)
_BOX = (
    '<div class="about"><b style="margin:0 12px">{name}</b>{legend}'
    '<div style="margin:3px 12px;font-size:12px">{scale}</div></div>'
)


def write_html(look: RobotLook, frames: Iterable[ViewFrame], file: Path) -> int:
    """Write frames to an HTML file; returns how many.

    Raises:
        OSError: the file cannot be written.
    """
    text, count = film(look, frames)
    if count:
        write_text(file, text)
    return count


def film(look: RobotLook, frames: Iterable[ViewFrame]) -> tuple[str, int]:
    """Frames as an HTML page that plays by itself, light or dark as its browser prefers; and their number."""
    count, trail = 0, list[ViewFrame]()
    with open_server(0, look.robot.name) as (server, _):
        scene = RobotScene(server, look, draggable=False)
        clock = server.scene.add_label("/clock", "", position=above(look))
        recorder = None
        for frame in frames:
            if trail and recorder is not None:
                recorder.insert_sleep(max(frame.time - trail[-1].time, 0.0))
            trail = [one for one in trail if one.time > frame.time - TRAIL] + [frame]
            scene.draw(frame, trail)
            clock.text = f"{frame.time:.1f} s"
            if recorder is None:  # starts with the scene as it is: the first frame
                recorder = server.get_scene_serializer()
            count += 1
        if recorder is None:
            return "", 0
        recorder.insert_sleep(_LAST)
        page = str(recorder.as_html())
    box = _BOX.format(
        name=html.escape(look.robot.name), legend=legend_html(look), scale=scale_text(look)
    )
    head, end, tail = page.replace("</head>", f"{_STYLE}{_COLOURS}</head>", 1).rpartition("</body>")
    return f"{head}{box}{end}{tail}", count


def picture(
    image: NDArray[np.uint8],
    look: RobotLook,
    time: float,
    strain: float | None = None,
    operated: bool = False,
) -> bytes:
    """A PNG of what a browser shows, with the legend below it.

    Args:
        image: (height, width, 3 or 4) of the browser, transparent where nothing is.
        look: of the robot.
        time: of the robot [s].
        strain: at the end of its colours; None: the skin does not have them.
        operated: whether the robot can be operated, and has waypoints.
    """
    height, width = image.shape[:2]
    rows = legend_rows(look, operated=operated)
    if strain is not None:
        rows.insert(0, (STRAINS, f"strain of the skin: 0 to {100.0 * strain:g} %"))
    columns = max(int(width / _COLUMN), 1)
    below = _LINE * (np.ceil(len(rows) / columns) + 1.0)
    figure = Figure(figsize=(width / _INCH, (height + below) / _INCH), dpi=_INCH)
    share = below / (height + below)
    axes = figure.add_axes((0.0, share, 1.0, 1.0 - share))
    axes.set_axis_off()
    axes.imshow(image, interpolation="none", aspect="auto")
    title = f"{look.robot.name}, {time:.2f} s; {scale_text(look)}"
    figure.text(0.01, 0.985, title, va="top", fontsize=11)
    legend = figure.add_axes((0.0, 0.0, 1.0, share))
    legend.set_axis_off()
    legend.set_xlim(0.0, width)
    legend.set_ylim(below, 0.0)
    for i, (colours, text) in enumerate(rows):
        x, y = 14.0 + _COLUMN * (i % columns), _LINE * (i // columns + 0.9)
        part = 36.0 / len(colours)
        for k, colour in enumerate(colours):
            shown = tuple(one / 255.0 for one in colour)
            legend.add_patch(Rectangle((x + k * part, y - 5.0), part, 10.0, color=shown, lw=0))
        legend.text(x + 44.0, y, text, va="center", fontsize=9)
    found = io.BytesIO()
    figure.savefig(found, format="png", dpi=_INCH)
    return found.getvalue()
