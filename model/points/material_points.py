"""Material points: points fixed in the elements, given by their rest positions."""

from __future__ import annotations

import numpy as np

from tauten.model.mesh import FACES, TetMesh, distances_to_triangles
from tauten.model.numerics import Array, Bools
from tauten.model.points.nodes import NodePoints, combinations
from tauten.model.schema import Extrapolation

OVERLAP = 1e-6  # weight; a point with smaller ones may lie in two elements by rounding
# Weight; a point with none below −OUTSIDE is outside by the rounding of its file at most.
OUTSIDE = 2e-8


def attach(
    mesh: TetMesh,
    points: Array,
    what: str,
    max_outside: float = 0.0,
    extrapolate_from: Extrapolation = "face",
    of_beams: Bools | None = None,
) -> NodePoints:
    """Attach rest positions to the elements that contain them.

    Where elements overlap, a point belongs to the one in which its smallest weight is largest, as in SOFA.

    Args:
        mesh: the body.
        points: (p, 3) rest positions [m].
        what: how to name the points in an error, e.g. "finger.toml: cables.0.points".
        max_outside: how far outside the body a point may lie [m]; its weights then extrapolate.
        extrapolate_from: the element with the nearest face, or with the nearest centre.
        of_beams: (e,) which tetrahedra stand for the nodes of beams: their first corners, each with a ball
            around it through the others; by default none.

    Raises:
        ValueError: a point lies further outside the body than max_outside.
    """
    corners = mesh.nodes[mesh.tets]  # (e, 4, 3)
    centres = corners.mean(axis=1)  # (e, 3)
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))  # (e, 3, 3)
    height = 1.0 / np.linalg.norm(inverse, axis=2)  # (e, 3), over the faces of corners 1..3
    height0 = 1.0 / np.linalg.norm(inverse.sum(axis=1), axis=1)  # (e,)
    heights = np.concatenate([height0[:, None], height], axis=1)  # (e, 4)
    rounding = 1e-9 * mesh.size
    beams = np.zeros(len(corners), bool) if of_beams is None else of_beams
    radius = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)  # (e,), of beams
    nodes, weights = [], []
    for index, point in enumerate(points):
        w = np.einsum("eij,ej->ei", inverse, point - corners[:, 0])  # (e, 3)
        w = np.concatenate([1.0 - w.sum(axis=1, keepdims=True), w], axis=1)  # (e, 4)
        depth = np.where(beams, -np.inf, w.min(axis=1))  # (e,)
        e, outside = int(depth.argmax()), 0.0
        if depth[e] <= OVERLAP:
            beyond = np.maximum(-w * heights, 0.0).max(axis=1)  # (e,) distance to the worst face
            e, outside = nearest_element(point, corners, np.where(beams, np.inf, beyond), rounding)
            away = np.linalg.norm(point - corners[:, 0], axis=1) - radius  # (e,)
            away = np.where(beams, away, np.inf)
            if outside > rounding and away.min() < outside:
                e, outside = int(away.argmin()), float(away.min())
        if outside > max(max_outside, rounding):
            raise ValueError(
                f"{what}: point {index} at {np.round(point, 6).tolist()} m lies "
                f"{outside:.2g} m outside the mesh, allowed is {max_outside:g} m: move it into the "
                "body, or set max_outside, within which the nearest element moves a point"
            )
        if extrapolate_from == "centre" and depth.max() < -OUTSIDE:
            e = int(np.linalg.norm(centres - point, axis=1).argmin())
        nodes.append(mesh.tets[e])
        weights.append(w[e])
    return combinations(
        np.array(nodes, dtype=np.int64).reshape(-1, 4), np.array(weights).reshape(-1, 4)
    )


def nearest_element(
    point: Array, corners: Array, least: Array, rounding: float
) -> tuple[int, float]:
    """The element nearest to a point, and its distance [m]; of equally near ones the first.

    Args:
        point: (3,) [m].
        corners: (e, 4, 3) of the elements [m].
        least: (e,) lower bounds of the distances, zero of elements that contain the point [m].
        rounding: differences of distances that count as none [m].
    """
    nearest, distance = 0, np.inf
    for e in np.argsort(least, kind="stable"):
        if least[e] > distance - rounding:
            break
        away = 0.0
        if least[e] > 0.0:
            away = float(distances_to_triangles(point[None], corners[e][FACES])[0])
        if away < distance - rounding:
            nearest, distance = int(e), away
    return nearest, distance
