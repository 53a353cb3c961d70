"""Small robots with one option of each of some axes of a robot file: body, map, row, element, law, contact,
reduction.

A body is a block of three cells, or of 3 x 3 x 3 cells around a cavity where a row needs one, a beam, or a
network of beams from a file, along x from 0 to 0.1 m and held at x = 0.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from support.robots.bodies import box_mesh, without
from support.robots.my_package import tables
from tauten.model import Robot
from tauten.model.load import beam_network, build_robot
from tauten.model.mesh import TetMesh
from tauten.model.schema import RobotConfig, validated
from tauten.reduction.state import reducible
from tauten.reduction.state.modes import with_own

Settings = dict[str, Any]
Option = Callable[[Settings], None]

SIZE = (0.1, 0.02, 0.02)
BLOCK = box_mesh(SIZE, (3, 1, 1))
HOLLOW = without(
    box_mesh(SIZE, (3, 3, 3)),
    [(np.array([0.034, 0.007, 0.007]), np.array([0.066, 0.013, 0.013]))],
)
MIDDLE, TIP, BELOW = [0.05, 0.01, 0.01], [0.1, 0.01, 0.01], [0.1, 0.01, 0.002]
LINE = [[0.0, 0.01, 0.002], BELOW]
ROOT = {"lower": [-1e-6, -1.0, -1.0], "upper": [1e-6, 1.0, 1.0]}
END = {"lower": [0.09, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
NEAR = {"max_outside": 0.05}
MESH = {"mesh": {"file": "block.vtu"}}
PLASTIC = {"young_modulus": 1e9, "poisson_ratio": 0.3, "density": 1000.0}
ROD = {
    "beam": {"points": [[0.0, 0.01, 0.01], TIP], "elements": 3, "profile": "rod"},
    "material": PLASTIC,
}


# bodies


def robot_file(**more: Any) -> Settings:
    """The tables that all robots have."""
    return {
        "name": "small", "gravity": [0.0, 0.0, 0.0],
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
        "profiles": [{"kind": "tube", "name": "rod", "outer": 4e-3}],
        **copy.deepcopy(more),
    }  # fmt: skip


def one_body(**body: Any) -> Settings:
    """A robot of one body."""
    return robot_file(bodies=[{"name": "body", **body}])


BODIES: dict[str, Callable[[], Settings]] = {
    "mesh": lambda: one_body(**MESH, fixed=[ROOT]),
    "rigid body": lambda: one_body(**MESH, rigid=True, free=True),
    "beam body": lambda: one_body(**ROD, fixed=[ROOT]),
    "network of beams": lambda: one_body(**network("tree.json"), fixed=[ROOT]),
    "network with a loop": lambda: one_body(**network("loop.json"), fixed=[ROOT]),
}


def network(file: str) -> Settings:
    """The fields of a body that is a network of beams."""
    return {"beam": {"file": file}, "material": PLASTIC}


def is_network(settings: Settings) -> bool:
    """Whether the body is a network of beams."""
    return "file" in settings["bodies"][0].get("beam", {})


def write_networks(folder: Path) -> None:
    """The files of beams of `BODIES`."""
    nodes = [[x, 0.01, 0.01] for x in np.linspace(0.0, 0.1, 4)]
    ends = [[0, 1], [1, 2], [2, 3]]
    discs = [
        {"name": f"disc{i}", "node": i, "radius": 0.01, "thickness": 1e-3, "axis": [1, 0, 0]}
        for i in range(4)
    ]
    surfaces = [square("top", 3, 0.02, [0, 1, 2, 3]), square("bottom", 2, 0.021, [3, 2, 1, 0])]
    for name, more, ends_ in (
        ("tree", [], ends),
        ("loop", [[0.05, 0.05, 0.01]], [*ends, [1, 4], [4, 3]]),
    ):
        beams = [{"ends": pair, "profile": "rod", "up": [0, 0, 1]} for pair in ends_]
        found = {"nodes": nodes + more, "beams": beams, "discs": discs, "surfaces": surfaces}
        (folder / f"{name}.json").write_text(json.dumps(found))


def square(name: str, node: int, z: float, order: list[int]) -> Settings:
    """A surface of two triangles that is attached to a node."""
    corners = [[0.08, 0.0, z], [0.1, 0.0, z], [0.1, 0.02, z], [0.08, 0.02, z]]
    a, b, c, d = order
    return {
        "name": name, "points": corners, "nodes": [node] * 4, "triangles": [[a, b, c], [a, c, d]]
    }  # fmt: skip


# options


def add(table: str, **item: Any) -> Option:
    """An option that adds an item to a table."""

    def apply(settings: Settings) -> None:
        settings.setdefault(table, []).append(copy.deepcopy(item))

    return apply


def every(*options: Option) -> Option:
    """An option of several."""

    def apply(settings: Settings) -> None:
        for option in options:
            option(settings)

    return apply


AXIS = {"axis": [0.0, 1.0, 0.0], "through": TIP}
OWN_END = {**END, "body": "body"}
TO_BODY = {"to": {"kind": "all", "body": "body"}, "max_distance": 0.05}
SECOND = {"kind": "all", "body": "second"}
FACE = {**ROOT, "body": "second"}
UNLIMITED = {"max_torque": 1.0, "max_angle": 1.0, "max_rate": 1.0}


def second(**body: Any) -> Option:
    """Another body behind the end of the first."""
    return add("bodies", name="second", position=[0.1, 0.0, 0.0], free=True, **body)


BEHIND = {"lower": [0.066, -1.0, -1.0], "upper": [1.0, 1.0, 1.0], "body": "body"}
MAPS: dict[str, Option] = {
    "rigid region": add("rigid", name="plate", region=OWN_END),
    "rotating drive": add("drives", name="servo", region=OWN_END, **AXIS, **UNLIMITED),
    "sliding drive": add(
        "drives", name="slider", motion="translation", region=OWN_END, axis=[0.0, 1.0, 0.0],
        max_travel=1.0, max_force=1.0, max_rate=1.0,
    ),
    "hinge on the frame": add("attachments", kind="hinge", region=OWN_END, **AXIS),
    "glue": every(second(**MESH), add("attachments", kind="glue", region=FACE, **TO_BODY)),
    "hinge": every(
        second(**MESH, rigid=True),
        add("attachments", kind="hinge", region=SECOND, **AXIS, **TO_BODY),
    ),
    "pin": every(
        second(**MESH, rigid=True),
        add("attachments", kind="pin", region=SECOND, through=TIP, **TO_BODY),
    ),
    "glue of a beam": every(
        second(**ROD), add("attachments", kind="glue", region=FACE, **TO_BODY)
    ),
    "pin of a beam": every(second(**ROD), add("attachments", kind="pin", region=FACE, **TO_BODY)),
}  # fmt: skip

MOTOR = {"max_position": 1.0, "max_effort": 10.0, "max_rate": 1.0}
SPRING = {"stiffness": 500.0, "pretension": 1.0}


def cable(name: str = "tendon", **more: Any) -> Option:
    """A cable along the body."""
    limits = {"max_tension": 10.0, "max_pull": 0.02, "max_rate": 0.1}
    return add("cables", name=name, points=LINE, **NEAR, **limits, **more)


def force(**where: Any) -> Option:
    """A force across the body."""
    limits = {"max_force": 1.0, "max_travel": 1.0, "max_rate": 1.0}
    return add("forces", name="push", direction=[0.0, 0.0, 1.0], **limits, **where)


def pair_of_cables(kind: str, more: Settings, **motor: Any) -> Option:
    """Two cables on one motor."""
    return every(
        cable("a", **more),
        cable("b", **more),
        add("couplings", name="motor", kind=kind, members=["a", "b"], gains=[1.0, -1.0], **motor, **MOTOR),
    )  # fmt: skip


def transmission(settings: Settings) -> None:
    """The muscle of docs/extend.md, along the body."""
    table = next(found["transmissions"][0] for found in tables() if "transmissions" in found)
    add("transmissions", **{**table, "points": LINE}, **NEAR)(settings)


def effector(kind: str, **where: Any) -> Option:
    """An effector."""
    return add("effectors", name="measured", kind=kind, **where)


def hollow(settings: Settings) -> None:
    """The block with a cavity."""
    settings["hollow"] = True


CHAMBER = {"max_pressure": 1e4, "max_volume_change": 1e-6, "max_rate": 1e-5}
ROWS: dict[str, Option] = {
    "cable": cable(),
    "cable with a pull point": cable(pull_point=[-0.1, 0.01, 0.0]),
    "cable with a spring": cable(spring=SPRING),
    "rod": cable(min_tension=-5.0),
    "chamber": every(hollow, add("chambers", name="bellows", inside=MIDDLE, **CHAMBER)),
    "force": force(point=TIP, **NEAR),
    "force over a region": force(region=OWN_END),
    "coupling": pair_of_cables("differential", {}, pretensions=[1.0, 1.0]),
    "drum": pair_of_cables("drum", {"spring": SPRING}),
    "transmission": transmission,
    "point": effector("point", point=BELOW, **NEAR),
    "centre": effector("centre", region=OWN_END),
    "frame": effector("frame", region=OWN_END),
    "distance": effector("distance", point=TIP, other=[0.0, 0.01, 0.01], **NEAR),
    "length": effector("length", points=LINE, **NEAR),
    "volume": every(hollow, effector("volume", inside=MIDDLE)),
    "function": effector("function", points=[*LINE, TIP], measure="spread", **NEAR),
}


def element(name: str) -> Option:
    """Another element than the linear one."""

    def apply(settings: Settings) -> None:
        body = settings["bodies"][0] if "bodies" in settings else settings
        body["mesh"] = {**body.get("mesh", MESH["mesh"]), "element": name}

    return apply


def material(**constants: Any) -> Option:
    """Another material than the corotational, elastic one."""

    def apply(settings: Settings) -> None:
        body = settings["bodies"][0] if "bodies" in settings else settings
        body["material"] = {**body.get("material", settings["material"]), **constants}

    return apply


def contact(**table: Any) -> Option:
    """A contact, between surfaces that have names."""

    def apply(settings: Settings) -> None:
        settings["contacts"] = [{**table, "points": 5}]
        if is_network(settings):
            groups = [{"name": name, "kind": "group", "group": name} for name in ("top", "bottom")]
            settings.setdefault("regions", []).extend(groups)
        else:
            box = {"lower": [-1.0, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
            settings["surfaces"] = [
                {"name": name, "box": box, "normal": [0.0, 0.0, z]}
                for name, z in (("top", 1.0), ("bottom", -1.0))
            ]

    return apply


def reduced(settings: Settings) -> None:
    """A state basis."""
    settings["reduced"] = True


AXES: dict[str, dict[str, Option]] = {
    "map": MAPS,
    "row": ROWS,
    "element": {name: element(name) for name in ("smoothed", "quadratic")},
    "law": {
        "stable-neo-hookean": material(law="stable-neo-hookean"),
        "neo-hookean": material(law="neo-hookean"),
        "mooney-rivlin": material(law="mooney-rivlin", c10=1e5, c01=5e4),
        "yeoh": material(law="yeoh", c10=1e5, c20=1e3),
        "viscosity": material(viscosity={"shares": [0.3], "times": [0.1]}),
    },
    "contact": {
        "two surfaces": contact(candidates="top", against="bottom"),
        "itself": contact(against="itself"),
        "obstacle": every(
            contact(candidates="bottom", against="floor"),
            add(
                "obstacles",
                name="floor",
                shape="plane",
                parameters={"point": [0.0, 0.0, -1e-3], "normal": [0.0, 0.0, 1.0]},
            ),
        ),
    },
    "reduction": {"state basis": reduced},
}


def robot_with(options: list[tuple[str, str]], folder: Path, *more: Option) -> Robot:
    """The robot with some options; the others are a mesh, linear and corotational, a cable and a point.

    Args:
        options: axis and name of each, of a body the axis "body".
        folder: where the files of beams are.
        more: other options.

    Raises:
        RobotFileError, StateBasisError: they are refused.
    """
    chosen = dict(options)
    settings = BODIES[chosen.get("body", "mesh")]()
    if chosen.get("map") == "glue of a beam" and "body" not in chosen:
        add("rigid", name="hub", region=BEHIND)(settings)  # beams are glued to what is rigid
    for axis, name in options:
        if axis != "body":
            AXES[axis][name](settings)
    every(*more)(settings)
    mesh = HOLLOW if settings.pop("hollow", False) else BLOCK
    with_basis = settings.pop("reduced", False)
    if "effectors" not in settings:
        effector("point", point=TIP, **NEAR)(settings)
    if not settings.keys() & {"cables", "chambers", "drives", "forces", "transmissions"}:
        cable()(settings)
    robot = built(settings, mesh, folder)
    return with_random_modes(robot) if with_basis else robot


def built(settings: Settings, mesh: TetMesh, folder: Path) -> Robot:
    """The robot of a file whose bodies are all made of one mesh, or are beams."""
    file = str(folder / "robot.toml")
    config = validated(RobotConfig, settings, file)
    shapes = [beam_network(config, body, file) if body.beam else mesh for body in config.all_bodies]
    return build_robot(config, shapes, file)


def with_random_modes(robot: Robot) -> Robot:
    """The robot in three random modes and its own coordinates, with a sample of all elements."""
    body = reducible(robot)
    Phi = np.random.default_rng(0).normal(size=(len(body.weight), 3))
    Phi[len(Phi) - body.own_coordinates :] = 0.0
    Phi = with_own(body, np.linalg.qr(Phi)[0] / np.sqrt(body.weight)[:, None])
    return body.reduced(Phi, np.arange(body.n_elements), np.ones(body.n_elements))
