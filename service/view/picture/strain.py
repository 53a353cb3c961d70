"""The skin coloured by its strain: in bands, each a mesh of its own, because a mesh has one colour."""

from __future__ import annotations

import numpy as np
import viser

from tauten.model import Floats
from tauten.model.numerics import Array, Ints
from tauten.service.frames import RobotLook
from tauten.service.view.picture.round_numbers import rounded_up

# From the colour of silicone over yellow to dark red, darker step by step.
COLOURS = (
    (206, 214, 224), (240, 232, 178), (254, 217, 118), (254, 178, 76), (253, 141, 60),
    (252, 78, 42), (227, 26, 28), (177, 0, 38), (110, 0, 40),
)  # fmt: skip
_LEAST = 0.01  # strain at the end of the bar, at least


class StrainSkin:
    """The skin in bands of strain, shown instead of that in one colour while it is wanted.

    Attributes:
        end: strain at the end of the bar.
    """

    def __init__(self, scene: viser.SceneApi, look: RobotLook) -> None:
        surface = look.robot.surface
        self._scene, self._vertices = scene, look.vertices
        self._triangles: Ints = surface.triangles[surface.chambers < 0]
        self._bands: list[viser.MeshHandle] = []
        self.end = _LEAST

    def draw(self, vertices: Floats | None) -> None:
        """Show it with vertices (P, 3) [m]; None: hide it."""
        if vertices is None:
            for band in self._bands:
                band.visible = False
            return
        strain = largest_strain(self._vertices, vertices, self._triangles)
        if len(strain):
            self.end = max(self.end, rounded_up(float(np.quantile(strain, 0.99))))
        level = np.clip((strain / self.end * len(COLOURS)).astype(int), 0, len(COLOURS) - 1)
        if not self._bands:
            self._bands = [self._added(i, vertices) for i in range(len(COLOURS))]
        for i, band in enumerate(self._bands):
            own = self._triangles[level == i]
            band.visible = len(own) > 0
            if len(own):
                band.faces, band.vertices = own.astype(np.uint32), vertices

    def _added(self, number: int, vertices: Floats) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            f"/strain/{number}", vertices, self._triangles[:1].astype(np.uint32),
            color=COLOURS[number], side="double", flat_shading=True, cast_shadow=False,
            receive_shadow=False, visible=False,
        )  # fmt: skip


def largest_strain(rest: Floats, now: Floats, triangles: Ints) -> Array:
    """Largest principal strain of each triangle in its plane, in magnitude: (t,).

    The stretches are the singular values of the map from the triangle at rest to that now.

    Args:
        rest: (P, 3) vertices without strain [m].
        now: (P, 3) vertices [m].
        triangles: (t, 3) of them.
    """
    before, after = _edges(rest, triangles), _edges(now, triangles)  # (t, 3, 2)
    G, C = (np.einsum("tki,tkj->tij", one, one) for one in (before, after))
    # squared stretches are the eigenvalues of G⁻¹ C, of which trace and determinant are enough
    determinant = np.maximum(np.linalg.det(G), 1e-60)
    trace = (
        G[:, 1, 1] * C[:, 0, 0] - 2.0 * G[:, 0, 1] * C[:, 0, 1] + G[:, 0, 0] * C[:, 1, 1]
    ) / determinant
    half, product = 0.5 * trace, np.maximum(np.linalg.det(C), 0.0) / determinant
    root = np.sqrt(np.maximum(half * half - product, 0.0))
    stretches = np.sqrt(np.maximum([half - root, half + root], 0.0))
    found: Array = np.abs(stretches - 1.0).max(axis=0)
    return found


def strain_bar(end: float) -> str:
    """The bar that explains the colours, as HTML."""
    colours = ",".join("rgb({},{},{})".format(*one) for one in COLOURS)
    bar = f'<div style="height:10px;border-radius:3px;background:linear-gradient(90deg,{colours})"></div>'
    ends = f"<span>0</span><span>strain of the skin</span><span>{100.0 * end:g} %</span>"
    return (
        f'<div style="margin:3px 12px;font-size:12px">{bar}'
        f'<div style="display:flex;justify-content:space-between">{ends}</div></div>'
    )


def _edges(vertices: Floats, triangles: Ints) -> Array:
    corners = vertices[triangles].astype(float)  # (t, 3, 3)
    return np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
