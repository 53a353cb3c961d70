"""The manipulator's beams, vertebrae and surfaces as the content of its file of beams.

An arm of printed plastic hangs along −z from its base at z = 0. Its spine is a tube
with a thin round disc, a vertebra, every 53 mm. Below each vertebra six ribs leave the spine,
first outward, then down, and end in a foot just above the next vertebra. Where the arm bends, the feet
on the inner side touch that disc, the ribs deform and stiffen the joint. Three sections of five
joints have three tendons each, 120° apart, which run through holes in every vertebra from the base on.

The tube and the ribs are beams; discs and feet are rigid surfaces on their nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tauten.model.numerics import Array, Ints


@dataclass(frozen=True, slots=True)
class ArmShape:
    """Dimensions [m] of the arm.

    Attributes:
        length: from the base to the last vertebra.
        sections: groups of joints; each has its tendons.
        joints: per section.
        disc_radius: of a vertebra.
        disc_thickness: of a vertebra.
        tendon_radius: distance of the holes from the spine.
        ribs: below each vertebra.
        rib_radius: where a rib turns down.
        rib_root: how far below its vertebra a rib leaves the spine.
        gap: between the middle of a foot and the next vertebra.
        foot: radial and tangential size of a foot.
        landing_deg: a foot is slanted so that it is parallel to the disc at this angle of the joint.
        tool: distance of the effector from the last vertebra.
    """

    length: float = 0.8
    sections: int = 3
    joints: int = 5
    disc_radius: float = 0.050
    disc_thickness: float = 0.0025
    tendon_radius: float = 0.028
    ribs: int = 6
    rib_radius: float = 0.042
    rib_root: float = 0.008
    gap: float = 0.005
    foot: tuple[float, float] = (0.012, 0.014)
    landing_deg: float = 8.0
    tool: float = 0.020

    @property
    def pitch(self) -> float:
        """Distance of two vertebrae."""
        return self.length / (self.sections * self.joints)

    @property
    def count(self) -> int:
        """Joints of the whole arm."""
        return self.sections * self.joints


def tendon_angle(shape: ArmShape, section: int, k: int) -> float:
    """Where tendon k of three of a section, the first being 0, runs: angle from x [rad].

    Args:
        shape: of the arm.
        section: number of the section, from 0.
        k: number of the tendon in its section, 0 to 2.
    """
    return 2.0 * np.pi / 3.0 * (k + section / shape.sections)


def bending_tensions(shape: ArmShape, angles: Array, forces: Array) -> Array:
    """Tensions that bend each section towards an angle, by the two tendons beside it.

    Args:
        shape: of the arm.
        angles: (sections,) directions from x [rad].
        forces: (sections,) tension of a tendon that pulls just there, resultant of two beside it [N].

    Returns:
        (3 sections,) [N].
    """
    tension = np.zeros(3 * shape.sections)
    for section, (angle, force) in enumerate(zip(angles, forces, strict=True)):
        away = (angle - tendon_angle(shape, section, 0)) % (2.0 * np.pi)
        first, beyond = divmod(away, 2.0 * np.pi / 3.0)
        k = 3 * section + int(first) % 3
        after = 3 * section + (int(first) + 1) % 3
        # sine rule in the triangle of the two tensions and their resultant
        tension[k] = force * np.sin(2.0 * np.pi / 3.0 - beyond) / np.sin(np.pi / 3.0)
        tension[after] = force * np.sin(beyond) / np.sin(np.pi / 3.0)
    return tension


def make_network(shape: ArmShape) -> dict[str, Any]:
    """The content of the file of beams."""
    nodes: list[list[float]] = [[0.0, 0.0, 0.0]]
    beams: list[dict[str, Any]] = []
    vertebrae = [vertebra(shape, 0, 0)]
    surfaces = []

    def node(position: Array) -> int:
        nodes.append([round(float(value), 7) for value in position])
        return len(nodes) - 1

    def beam(a: int, b: int, profile: str, up: Array) -> None:
        rounded = [round(float(value), 7) for value in up]
        beams.append({"ends": [a, b], "profile": profile, "up": rounded})

    x, z, joint = np.eye(3)[0], np.eye(3)[2], 0
    for i in range(shape.count):
        top = -i * shape.pitch
        root = node(np.array([0.0, 0.0, top - shape.rib_root]))
        beam(joint, root, "spine", x)
        feet = []
        for k in range(shape.ribs):
            out = direction(2.0 * np.pi * k / shape.ribs)
            elbow = node(out * shape.rib_radius + (top - shape.rib_root) * z)
            sole = top - shape.pitch + 0.5 * shape.disc_thickness + shape.gap
            foot = node(out * shape.rib_radius + sole * z)
            beam(root, elbow, "rib", z)
            beam(elbow, foot, "rib", out)
            feet.append(foot_surface(shape, np.array(nodes[foot]), out, foot))
        surfaces.append(joined(f"feet{i + 1}", feet))
        joint = node(np.array([0.0, 0.0, top - shape.pitch]))
        beam(root, joint, "spine", x)
        vertebrae.append(vertebra(shape, i + 1, joint))
        surfaces.append(disc_surface(shape, f"disc{i + 1}", np.array(nodes[joint]), joint, 1.0))
        surfaces.append(disc_surface(shape, f"under{i + 1}", np.array(nodes[joint]), joint, -1.0))
    surfaces.append(disc_surface(shape, "base", np.zeros(3), 0, -1.0))
    return {"nodes": nodes, "beams": beams, "discs": vertebrae, "surfaces": surfaces}


def direction(angle: float) -> Array:
    """Unit vector across the arm at an angle [rad] from x: (3,)."""
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def vertebra(shape: ArmShape, number: int, node: int) -> dict[str, Any]:
    """A disc of the file of beams.

    Args:
        shape: of the arm.
        number: of the disc, for its name.
        node: beam node at its centre.
    """
    return {
        "name": f"vertebra{number}",
        "node": node,
        "radius": shape.disc_radius,
        "thickness": shape.disc_thickness,
    }


def foot_surface(shape: ArmShape, centre: Array, out: Array, node: int) -> tuple[Array, Ints, int]:
    """MaterialPoints (9, 3) and triangles (8, 3) of a sole that looks down, and its node.

    Args:
        shape: of the arm.
        centre: (3,) centre of the sole [m].
        out: (3,) unit vector from the axis outward.
        node: beam node that carries it.
    """
    across = np.array([-out[1], out[0], 0.0])
    slope = np.tan(np.radians(shape.landing_deg))
    steps = np.array([-0.5, 0.0, 0.5])
    points = np.array(
        [
            centre + r * (out + slope * np.eye(3)[2]) + t * across
            for r in steps * shape.foot[0]
            for t in steps * shape.foot[1]
        ]
    )
    return points, grid_triangles(3, 3)[:, ::-1], node


def grid_triangles(rows: int, columns: int) -> Ints:
    """Two triangles for each cell of a grid of points, row by row: counter-clockwise from above
    when rows go along x and columns along y.
    """
    cells = [(i, j) for i in range(rows - 1) for j in range(columns - 1)]
    triangles = []
    for i, j in cells:
        a = i * columns + j
        b, c, d = a + columns, a + columns + 1, a + 1
        triangles += [[a, b, c], [a, c, d]]
    return np.array(triangles)


def disc_surface(
    shape: ArmShape, name: str, centre: Array, node: int, side: float
) -> dict[str, Any]:
    """Upper (side 1) or lower (side −1) face of a vertebra, without the part near the spine.

    Args:
        shape: of the arm.
        name: of the surface.
        centre: (3,) of the disc [m].
        node: of the disc.
        side: 1 or −1.
    """
    sectors = 24
    radii = np.array([0.4, 0.7, 1.0]) * shape.disc_radius
    height = 0.5 * side * shape.disc_thickness * np.eye(3)[2]
    angles = 2.0 * np.pi * np.arange(sectors) / sectors
    points = np.array([centre + height + r * direction(a) for r in radii for a in angles])
    triangles = []
    for ring in range(len(radii) - 1):
        for k in range(sectors):
            a, b = ring * sectors + k, ring * sectors + (k + 1) % sectors
            triangles += [[a, a + sectors, b + sectors], [a, b + sectors, b]]
    corners = np.array(triangles) if side > 0.0 else np.array(triangles)[:, ::-1]
    return surface(name, points, corners, [node] * len(points))


def joined(name: str, parts: list[tuple[Array, Ints, int]]) -> dict[str, Any]:
    """One surface of several, each fixed to its node."""
    points, triangles = [], []
    nodes: list[int] = []
    for part, corners, node in parts:
        triangles.append(corners + len(nodes))
        points.append(part)
        nodes += [node] * len(part)
    return surface(name, np.concatenate(points), np.concatenate(triangles), nodes)


def surface(name: str, points: Array, triangles: Ints, nodes: list[int]) -> dict[str, Any]:
    """A surface of the file of beams.

    Args:
        name: of the surface.
        points: (m, 3) [m].
        triangles: (f, 3) point numbers.
        nodes: beam node of each point.
    """
    rounded = np.round(points, 7) + 0.0  # no negative zeros
    return {
        "name": name,
        "nodes": nodes,
        "points": rounded.tolist(),
        "triangles": triangles.tolist(),
    }
