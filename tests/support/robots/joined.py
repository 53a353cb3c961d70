"""Robots of beams, rigid parts and soft bodies that are joined."""

from __future__ import annotations

from support.robots.bodies import box_mesh
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
