"""What can be seen in mesh files, those of chambers included, before a robot is built from them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from tauten.model.actuators import inside_out
from tauten.model.mesh import (
    UNITS,
    TetMesh,
    boundary_triangles,
    mean_ratios,
    part_numbers,
    read_triangles,
)
from tauten.model.points import attach
from tauten.model.schema import Point, RobotConfig
from tauten.service.check.findings import Finding

POOR = 0.2  # mean ratio; the deformation of an element below it is badly resolved
BAD = 0.05  # mean ratio; such an element limits the accuracy of what is around it
USUAL_SIZE = (0.005, 3.0)  # m; a soft robot smaller or larger is probably in another unit
THIN = 0.5  # share of the volume; in two layers of elements or more it is less
LEAST_FILLED = 0.02  # of the mesh's length; cables that reach over less are in another unit
NEAR = 0.05  # of the mesh's size; how far outside its bounding box a cable may run


def mesh_findings(config: RobotConfig, meshes: list[TetMesh]) -> Iterator[Finding]:
    """Length unit, shape of elements, loose parts, points outside of the mesh.

    Units and points are looked at where there is one body, which its points must fit.
    """
    if config.mesh is not None:
        yield length_unit(config, config.mesh.length_unit, meshes[0])
    meshed = [body for body in config.all_bodies if body.mesh is not None]
    for body, mesh in zip(meshed, meshes, strict=True):
        for found in (element_shapes(mesh), loose_parts(mesh)):
            of = "" if config.mesh else f" of {body.name}"
            yield replace(found, subject=found.subject + of)
    if config.mesh is not None:
        yield points_outside(config, meshes[0])


def named_points(config: RobotConfig) -> list[tuple[str, Point, float]]:
    """Points of cables and effectors on the body: field, position [m], how far outside they may lie [m]."""
    found = [
        (f"cables.{i}.points.{j}", point, cable.max_outside)
        for i, cable in enumerate(config.cables)
        for j, point in enumerate(cable.points)
    ]
    for i, item in enumerate(config.effectors):
        # the origin of a frame moves with its region and may lie anywhere
        point = None if item.kind == "frame" else item.point
        fields: list[tuple[str, Point | None]] = [("point", point), ("other", item.other)]
        fields += [(f"points.{j}", point) for j, point in enumerate(item.points or ())]
        found += [
            (f"effectors.{i}.{name}", point, item.max_outside)
            for name, point in fields
            if point is not None
        ]
    return found


def length_unit(config: RobotConfig, unit: str, mesh: TetMesh) -> Finding:
    """Whether the mesh has the size of a robot, and where its cables are."""
    points = np.array([point for _, point, _ in named_points(config)])  # (p, 3)
    size = float(np.ptp(mesh.nodes, axis=0).max())
    found = f"{1e3 * size:.4g} mm long with length_unit = {unit!r}"
    inside, filled = dict.fromkeys(UNITS, 0), dict.fromkeys(UNITS, 0.0)
    for name, scale in UNITS.items() if len(points) else ():
        factor = scale / UNITS[unit]
        low = factor * mesh.nodes.min(axis=0) - NEAR * factor * size
        high = factor * mesh.nodes.max(axis=0) + NEAR * factor * size
        inside[name] = int(((points >= low) & (points <= high)).all(axis=1).sum())
        filled[name] = float(np.ptp(points, axis=0).max()) / (factor * size)
    best = max(UNITS, key=lambda name: (inside[name], filled[name], name == unit))
    # points that fill the mesh, or a fair part of it, are no reason for another unit
    if best != unit and (inside[unit] < inside[best] or 0.0 < filled[unit] < LEAST_FILLED):
        advice = (
            f"set mesh.length_unit = {best!r}: then {inside[best]} of {len(points)} points of cables and "
            f"effectors lie within its bounding box and reach over {100.0 * filled[best]:.2g} % of it, now "
            f"{inside[unit]} and {100.0 * filled[unit]:.2g} %"
        )
        return Finding("length unit", "wrong", found, advice)
    if not USUAL_SIZE[0] <= size <= USUAL_SIZE[1]:
        return Finding("length unit", "doubtful", found, "check mesh.length_unit")
    return Finding("length unit", "fine", found)


def element_shapes(mesh: TetMesh) -> Finding:
    """Inverted, flat and badly shaped elements."""
    ratios = mean_ratios(mesh)
    if (ratios < 0.0).all():
        ratios = -ratios  # the other corner convention, which the reader accepts
    inverted, flat = int((ratios < 0.0).sum()), int(((ratios >= 0.0) & (ratios < 1e-6)).sum())
    poor = int((ratios < POOR).sum())
    first = int(ratios.argmin())
    found = (
        f"mean ratio {ratios.min():.2f} at least, {np.median(ratios):.2f} median; "
        f"{poor} of {len(ratios)} below {POOR:g}"
    )
    if inverted or flat:
        found += f"; {inverted} inverted, {flat} flat, the worst is {first}"
        return Finding("shape of elements", "wrong", found, "mesh the volume anew")
    if poor:
        advice = f"improve the mesh around element {first} (gmsh: Mesh.Optimize, Netgen)"
        return Finding(
            "shape of elements", "wrong" if ratios.min() < BAD else "doubtful", found, advice
        )
    return Finding("shape of elements", "fine", found)


def thin_layers(config: RobotConfig, meshes: list[TetMesh]) -> Iterator[Finding]:
    """Bodies that are mostly walls one element thick, for robots whose meshes are not compared.

    Quadratic elements bend in one layer. The others have one deformation gradient, or averages of neighbours,
    so that a single layer hardly has different strains at both sides of a wall.
    """
    meshed = [body for body in config.all_bodies if body.mesh is not None]
    for body, mesh, settings in zip(meshed, meshes, config.meshes, strict=True):
        outer = np.zeros(len(mesh.nodes), np.bool_)
        outer[boundary_triangles(mesh.tets)] = True
        volumes, through = np.abs(mesh.volumes), outer[mesh.tets].all(axis=1)
        share = float(volumes[through].sum() / max(volumes.sum(), np.finfo(float).tiny))
        if settings.element != "quadratic" and share > THIN:
            of = "" if config.mesh else f" of {body.name}"
            found = (
                f"{100.0 * share:.0f} % of the volume is in elements whose corners are all on the surface, "
                "as of walls one element thick"
            )
            advice = (
                'two elements over the thickness, or mesh.element = "quadratic": one layer may be far too '
                "stiff in bending; without --no-compare the error is measured"
            )
            yield Finding(f"elements over the thickness{of}", "doubtful", found, advice)


def loose_parts(mesh: TetMesh) -> Finding:
    """Parts of the mesh that no face joins."""
    sizes = np.sort(np.bincount(part_numbers(mesh.tets)))[::-1]
    if len(sizes) == 1:
        return Finding("loose parts", "fine", "one body")
    stray = ", ".join(map(str, sizes[1:6])) + (", ..." if len(sizes) > 6 else "")
    found = f"{len(sizes)} parts, beside the largest of {sizes[0]} elements: {stray}"
    return Finding("loose parts", "wrong", found, "join them by faces or delete the small ones")


def points_outside(config: RobotConfig, mesh: TetMesh) -> Finding:
    """Cable points and effectors outside of the mesh, allowed by `max_outside` or not."""
    subject = "cables and effectors"
    volumes = np.abs(mesh.volumes)
    sound = TetMesh(mesh.nodes, mesh.tets[volumes > 1e-9 * volumes.mean()])
    named = named_points(config)
    if not named:
        return Finding(subject, "fine", "no points in the robot file")
    points = np.array([point for _, point, _ in named])  # (p, 3)
    held = attach(sound, points, subject, np.inf)
    corners = sound.nodes[held.nodes]  # (p, 4, 3)
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))  # (p, 3, 3)
    gradients = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)  # (p, 4, 3)
    distance = (-held.weights / np.linalg.norm(gradients, axis=2)).max(axis=1)  # (p,) to a face
    beyond = np.flatnonzero(distance > 1e-9 * sound.size)
    if not len(beyond):
        return Finding(subject, "fine", f"all {len(points)} points in the mesh")
    allowed = [outside for _, _, outside in named]
    refused = bool((distance > np.maximum(allowed, 1e-9 * sound.size)).any())
    far = int(distance.argmax())
    found = (
        f"{len(beyond)} of {len(points)} points outside of the mesh, {named[far][0]} by at least "
        f"{1e3 * distance[far]:.2g} mm"
    )
    advice = "move them into the body; max_outside only extrapolates the nearest element"
    return Finding(subject, "wrong" if refused else "doubtful", found, advice)


def chamber_findings(config: RobotConfig, folder: Path) -> Iterator[Finding]:
    """Whether the STL files of chambers have their normals out of the chamber."""
    for chamber in config.chambers:
        if chamber.stl is None:
            continue
        subject = f"chamber {chamber.name}"
        if inside_out(*read_triangles(folder / chamber.stl)):
            found = f"the surface in {chamber.stl} is inside out and has been turned"
            advice = "turn its triangles, so that their normals point out of the chamber"
            yield Finding(subject, "doubtful", found, advice)
        else:
            yield Finding(subject, "fine", f"the normals of {chamber.stl} point out of it")
