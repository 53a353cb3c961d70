"""Where effectors get: the reach of one, and the nearest point to a target that is out of reach."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import viser

from tauten.model.numerics import Array
from tauten.service.frames import Miss, ReachSet
from tauten.service.view.picture.surroundings import length_text

REACH, MISS = (40, 150, 160), (215, 60, 40)


class ReachDrawing:
    """Both in a scene, shown while there is something to show."""

    def __init__(self, scene: viser.SceneApi, size: float) -> None:
        self._scene, self._size = scene, size
        self._points = 0
        self._miss: tuple[Array, Array] | None = None

    def show_reach(self, found: ReachSet) -> None:
        """Show positions, or a curve through them; none remove what was shown."""
        if len(found.points) == self._points:
            return
        self._points = len(found.points)
        self._scene.remove_by_name("/reach")
        points = found.points.astype(np.float32)
        if found.is_curve and len(points) > 1:
            self._scene.add_line_segments(
                "/reach", np.array(list(pairwise(points))), REACH, thickness=0.008 * self._size
            )
        elif len(points):
            self._scene.add_point_cloud(
                "/reach", points, REACH, point_size=0.012 * self._size, point_shape="circle",
                precision="float32",
            )  # fmt: skip

    def show_miss(self, miss: Miss | None) -> None:
        """Show a line from a target to the nearest point with its length; None: no line."""
        shown = None if miss is None else (miss.target, miss.nearest)
        if _same(shown, self._miss, 1e-3 * self._size):
            return
        self._miss = shown
        self._scene.remove_by_name("/nearest")
        self._scene.remove_by_name("/nearest_line")
        if miss is None:
            return
        ends = np.stack([miss.target, miss.nearest])[None].astype(np.float32)
        self._scene.add_line_segments("/nearest_line", ends, MISS, thickness=0.004 * self._size)
        self._scene.add_icosphere(
            "/nearest", 0.018 * self._size, MISS, opacity=0.5, position=miss.nearest,
            cast_shadow=False, receive_shadow=False,
        )  # fmt: skip
        self._scene.add_label(
            "/nearest/distance",
            f"nearest, {length_text(round(miss.distance, 4))}",
            anchor="top-left",
        )


def _same(
    one: tuple[Array, Array] | None, other: tuple[Array, Array] | None, within: float
) -> bool:
    if one is None or other is None:
        return one is other
    return all(float(np.abs(a - b).max()) <= within for a, b in zip(one, other, strict=True))


def nearest_of(miss: Miss, found: ReachSet) -> Miss:
    """The same with a point of the reach as nearest point, where that is nearer."""
    if len(found.points) == 0:
        return miss
    away = np.linalg.norm(found.points - miss.target, axis=1)
    if away.min() >= miss.distance:
        return miss
    return Miss(miss.effector, miss.target, found.points[away.argmin()])
