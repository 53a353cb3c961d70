"""Bodies that are beams: their nodes as frames, their elements and masses.

A node of a beam has a position and a rotation. In the mesh of the robot it is a rigid tetrahedron without
material: the node itself and three corners beside it, along the axes of the body. Points and nodes that are
attached to a beam are attached to such tetrahedra. Where the robot touches something a ring of nodes around
the beam's node moves with it too; between these rings lie the triangles of the beam's surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from tauten.model.beams import (
    BeamArrays,
    BeamError,
    Beams,
    Profile,
    bar,
    chain_surface,
    make_beams,
    outline,
    section,
    tube,
)
from tauten.model.body import Material
from tauten.model.constraints import FrameJoints
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Ints
from tauten.model.points import attach_to_nodes, join_attached_points
from tauten.model.schema import (
    AnyProfile,
    BodySettings,
    PartRobotConfig,
    RobotConfig,
    RobotFileError,
    SectionSettings,
    TubeSettings,
)
from tauten.model.tetra import BodyParts

CORNERS = 4  # of the tetrahedron of a beam's node, which is the first of them


@dataclass(frozen=True, slots=True)
class BeamPart:
    """A body that is a beam, in the mesh of its robot.

    Attributes:
        name: of the body.
        nodes: (b,) its nodes in the whole mesh; the corners of each follow it.
        rings: (b, c) nodes of its surface around each; c = 0 where the robot touches nothing.
        triangles: (t, 3) of the surface, of nodes of the whole mesh.
        body: elements and masses.
        profile: its cross-section.
    """

    name: str
    nodes: Ints
    rings: Ints
    triangles: Ints
    body: Beams
    profile: Profile

    def moved(self, first: int) -> BeamPart:
        """The same where the first node of the body has another number in the whole mesh."""
        return replace(
            self,
            nodes=self.nodes + first,
            rings=self.rings + first,
            triangles=self.triangles + first,
        )


def profile_of(settings: AnyProfile, material: Material) -> Profile:
    """The cross-section of a table of `profiles`.

    Args:
        settings: the table.
        material: of the beam, by which given stiffnesses are divided.
    """
    if isinstance(settings, SectionSettings):
        return section(settings, material)
    if isinstance(settings, TubeSettings):
        return tube(settings.outer, settings.inner)
    return bar(settings.width, settings.height)


def material_of(body: BodySettings) -> Material:
    """The material of a body."""
    assert body.material is not None
    item = body.material
    return Material(item.young_modulus, item.poisson_ratio, item.density)


def own_profile(config: RobotConfig, body: BodySettings) -> Profile:
    """The cross-section of a body that is a beam."""
    assert body.beam is not None
    by_name = {item.name: item for item in config.profiles}
    return profile_of(by_name[body.beam.profile], material_of(body))


def beam_mesh(config: RobotConfig, body: BodySettings, refinements: int = 0) -> TetMesh:
    """The tetrahedra of a beam's nodes in the body's own coordinates.

    Args:
        config: the robot file, with the cross-sections.
        body: the body; its material may be that of the file.
        refinements: how often every element is halved.
    """
    assert body.beam is not None
    settings = body if body.material else body.model_copy(update={"material": config.material})
    arm = float(np.linalg.norm(own_profile(config, settings).outline, axis=1).max())
    corners = np.array(body.beam.points)
    count = body.beam.elements * 2**refinements
    share = np.arange(count)[:, None] / count
    pieces = [a + share * (b - a) for a, b in pairwise(corners)]
    axis = np.concatenate([*pieces, corners[-1:]])  # (b, 3)
    beside = np.concatenate([np.zeros((1, 3)), arm * np.eye(3)])  # (4, 3)
    nodes = (axis[:, None] + beside).reshape(-1, 3)
    return TetMesh(nodes, np.arange(len(nodes)).reshape(-1, CORNERS))


def build_beam(
    config: RobotConfig, body: BodySettings, mesh: TetMesh, source: str, prefix: str
) -> tuple[BodyParts, BeamPart]:
    """A beam: its nodes with their masses, without tetrahedra that deform; nodes are numbered from zero.

    The nodes of its surface come after those of `mesh`.

    Args:
        config: the robot file.
        body: the body, with its material.
        mesh: from `beam_mesh`, where the body stands.
        source: the robot file's path, for errors.
        prefix: of the table's fields, for errors.

    Raises:
        RobotFileError: a beam without length, one that lies along `up`, or one that is viscous or
            hyperelastic.
    """
    assert body.beam is not None and body.material is not None
    if body.material.viscosity is not None:
        raise RobotFileError(
            f"{source}: {prefix}material: a beam is elastic, give it a material without viscosity"
        )
    if body.material.law != "corotational":
        raise RobotFileError(
            f"{source}: {prefix}material.law: a cross-section is linear elastic, give the beam a material "
            "with the law corotational"
        )
    profile = own_profile(config, body)
    axis = mesh.nodes[::CORNERS]  # (b, 3)
    count = len(axis) - 1
    ends = np.stack([np.arange(count), np.arange(count) + 1], axis=1)
    along = np.abs(np.diff(axis, axis=0))
    up = np.eye(3)[
        2 - along[:, ::-1].argmin(axis=1)
    ]  # z where a beam lies across it as well as others
    if body.beam.up is not None:
        arms = mesh.nodes[1:CORNERS] - mesh.nodes[0]  # rows along the body's own axes
        turn = arms / np.linalg.norm(arms, axis=1, keepdims=True)
        up = np.tile(np.array(body.beam.up) @ turn, (count, 1))
    try:
        made = make_beams(axis, ends, up, [profile] * count, material_of(body))
    except BeamError as error:
        raise RobotFileError(f"{source}: {prefix}beam: {error}") from error
    if body.material.total_mass is not None:
        share = body.material.total_mass / made.mass.sum()
        made = replace(made, mass=share * made.mass, inertia=share * made.inertia)
    nodes = CORNERS * np.arange(count + 1)
    around, triangles = np.zeros((count + 1, 0, 3)), np.zeros((0, 3), np.int64)
    if has_surface(config):
        around, triangles = chain_surface(made, profile)
    rings = len(mesh.nodes) + np.arange(around[..., 0].size).reshape(around.shape[:2])  # (b, c)
    every = np.concatenate([nodes, rings.ravel()])  # as `chain_surface` numbers them
    whole = replace(mesh, nodes=np.concatenate([mesh.nodes, around.reshape(-1, 3)]))
    mass = np.zeros(len(whole.nodes))
    mass[nodes] = made.mass
    part = BeamPart(body.name, nodes, rings, every[triangles], made, profile)
    return BodyParts(whole, [], [], mass, count, []), part


def has_surface(config: RobotConfig) -> bool:
    """Whether beams have a surface: something may touch the robot, or it is a part of another."""
    return bool(config.contacts or config.surfaces) or isinstance(config, PartRobotConfig)


def beam_joints(beams: list[BeamPart], turning: Ints, springs: sp.csr_array) -> FrameJoints | None:
    """All beams of a robot, and its springs; None: it has neither.

    Args:
        beams: the bodies that are beams.
        turning: (n_nodes,) region that each node of the robot moves with, −1: none.
        springs: see `FrameJoints`.
    """
    if not beams and springs.shape[0] == 0:
        return None
    first, ends, drawn, triangles, count = 0, [np.zeros((0, 2), np.int64)], [], [], 0
    corners = [np.zeros((0, 3), np.int64)]
    for part in beams:
        for k in range(len(part.body.ends)):
            points, faces = outline(part.body, k, part.profile)
            drawn.append(replace(points, nodes=points.nodes + first))
            triangles.append(faces + count)
            count += len(points)
        ends.append(part.body.ends + first)
        first += len(part.nodes)
    none = attach_to_nodes(np.zeros((0, 3)), np.zeros(0, dtype=np.int64), np.zeros((0, 3)))
    nodes = np.concatenate([np.zeros(0, np.int64), *(part.nodes for part in beams)])
    bodies = [part.body for part in beams]
    arrays = BeamArrays(
        np.concatenate(ends),
        np.concatenate([np.zeros((0, 4)), *(body.axes for body in bodies)]),
        np.concatenate([np.zeros((0, 6)), *(body.D for body in bodies)]),
        np.concatenate([np.zeros(0), *(body.length for body in bodies)]),
    )
    return FrameJoints(
        nodes=nodes,
        turning=turning[nodes],
        beams=arrays,
        inertia=np.concatenate([np.zeros(0), *(body.inertia for body in bodies)]),
        outline=join_attached_points(drawn) if drawn else none,
        triangles=np.concatenate([*corners, *triangles]),
        springs=springs,
    )
