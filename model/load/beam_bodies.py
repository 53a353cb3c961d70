"""Bodies that are beams: their nodes as frames, their elements and masses.

A node of a beam has a position and a rotation. In the mesh of the robot it is a rigid tetrahedron without
material: the node itself and three corners beside it, along the axes of the body. Points and nodes that are
attached to a beam are attached to such tetrahedra. Points of its surface move with its nodes too: a ring of
them around each node of a line of beams, where the robot touches something, or the points that the file of
a network of beams attaches to its nodes.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TypeAlias

import numpy as np

from tauten.model.beams import (
    BeamError,
    Beams,
    Material,
    Profile,
    bar,
    chain_surface,
    make_beams,
    section,
    tube,
)
from tauten.model.mesh import CellGroup, TetMesh
from tauten.model.numerics import Array, Ints
from tauten.model.parts import Placement
from tauten.model.schema import (
    AnyProfile,
    BeamElement,
    BeamNetwork,
    BodySettings,
    Disc,
    PartRobotConfig,
    RobotConfig,
    RobotFileError,
    SectionSettings,
    SolidMaterialSettings,
    TubeSettings,
    read_text,
    validated,
)
from tauten.model.tetra import BodyParts

# Points (k, 3) [m] that move with nodes of beams, numbers (k,) of these, triangles (t, 3) of nodes of the
# body's mesh, and those that have a name.
_Surface: TypeAlias = tuple[Array, Ints, Ints, tuple[CellGroup, ...]]
CORNERS = 4  # of the tetrahedron of a beam's node, which is the first of them


@dataclass(frozen=True, slots=True)
class BeamPart:
    """A body made of beams, in the mesh of its robot.

    Attributes:
        name: of the body.
        nodes: (b,) its nodes in the whole mesh; the corners of each follow it.
        followers: (k,) nodes of its surface in the whole mesh.
        owners: (k,) number of the node, 0 to b − 1, that each of them moves with.
        points: (k, 3) positions of the followers at rest [m].
        triangles: (t, 3) of the surface, of nodes of the whole mesh.
        shown: whether the surface is drawn beside the outlines of the beams.
        body: elements and masses.
        profiles: cross-section of each element.
        discs: on its nodes, in metres and in the axes of the robot's frame.
        radius: of the largest cross-section [m].
    """

    name: str
    nodes: Ints
    followers: Ints
    owners: Ints
    points: Array
    triangles: Ints
    shown: bool
    body: Beams
    profiles: tuple[Profile, ...]
    discs: tuple[Disc, ...]
    radius: float

    @property
    def first_follower(self) -> int:
        """The first node of its surface in the whole mesh; they come after the corners of its nodes."""
        return int(self.nodes[0]) + CORNERS * len(self.nodes)

    def moved(self, first: int) -> BeamPart:
        """The same where the first node of the body has another number in the whole mesh."""
        return replace(
            self,
            nodes=self.nodes + first,
            followers=self.followers + first,
            triangles=self.triangles + first,
        )


def profile_of(settings: AnyProfile, material: Material) -> Profile:
    """The cross-section of a table of `profiles`."""
    if isinstance(settings, SectionSettings):
        return section(settings, material)
    if isinstance(settings, TubeSettings):
        return tube(settings.outer, settings.inner)
    return bar(settings.width, settings.height)


def beam_network(
    config: RobotConfig, body: BodySettings, source: str = "robot.toml", refinements: int = 0
) -> BeamNetwork:
    """Nodes and beams of a body in its coordinates, halved as often as refined, before they are scaled.

    Raises:
        RobotFileError: a file that cannot be used, or a cross-section that the robot file has not.
    """
    assert body.beam is not None
    if body.beam.file is None:
        return chain_of(body, 2**refinements)
    path = Path(source).parent / body.beam.file
    network = validated(BeamNetwork, read_text(path, json.loads, "JSON"), path)
    known = {profile.name for profile in config.profiles}
    for index, beam in enumerate(network.beams):
        if beam.profile not in known:
            raise RobotFileError(
                f"{path}: beams.{index}: profile {beam.profile!r} is not one of profiles of the robot file, "
                f"which has {', '.join(sorted(known)) or 'none'}"
            )
    for _ in range(refinements):
        network = network.refine()
    return network


def chain_of(body: BodySettings, parts: int) -> BeamNetwork:
    """The beams of a body along its points, every element of the file in equal parts."""
    settings = body.beam
    assert settings is not None and settings.points is not None and settings.profile is not None
    corners, count = np.array(settings.points), settings.elements * parts
    share = np.arange(count)[:, None] / count
    pieces = [a + share * (b - a) for a, b in pairwise(corners)]
    nodes = np.concatenate([*pieces, corners[-1:]])
    profile, up = settings.profile, settings.up
    ends = pairwise(range(len(nodes)))
    beams = [BeamElement(ends=pair, profile=profile, up=up) for pair in ends]
    return BeamNetwork(nodes=[(x, y, z) for x, y, z in nodes.tolist()], beams=beams)


def build_beam(
    config: RobotConfig, body: BodySettings, network: BeamNetwork, source: str, prefix: str
) -> tuple[BodyParts, TetMesh, BeamPart]:
    """Nodes with their masses, without tetrahedra that deform; they are numbered from zero.

    The nodes of the surface come after those of the tetrahedra.

    Returns:
        The body where it stands, its mesh in its own coordinates, and its beams.

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
    given, place = body.material, Placement.of(body.rotation, body.position)
    material = Material(given.young_modulus, given.poisson_ratio, given.density)
    by_name = {item.name: profile_of(item, material) for item in config.profiles}
    profiles = tuple(by_name[beam.profile] for beam in network.beams)
    radius = max(float(np.linalg.norm(profile.outline, axis=1).max()) for profile in profiles)
    axis = place.points(body.scale * np.array(network.nodes))  # (b, 3)
    beside = place.vectors(radius * np.vstack([np.zeros(3), np.eye(3)]))  # (4, 3)
    discs = tuple(placed_disc(disc, body.scale, place) for disc in network.discs)
    try:
        made = made_beams(network, axis, place, profiles, material)
    except BeamError as error:
        raise RobotFileError(f"{source}: {prefix}beam: {error}") from error
    made = with_masses(made, discs, body.material)
    corners = (axis[:, None] + beside).reshape(-1, 3)
    if body.beam.file is not None:
        surface = file_surface(network, len(corners), body.scale, place)
    else:
        surface = ring_surface(config, made, profiles[0], len(corners))
    points, owners, triangles, groups = surface
    part = BeamPart(
        name=body.name,
        nodes=CORNERS * np.arange(len(axis)),
        followers=len(corners) + np.arange(len(points)),
        owners=owners,
        points=points,
        triangles=triangles,
        shown=body.beam.file is not None,
        body=made,
        profiles=profiles,
        discs=discs,
        radius=radius,
    )
    tets = np.arange(len(corners)).reshape(-1, CORNERS)
    mesh = TetMesh(np.concatenate([corners, points]), tets, groups)
    mass = np.zeros(len(mesh.nodes))
    mass[part.nodes] = made.mass
    own = replace(mesh, nodes=place.points_in_part(mesh.nodes))
    return BodyParts(mesh, [], [], mass, len(made.ends), [], []), own, part


def made_beams(
    network: BeamNetwork,
    nodes: Array,
    place: Placement,
    profiles: Sequence[Profile],
    material: Material,
) -> Beams:
    """The beams of a network where it stands, without discs.

    Args:
        network: the network.
        nodes: (b, 3) where its nodes stand [m].
        place: of the body.
        profiles: cross-section of each element.
        material: of all beams.

    Raises:
        BeamError: a beam without length, a node that no beam leads to, or a beam along its `up`.
    """
    ends = np.array([beam.ends for beam in network.beams], dtype=np.int64)
    along = np.abs(nodes[ends[:, 1]] - nodes[ends[:, 0]])
    # z where a beam lies across it as well as others
    up = np.eye(3)[2 - along[:, ::-1].argmin(axis=1)]
    for index, beam in enumerate(network.beams):
        if beam.up is not None:
            up[index] = place.vectors(np.array(beam.up))
    return make_beams(nodes, ends, up, list(profiles), material)


def placed_disc(disc: Disc, scale: float, place: Placement) -> Disc:
    """A disc of a network in metres, its axis of length one in the robot's frame.

    Args:
        disc: in the body's coordinates.
        scale: of the body.
        place: of the body.
    """
    axis = place.vectors(np.array(disc.axis) / np.linalg.norm(disc.axis))
    size = {"radius": scale * disc.radius, "thickness": scale * disc.thickness}
    return disc.model_copy(update={**size, "axis": tuple(axis.tolist())})


def with_masses(beams: Beams, discs: Sequence[Disc], material: SolidMaterialSettings) -> Beams:
    """Beams with the masses of discs on their nodes, and with the mass that the file gives."""
    mass, inertia = beams.mass.copy(), beams.inertia.copy()
    for disc in discs:
        disc_mass = material.density * np.pi * disc.radius**2 * disc.thickness
        mass[disc.node] += disc_mass
        # that about its axis; across it the masses of the nodes have nearly all
        inertia[disc.node] += 0.5 * disc_mass * disc.radius**2
    share = 1.0 if material.total_mass is None else material.total_mass / mass.sum()
    return replace(beams, mass=share * mass, inertia=share * inertia)


def file_surface(network: BeamNetwork, first: int, scale: float, place: Placement) -> _Surface:
    """The surfaces of a network where it stands.

    Args:
        network: in the body's coordinates.
        first: number of the first of their points in the body's mesh.
        scale: of the body.
        place: of the body.
    """
    every, none = network.surfaces, np.zeros(0, np.int64)
    starts = first + np.cumsum([0, *(len(item.points) for item in every)])
    groups = tuple(
        CellGroup(item.name, none, np.array(item.triangles, np.int64) + start)
        for item, start in zip(every, starts.tolist(), strict=False)
    )
    points = np.array([point for item in every for point in item.points]).reshape(-1, 3)
    owners = np.array([node for item in every for node in item.nodes], dtype=np.int64)
    triangles = np.concatenate([none.reshape(-1, 3), *(one.triangles for one in groups)])
    return place.points(scale * points), owners, triangles, groups


def ring_surface(config: RobotConfig, beams: Beams, profile: Profile, first: int) -> _Surface:
    """The lateral surface of a line of beams, where something may touch it, or a robot that it is part of."""
    if not (config.contacts or config.surfaces or isinstance(config, PartRobotConfig)):
        return np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros((0, 3), np.int64), ()
    around, triangles = chain_surface(beams, profile)
    count, corners = around.shape[:2]
    rings = first + np.arange(count * corners)
    every = np.concatenate([CORNERS * np.arange(count), rings])  # as `chain_surface` numbers them
    owners = np.repeat(np.arange(count), corners)
    return around.reshape(-1, 3), owners, every[triangles], ()
