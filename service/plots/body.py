"""A body seen from the side, shaded, with its contact forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection, PolyCollection

from tauten.model.mesh import unit_normals
from tauten.model.numerics import Array, Ints

_MM = 1e3
_MARGIN = 0.04  # around a body, as a share of its extent
_SILICONE = np.array([0.80, 0.84, 0.88])
_LIGHT = np.array([-0.35, -0.80, 0.50])  # from where light falls: front, left, above


@dataclass(frozen=True, slots=True)
class Side:
    """From which side a body is seen.

    Attributes:
        right: axis drawn to the right, 0 … 2.
        up: axis drawn upwards.
        towards: sign of the third axis towards the eye.
    """

    right: int = 0
    up: int = 2
    towards: int = -1

    @property
    def depth(self) -> int:
        """The axis along which one looks."""
        return 3 - self.right - self.up


def draw_body(
    axes: Axes,
    points: Array,
    triangles: Ints,
    side: Side,
    alpha: float = 1.0,
    colour: Array = _SILICONE,
) -> None:
    """Surface triangles from the farthest to the nearest, shaded by their normals.

    Args:
        axes: to draw into; in millimetres.
        points: (P, 3) [m].
        triangles: (t, 3).
        side: from which it is seen.
        alpha: opacity.
        colour: (3,) or (t, 3) red, green and blue.
    """
    corners = points[triangles]  # (t, 3, 3)
    normal = unit_normals(corners)
    to_eye = side.towards * normal[:, side.depth]
    light = 0.55 + 0.45 * np.clip(normal @ (_LIGHT / np.linalg.norm(_LIGHT)), 0.0, 1.0)
    order = np.argsort(side.towards * corners[:, :, side.depth].mean(axis=1))
    order = order[to_eye[order] > 0.0]
    colours = np.clip((light[:, None] * colour)[order], 0.0, 1.0)
    faces = _MM * corners[order][:, :, [side.right, side.up]]
    axes.add_collection(
        PolyCollection(
            list(faces), facecolors=colours, edgecolors=0.88 * colours, lw=0.3, alpha=alpha
        )
    )


def draw_forces(
    axes: Axes, candidates: Array, lam: Array, side: Side, largest: float
) -> PathCollection:
    """Candidates that push, coloured by their force.

    Args:
        axes: to draw into; in millimetres.
        candidates: (n_c, 3) positions [m].
        lam: (n_c,) forces [N].
        side: from which they are seen.
        largest: force at the end of the scale [N].
    """
    pushing = np.flatnonzero(lam > 1e-3 * largest)
    pushing = pushing[np.argsort(lam[pushing])]
    shown = _MM * candidates[pushing]
    return axes.scatter(
        shown[:, side.right], shown[:, side.up], c=lam[pushing], s=9.0, cmap="YlOrRd",
        vmin=0.0, vmax=largest, linewidths=0.2, edgecolors="0.25", zorder=3,
    )  # fmt: skip


def frame(axes: Axes, points: Array, side: Side) -> None:
    """Set equal scales, and limits around points.

    Args:
        axes: to set up; in millimetres.
        points: (P, 3) to show [m].
        side: from which they are seen.
    """
    shown = _MM * points[:, [side.right, side.up]]
    low, high = shown.min(axis=0), shown.max(axis=0)
    space = _MARGIN * float((high - low).max())
    axes.set_xlim(low[0] - space, high[0] + space)
    axes.set_ylim(low[1] - space, high[1] + space)
    axes.set_aspect("equal")
    axes.set_xlabel(f"{'xyz'[side.right]} [mm]")
    axes.set_ylabel(f"{'xyz'[side.up]} [mm]")
