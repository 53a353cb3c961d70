"""Material points: points fixed in the elements, given by their rest positions."""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.points.nodes import NodePoints, combinations
from tauten.model.schema import Extrapolation

OVERLAP = 1e-6  # weight; a point with smaller ones may lie in two elements by rounding
OUTSIDE = (
    2e-8  # weight; a point with none below −OUTSIDE is outside by the rounding of its file at most
)


def attach(
    mesh: TetMesh,
    points: Array,
    what: str,
    max_outside: float = 0.0,
    extrapolate_from: Extrapolation = "face",
) -> NodePoints:
    """Attach rest positions to the elements that contain them.

    Where elements overlap, a point belongs to the one in which its smallest weight is largest, as in SOFA.

    Args:
        mesh: the body.
        points: (p, 3) rest positions [m].
        what: how to name the points in an error, e.g. "finger.toml: cables.0.points".
        max_outside: how far outside the body a point may lie [m]; its weights then extrapolate.
        extrapolate_from: the element with the nearest face, or with the nearest centre.

    Raises:
        ValueError: a point lies further outside the body than max_outside.
    """
    corners = mesh.nodes[mesh.tets]  # (e, 4, 3)
    centres = corners.mean(axis=1)  # (e, 3)
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))  # (e, 3, 3)
    height = 1.0 / np.linalg.norm(inverse, axis=2)  # (e, 3), over the faces of corners 1..3
    height0 = 1.0 / np.linalg.norm(inverse.sum(axis=1), axis=1)  # (e,)
    heights = np.concatenate([height0[:, None], height], axis=1)  # (e, 4)
    tolerance = max(max_outside, 1e-9 * mesh.size)
    nodes, weights = [], []
    for index, point in enumerate(points):
        w = np.einsum("eij,ej->ei", inverse, point - corners[:, 0])  # (e, 3)
        w = np.concatenate([1.0 - w.sum(axis=1, keepdims=True), w], axis=1)  # (e, 4)
        outside = np.maximum(-w * heights, 0.0).max(axis=1)  # (e,) distance to the worst face
        e = int(outside.argmin())
        depth = w.min(axis=1)  # (e,)
        if depth.max() > OVERLAP:
            e = int(depth.argmax())
        if outside[e] > tolerance:
            raise ValueError(
                f"{what}: point {index} at {np.round(point, 6).tolist()} m lies at least "
                f"{outside[e]:.2g} m outside the mesh, allowed is {max_outside:g} m: move it into the "
                "body, or set max_outside, within which the nearest element moves a point"
            )
        if extrapolate_from == "centre" and depth.max() < -OUTSIDE:
            e = int(np.linalg.norm(centres - point, axis=1).argmin())
        nodes.append(mesh.tets[e])
        weights.append(w[e])
    return combinations(
        np.array(nodes, dtype=np.int64).reshape(-1, 4), np.array(weights).reshape(-1, 4)
    )
