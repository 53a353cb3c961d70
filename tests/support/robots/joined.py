"""Robots of beams, rigid parts and soft bodies that are joined."""

from __future__ import annotations

from support.robots.bodies import CABLE, box_mesh
from tauten.model import Robot
from tauten.model.load import beam_network, build_robot
from tauten.model.schema import RobotConfig, validated

PLASTIC = {"young_modulus": 2e9, "poisson_ratio": 0.3, "density": 1100.0}
RUBBER = {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
ROD = {"kind": "tube", "name": "rod", "outer": 2e-3}


def push(
    name: str, point: list[float], direction: list[float], **changes: object
) -> dict[str, object]:
    """A force at a point."""
    limits = {"max_force": 1e3, "max_travel": 1.0, "max_rate": 10.0, "max_outside": 1e-3}
    return {"name": name, "point": point, "direction": direction, **limits, **changes}


def rod(name: str, points: list[list[float]], **changes: object) -> dict[str, object]:
    """A body that is a round beam."""
    elements = changes.pop("elements", 8)
    beam = {"points": points, "elements": elements, "profile": "rod"}
    return {"name": name, "beam": beam, "material": PLASTIC, **changes}


def joined_config(bodies: list[dict[str, object]], **changes: object) -> RobotConfig:
    """The file of a robot of bodies; `changes` are other tables. Without an actuator it has a force."""
    if not changes.keys() & {"cables", "drives", "forces"}:
        push_anywhere = push("push", [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], max_outside=1.0)
        changes = {**changes, "forces": [push_anywhere]}
    settings = {
        "name": "joined", "gravity": [0.0, 0.0, 0.0], "material": RUBBER, "profiles": [ROD],
        "bodies": bodies, "effectors": [{"name": "tip", "point": [0.1, 0.0, 0.0], "max_outside": 1.0}],
        "integration": {"scheme": "quasi-static"}, **changes,
    }  # fmt: skip
    return validated(RobotConfig, settings, "joined.toml")


def joined(
    bodies: list[dict[str, object]],
    boxes: dict[str, tuple[tuple[float, float, float], tuple[int, int, int]]] | None = None,
    **changes: object,
) -> Robot:
    """A robot of beams and boxes.

    Args:
        bodies: tables of its bodies; one without a beam is a box from its origin.
        boxes: size and cells of the box of each body that is one, by name.
        changes: other tables of the file.
    """
    shapes = boxes or {}
    tables = [
        {"mesh": {"file": "box.vtu"}, **body} if body["name"] in shapes else body for body in bodies
    ]
    config = joined_config(tables, **changes)
    meshes = [
        beam_network(config, body) if body.beam else box_mesh(*shapes[body.name])
        for body in config.all_bodies
    ]
    return build_robot(config, meshes, "joined.toml")


BASE, LINK, SIDE, ARM = 0.02, 0.04, 0.01, 0.004  # m: lengths, thickness, tendons from their hinge


def linked(links: int, tendon: dict[str, object], **changes: object) -> Robot:
    """Rigid links on hinges along x, a tendon above and one below each hinge, and the tip as effector.

    Args:
        links: their number.
        tendon: fields of all tendons.
        changes: other tables of the file; without drives the base is fixed.
    """
    bodies: list[dict[str, object]] = [{"name": "base"}]
    if "drives" not in changes:
        bodies[0]["fixed"] = [{"kind": "all"}]
    boxes = {"base": ((BASE, SIDE, SIDE), (1, 1, 1))}
    hinges, cables, before, middle = [], [], "base", 0.5 * SIDE
    for number in range(links):
        name, x = f"link{number}", BASE + number * LINK
        boxes[name] = ((LINK, SIDE, SIDE), (2, 1, 1))
        bodies.append({"name": name, "rigid": True, "position": [x, 0.0, 0.0]})
        hinges.append({
            "kind": "hinge", "region": {"kind": "all", "body": name}, "to": {"kind": "all", "body": before},
            "axis": [0.0, 1.0, 0.0], "through": [x, middle, middle],
        })  # fmt: skip
        before = name
        for side, arm in (("upper", ARM), ("lower", -ARM)):
            points = [
                [x + along, middle, middle + arm] for along in (-0.008, 0.2 * LINK, 0.8 * LINK)
            ]
            cables.append(
                {**CABLE, "name": f"{side}{number}", "points": points, "max_rate": 0.05, **tendon}
            )
    tip = [{"name": "tip", "point": [BASE + links * LINK, middle, middle]}]
    return joined(bodies, boxes, attachments=hinges, cables=cables, effectors=tip, **changes)
