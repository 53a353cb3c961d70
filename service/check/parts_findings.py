"""What parts of a robot say about each other: which overlap at rest, which free ones nothing touches."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

from tauten.model import Robot, skin_of
from tauten.model.contact import enclosed
from tauten.model.numerics import Array, Ints
from tauten.model.parts import Part, PartsBody
from tauten.model.schema import PartsConfig, RobotConfig
from tauten.service.check.findings import Finding

APART = "places of the parts"  # subject of a finding
HELD = "free parts"


def parts_findings(
    robot: Robot, config: PartsConfig, files: dict[str, RobotConfig]
) -> Iterator[Finding]:
    """Overlaps of parts at rest, and free parts that no contact touches; the files are those of the parts."""
    assert isinstance(robot.body, PartsBody)
    yield overlapping_parts(robot.body.parts, robot.tolerance)
    free = [
        name
        for name, file in files.items()
        if any(body.free for body in file.bodies) and not file.attachments
    ]
    if free and robot.gravity.any():
        yield free_parts(free, config, files)


def overlapping_parts(parts: tuple[Part, ...], tolerance: float) -> Finding:
    """Where a part is in another at rest by more than a tolerance [m].

    What the surfaces of a contact overlap by is refused when the file is loaded.
    """
    found = [one for one in overlaps(parts) if one[0] > tolerance]
    if not found:
        return Finding(APART, "fine", "no part is in another at rest")
    depth, inner, outer, at = max(found, key=lambda one: one[0])
    where = ", ".join(f"{value:.4g}" for value in at)
    return Finding(
        APART,
        "doubtful",
        f"at rest {inner} is {1e3 * depth:.3g} mm inside {outer}, at ({where}) m; {len(found)} such pairs",
        f"move one of them, or mind that no contact of the file acts there: {inner} and {outer} go through "
        "each other",
    )


def overlaps(parts: tuple[Part, ...]) -> Iterator[tuple[float, str, str, Array]]:
    """How deep vertices of parts are in others at rest; nothing is in parts whose surface is open.

    Yields:
        the depth of the deepest [m], the names of the inner and of the outer part, and where (3,) [m].
    """
    skins = {part.name: skin(part) for part in parts}
    solids = {name: enclosed(*drawn) for name, drawn in skins.items()}
    for inner, outer in permutations(skins, 2):
        points, solid = skins[inner][0], solids[outer]
        if solid is not None and len(points):
            depth = -solid.closest_within(points, 0.0)[0]
            yield float(depth.max()), inner, outer, points[depth.argmax()]


def skin(part: Part) -> tuple[Array, Ints]:
    """Vertices (v, 3) at rest in the robot's frame [m] and triangles (t, 3) of the surface of a part."""
    robot, found = part.robot, skin_of(part.robot)
    return part.placement.points(robot.points(robot.rest())[found.used]), found.triangles


def free_parts(free: list[str], config: PartsConfig, files: dict[str, RobotConfig]) -> Finding:
    """Whether contact may hold the parts that have free bodies."""
    touched = {contact.candidates.part for contact in config.contacts} | {
        contact.against.part for contact in config.contacts if not isinstance(contact.against, str)
    }
    lone = [name for name in free if name not in touched and not files[name].contacts]
    if not lone:
        return Finding(HELD, "fine", f"contacts of the file touch {', '.join(free)}")
    names = ", ".join(lone)
    return Finding(
        HELD,
        "doubtful",
        f"{names}: free, and touched by no contact of the robot file",
        f"[[contacts]] with a surface of {names}, which else falls",
    )
