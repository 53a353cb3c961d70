"""Guesses of what a mesh does not say: where it is held, what moves it, what is to reach targets.

They make a robot file that loads and moves; its comments ask the user to correct them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model.actuators import cavities, enclosed_volume, winding
from tauten.model.mesh import TetMesh, boundary_triangles, triangle_areas
from tauten.model.numerics import Array, Ints
from tauten.service.new.side_cable import Axes, side_cable

END = 0.02  # of the length; triangles so near an end belong to it
# of the smallest node spacing at the held end; half the thickness of the box that holds it
SLAB = 0.5
HANGS = 0.9  # the upper end is held unless the lower one is larger by more than this
PULL = 0.1  # of the length
LEAST_CAVITY = 0.01  # of the body's volume; a smaller one is a bubble, not a chamber


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
        held: (2, 3) corners of the box whose nodes are held [m].
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
    cable: Array
    pull_point: Array
    span: float
    effector: Array
    outside: float
    max_pull: float
    length: float
    cavities: tuple[Cavity, ...] = ()


def guess_fields(mesh: TetMesh, chambers: bool = True) -> Guess:
    """Hold the larger end of the longest axis, pull along a side or inflate cavities, move the other end."""
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    axis = int(np.argmax(high - low))
    length = float(high[axis] - low[axis])
    triangles = boundary_triangles(mesh.tets)
    areas = triangle_areas(mesh.nodes, triangles)
    centres = mesh.nodes[triangles].mean(axis=1)[:, axis]
    at_low, at_high = centres < low[axis] + END * length, centres > high[axis] - END * length
    hold_high = float(areas[at_high].sum()) >= HANGS * float(areas[at_low].sum())
    held_at, free = (high[axis], at_low) if hold_high else (low[axis], at_high)
    corners = np.stack([low, high]) + 1e-3 * length * np.array([[-1.0], [1.0]])
    thickness = END * length * SLAB
    corners[:, axis] = (held_at - thickness, held_at + thickness)
    weights = areas[free] / areas[free].sum()
    effector = weights @ mesh.nodes[triangles[free]].mean(axis=1)
    cable = side_cable(mesh, Axes(axis, low, high, hold_high))
    leaves = cable[0].copy()
    leaves[axis] = held_at + (END if hold_high else -END) * length
    return Guess(
        corners, cable, leaves,
        span=abs(float(cable[-1, axis] - held_at)) / length,
        effector=effector,
        outside=0.01 * length,
        max_pull=PULL * length,
        length=length,
        cavities=found_cavities(mesh, triangles) if chambers else (),
    )  # fmt: skip


def found_cavities(mesh: TetMesh, triangles: Ints) -> tuple[Cavity, ...]:
    """The closed cavities of a body that are large enough for a chamber, the largest first.

    Args:
        mesh: the body.
        triangles: (t, 3) its boundary, normals out of the material.
    """
    least, found = LEAST_CAVITY * float(mesh.volumes.sum()), []
    for part in cavities(mesh.nodes, triangles):
        volume = -enclosed_volume(mesh.nodes, part)
        if volume > least:
            found.append(Cavity(point_inside(mesh.nodes, part), volume))
    return tuple(sorted(found, key=lambda one: -one.volume))


def point_inside(x: Array, part: Ints) -> Array:
    """A point (3,) in a cavity, far from its wall where its middle is within [m].

    Args:
        x: (n_nodes, 3) node positions [m].
        part: (t, 3) triangles of its wall, normals out of the material.
    """
    areas, centres = triangle_areas(x, part), x[part].mean(axis=1)
    middle: Array = areas @ centres / areas.sum()
    if abs(winding(x, part, middle)) > 0.5:
        return middle
    largest = int(np.argmax(areas))
    a, b, c = x[part[largest]]
    normal = np.cross(b - a, c - a) / (2.0 * areas[largest])
    depth = np.sqrt(areas[largest])
    while depth > 0.0:
        point: Array = centres[largest] + depth * normal
        if abs(winding(x, part, point)) > 0.5:
            return point
        depth *= 0.5
    return middle
