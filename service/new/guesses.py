"""Guesses of what a mesh does not say: where it is held, what moves it, what is to reach targets.

They make a robot file that loads and moves; its comments ask the user to correct them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from scipy.spatial import ConvexHull

from tauten.model.actuators import cavities, connected_parts, enclosed_volume, open_edges, winding
from tauten.model.contact import across
from tauten.model.mesh import (
    TetMesh,
    area_normals,
    boundary_triangles,
    distances_to_triangles,
    off_a_line,
    triangle_areas,
    unit_normals,
)
from tauten.model.numerics import Array, Ints
from tauten.service.new.side_cable import Axes, in_mesh, side_cable

END = 0.02  # of the length; triangles so near an end belong to it
SLAB = 0.01  # of the length; how far below an end its nodes are held, at least
THICKER = 1.5  # factor to the next depth, where that holds no three nodes off a line
HANGS = 0.9  # the upper end is held unless the lower one is larger by more than this
PULL = 0.1  # of the length
OUTSIDE = 0.01  # of the length; how far outside of a mesh of the part guessed points may lie
ROUNDED = 2e-5  # m; how far below an oblique end its point lies: coordinates are written to 1e-5 m
LEAST_CAVITY = 0.01  # of the body's volume; a smaller one is a bubble, not a chamber
FACES = 24  # flat faces that are looked at, the largest ones
LEAST_FACE = 0.005  # of the part's surface
ONE_FACE = 1e-3  # components of unit normals that are so near belong to one face
SMALLER = 0.8  # an outline along an oblique axis that is smaller by this is taken
SQUARE = 0.02  # cosine of the angle between normals of faces that are perpendicular


@dataclass(frozen=True, slots=True)
class Cavity:
    """A closed cavity of the body.

    Attributes:
        inside: (3,) a point in it [m].
        volume: [m³].
    """

    inside: Array
    volume: float


@dataclass(frozen=True, slots=True)
class Guess:
    """Guessed fields of a robot file.

    Attributes:
        held: (3,) a point of the plane behind which nodes are held [m].
        outward: (3,) unit normal of this plane, out of the body at the end that is held.
        cable: (p, 3) points of one cable [m]; used where there are no cavities.
        pull_point: (3,) where it leaves the body [m].
        span: share of the body's length that the cable reaches over, from where it leaves the body.
        effector: (3,) [m].
        outside: how far outside of a mesh of the part the points may lie [m].
        max_pull: [m].
        length: of the body [m].
        cavities: closed cavities that become chambers, the largest first.
    """

    held: Array
    outward: Array
    cable: Array
    pull_point: Array
    span: float
    effector: Array
    outside: float
    max_pull: float
    length: float
    cavities: tuple[Cavity, ...] = ()


def guess_fields(meshes: Sequence[TetMesh], chambers: bool = True) -> Guess:
    """Hold the larger end of the longest axis, pull along a side or inflate cavities, move the other end.

    Of the meshes of a part the last is looked at, and all are held. Closed cavities may become chambers.
    """
    turn = part_axes(meshes[-1])
    turned = [replace(mesh, nodes=mesh.nodes @ turn.T) for mesh in meshes]
    guess = guess_along(turned, chambers)
    cavities = tuple(replace(one, inside=one.inside @ turn) for one in guess.cavities)
    below = 0.0 if (turn == np.eye(3)).all() else ROUNDED
    effector = guess.effector + below * guess.outward
    return replace(
        guess, held=guess.held @ turn, outward=guess.outward @ turn, cable=guess.cable @ turn,
        pull_point=guess.pull_point @ turn, effector=effector @ turn, cavities=cavities,
    )  # fmt: skip


def guess_along(meshes: Sequence[TetMesh], chambers: bool) -> Guess:
    """The guess of `guess_fields` for a part whose directions are those of its coordinates."""
    mesh = meshes[-1]
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    axis = int(np.argmax(high - low))
    length = float(high[axis] - low[axis])
    triangles = boundary_triangles(mesh.tets)
    areas = triangle_areas(mesh.nodes, triangles)
    centres = mesh.nodes[triangles].mean(axis=1)[:, axis]
    at_low, at_high = centres < low[axis] + END * length, centres > high[axis] - END * length
    hold_high = float(areas[at_high].sum()) >= HANGS * float(areas[at_low].sum())
    held_at, free = (high[axis], at_low) if hold_high else (low[axis], at_high)
    if not free.any():  # a pointed end
        along = mesh.nodes[triangles][..., axis].sum(axis=1)
        free = along == (along.min() if hold_high else along.max())
    outward = (1.0 if hold_high else -1.0) * np.eye(3)[axis]
    held = 0.5 * (low + high)
    held[axis] = held_at
    cable = side_cable(mesh, Axes(axis, low, high, hold_high))
    leaves = cable[0].copy()
    leaves[axis] = held_at + (END if hold_high else -END) * length
    return Guess(
        held - held_depth(meshes, held, outward) * outward, outward, cable, leaves,
        span=abs(float(cable[-1, axis] - held_at)) / length,
        effector=point_of_end(mesh, triangles[free], OUTSIDE * length),
        outside=OUTSIDE * length,
        max_pull=PULL * length,
        length=length,
        cavities=found_cavities(mesh, triangles) if chambers else (),
    )  # fmt: skip


def held_depth(meshes: Sequence[TetMesh], end: Array, outward: Array) -> float:
    """How far below an end nodes are held, such that three of every mesh that are not on a line are [m].

    Args:
        meshes: of the part.
        end: (3,) a point of the plane through the end [m].
        outward: (3,) its unit normal, out of the body.
    """
    length = max(mesh.size for mesh in meshes)
    depth = SLAB * float(np.ptp(meshes[-1].nodes @ outward))
    while depth < length and not all(
        holds(mesh, end - depth * outward, outward) for mesh in meshes
    ):
        depth *= THICKER
    return depth


def holds(mesh: TetMesh, point: Array, outward: Array) -> bool:
    """Whether three nodes of a mesh that are not on a line lie beyond a plane.

    Args:
        mesh: of the part.
        point: (3,) of the plane [m].
        outward: (3,) normal of the plane, to the side that is looked at.
    """
    beyond = (mesh.nodes - point) @ outward >= 0.0
    return off_a_line(mesh.nodes[beyond], 1e-3 * mesh.size)


def point_of_end(mesh: TetMesh, triangles: Ints, outside: float) -> Array:
    """A point (3,) of an end of a body: its middle, else that of its largest part, else near that [m].

    The end of a tube is a ring, and a body with legs has several ends: their middle is not in the body.

    Args:
        mesh: the body.
        triangles: (t, 3) of the boundary at this end.
        outside: how far outside of the mesh the point may lie [m].
    """
    parts = connected_parts(triangles)
    largest = max(parts, key=lambda part: float(triangle_areas(mesh.nodes, part).sum()))
    for part in (triangles, largest):
        areas, corners = triangle_areas(mesh.nodes, part), mesh.nodes[part]  # (t,), (t, 3, 3)
        middle: Array = areas @ corners.mean(axis=1) / areas.sum()
        near = distances_to_triangles(middle[None], corners)[0] <= 0.5 * outside
        if near or in_mesh(mesh, middle[None])[0]:
            return middle
    centres = mesh.nodes[largest].mean(axis=1)
    nearest: Array = centres[np.linalg.norm(centres - middle, axis=1).argmin()]
    return nearest


def found_cavities(mesh: TetMesh, triangles: Ints) -> tuple[Cavity, ...]:
    """The closed cavities of a body that are large enough for a chamber, the largest first.

    They are found by the triangles (t, 3) of its boundary, normals out of the material.
    """
    least, found = LEAST_CAVITY * float(mesh.volumes.sum()), []
    for part in cavities(mesh.nodes, triangles):
        volume = -enclosed_volume(mesh.nodes, part)
        # walls that touch along an edge are no surface
        if volume > least and not len(open_edges(part)):
            found.append(Cavity(point_inside(mesh.nodes, part), volume))
    return tuple(sorted(found, key=lambda one: -one.volume))


def point_inside(x: Array, part: Ints) -> Array:
    """A point (3,) in a cavity, far from its wall where its middle is within [m].

    The wall has triangles (t, 3) of nodes x (n_nodes, 3) [m], normals out of the material.
    """
    areas, centres = triangle_areas(x, part), x[part].mean(axis=1)
    middle: Array = areas @ centres / areas.sum()
    if abs(winding(x, part, middle)) > 0.5:
        return middle
    largest = int(np.argmax(areas))
    normal = unit_normals(x[part[largest : largest + 1]])[0]
    depth = np.sqrt(areas[largest])
    while depth > 0.0:
        point: Array = centres[largest] + depth * normal
        if abs(winding(x, part, point)) > 0.5:
            return point
        depth *= 0.5
    return middle


def part_axes(mesh: TetMesh) -> Array:
    """Three directions of a part as rows, near those of the coordinates: (3, 3).

    They are those of the coordinates, unless the outline of the part, seen along the normal of a flat face,
    is much smaller than along the longest side of its bounding box: this normal is one of them then.
    """
    longest = int(np.argmax(np.ptp(mesh.nodes, axis=0)))
    normals = flat_normals(mesh)
    outlines = [outline(mesh.nodes, normal) for normal in normals]
    limit = SMALLER * outline(mesh.nodes, np.eye(3)[longest])
    if not outlines or min(outlines) > limit:
        return np.eye(3)
    along = normals[int(np.argmin(outlines))]
    sides = normals[np.abs(normals @ along) < SQUARE]
    nearest = np.eye(3)[np.argmin(np.abs(along))]
    side = sides[0] if len(sides) else nearest
    side = side - (side @ along) * along
    side /= np.linalg.norm(side)
    axes = np.stack([along, side, np.cross(along, side)])
    order = max(permutations(range(3)), key=lambda rows: np.abs(axes[list(rows)]).trace())
    ordered: Array = axes[list(order)]
    ordered *= np.sign(ordered.diagonal())[:, None]
    if np.linalg.det(ordered) < 0.0:
        ordered[int(np.argmin(ordered.diagonal()))] *= -1.0
    return ordered


def flat_normals(mesh: TetMesh) -> Array:
    """Unit normals of the large flat faces of a part, up to their sign, the largest first: (f, 3)."""
    normals = area_normals(mesh.nodes[boundary_triangles(mesh.tets)])  # of twice the area
    areas = np.linalg.norm(normals, axis=1)
    biggest = np.take_along_axis(normals, np.abs(normals).argmax(axis=1)[:, None], axis=1)
    normals = normals * np.sign(biggest)  # both sides of a wall alike
    places = np.round(normals / areas[:, None] / ONE_FACE).astype(np.int64)
    _, face = np.unique(places, axis=0, return_inverse=True)
    summed = np.zeros((int(face.max()) + 1, 3))
    np.add.at(summed, face, normals)
    sizes = np.linalg.norm(summed, axis=1)
    order = np.argsort(-sizes)[:FACES]
    order = order[sizes[order] > LEAST_FACE * areas.sum()]
    found: Array = summed[order] / sizes[order, None]
    return found


def outline(nodes: Array, direction: Array) -> float:
    """Area of the convex outline of points (n, 3) seen along a unit vector (3,) [m²]."""
    return float(ConvexHull(nodes @ np.stack(across(direction), axis=1)).volume)
