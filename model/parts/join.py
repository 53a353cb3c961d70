"""From parts to one robot, in which a step is a step of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tauten.model.actuators import Coupling
from tauten.model.contact import (
    ContactPair,
    ContactSet,
    LargestSum,
    ObstaclePose,
    largest_sums,
    pose_at,
)
from tauten.model.numerics import diameter, joined, matrix_quaternion
from tauten.model.parts.actuators import PartsActuators
from tauten.model.parts.body import PartsBody
from tauten.model.parts.effectors import parts_effectors
from tauten.model.parts.motion import PartsPoints, PointsOfPart, slices
from tauten.model.parts.motors import parts_motors
from tauten.model.parts.part import Assembly, Between, Part, Placement
from tauten.model.parts.spans import spans_of
from tauten.model.robot import Robot
from tauten.model.schema import check_unique
from tauten.model.system import Integration


def join_parts(assembly: Assembly, parts: Sequence[Part]) -> Robot[PartsBody]:
    """One robot of several parts.

    Raises:
        ValueError: a coupling or a contact that is none, or a name that is used twice.
    """
    effectors = parts_effectors(parts)
    actuators, limits, coupling = parts_motors(parts, assembly.couplings)
    check_unique("actuators", list(actuators.names))
    check_unique("effectors", list(effectors.layout.names))
    return Robot(
        name=assembly.name,
        frame=assembly.frame,
        digest=assembly.digest,
        tolerance=assembly.tolerance,
        actuators=actuators,
        limits=limits,
        effectors=effectors,
        contacts=parts_contacts(assembly, parts),
        vertices=contact_vertices(assembly.between, parts),
        body=parts_body(assembly, parts, coupling),
    )


def parts_body(assembly: Assembly, parts: Sequence[Part], coupling: Coupling | None) -> PartsBody:
    """The body of several parts."""
    robots = [part.robot for part in parts]
    spans = spans_of([robot.body for robot in robots])
    placements = tuple(part.placement for part in parts)
    at_rest = [part.placement.points(part.robot.points(part.robot.rest())) for part in parts]
    return PartsBody(
        gravity=assembly.gravity,
        integration=joined_integration([robot.integration for robot in robots]),
        actuator_set=PartsActuators(
            tuple(robot.actuator_set for robot in robots), placements, spans.columns, coupling
        ),
        parts=tuple(parts),
        assembly=assembly,
        spans=spans,
        extent=diameter(np.concatenate(at_rest)),
    )


def joined_integration(schemes: Sequence[Integration]) -> Integration:
    """The scheme of all parts: static where all are, damped where one is."""
    return Integration(
        rate=schemes[0].rate,
        static=all(scheme.static for scheme in schemes),
        rayleigh_mass=max(scheme.rayleigh_mass for scheme in schemes),
        rayleigh_stiffness=max(scheme.rayleigh_stiffness for scheme in schemes),
        viscous=any(scheme.viscous for scheme in schemes),
    )


def contact_vertices(between: Between, parts: Sequence[Part]) -> PartsPoints:
    """Vertices of the contacts within each part, then its vertices of the contacts between parts."""
    groups = []
    for number, (part, ids) in enumerate(zip(parts, between.vertices, strict=True)):
        points = part.robot.vertices
        if len(ids) > 0:
            points = joined([points, part.robot.body.surface_points(ids)])
        groups.append(PointsOfPart(number, points, part.placement.elsewhere))
    return PartsPoints(tuple(groups))


def parts_contacts(assembly: Assembly, parts: Sequence[Part]) -> ContactSet:
    """Contacts within each part, then those between parts, over `contact_vertices`."""
    sets, sums = [part.robot.contacts for part in parts], list[LargestSum]()
    pairs, touching = list[ContactPair](), [len(ids) for ids in assembly.between.vertices]
    count = sum(one.n_vertices for one in sets) + sum(touching)
    sizes = zip(sets, touching, strict=True)
    spans = slices([size for own, more in sizes for size in (own.n_vertices, more)])
    for part, own, span in zip(parts, sets, spans[::2], strict=True):
        for limit in own.sums:
            numbers = tuple(len(pairs) + number for number in limit.pairs)
            sums.append(LargestSum(f"{part.name}: {limit.name}", numbers, limit.force))
        for pair in own.pairs:
            one, name = pair.obstacle, f"{part.name}: {pair.name}"
            if one is not None:
                one = one.within(part.named(one.name), frame_of(part.placement))
            other = part.name if one is None else ""
            within = pair.renumbered(np.arange(span.start, span.stop))
            pairs.append(replace(within, name=name, obstacle=one, owner=part.name, other=other))
    sums += largest_sums(assembly.between.pairs, assembly.max_force, len(pairs))
    between = np.concatenate([np.arange(span.start, span.stop) for span in spans[1::2]])
    pairs += [pair.renumbered(between) for pair in assembly.between.pairs]
    return ContactSet(pairs, count, assembly.alarm_distance, assembly.distance, sums)


def frame_of(placement: Placement) -> ObstaclePose:
    """Where the frame of a part stands, as a pose."""
    return pose_at(placement.position, matrix_quaternion(placement.Q))
