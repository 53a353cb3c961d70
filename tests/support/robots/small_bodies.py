"""A short thick beam of every element and law, and with drives, rigid regions and attachments."""

from __future__ import annotations

from collections.abc import Sequence

from support.robots.bodies import beam_config, box_mesh
from tauten.model import Robot, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.load import build_robot
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import RobotConfig, validated
from tauten.model.tetra import NodalBody

SIZE = (0.1, 0.02, 0.02)
SOFT = {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1000.0}
STIFF_END = {
    "young_modulus": 5e6,
    "poisson_ratio": 0.3,
    "density": 1200.0,
    "region": {"lower": [0.06, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]},
}
KINDS: dict[str, tuple[str, dict[str, object], list[dict[str, object]]]] = {
    "linear": ("linear", {"law": "corotational", **SOFT}, []),
    "linear, regions": ("linear", {"law": "corotational", **SOFT}, [STIFF_END]),
    "linear, yeoh": (
        "linear",
        {"law": "yeoh", "silicone": "dragon-skin-30", "density": 1080.0},
        [],
    ),
    "smoothed": ("smoothed", {"law": "corotational", **SOFT}, []),
    "smoothed, regions": ("smoothed", {"law": "corotational", **SOFT}, [STIFF_END]),
    "smoothed, neo-hookean": ("smoothed", {"law": "neo-hookean", **SOFT}, []),
    "smoothed, mixed laws": (
        "smoothed",
        {"law": "corotational", **SOFT},
        [{"law": "stable-neo-hookean", **STIFF_END}],
    ),
    "quadratic": ("quadratic", {"law": "corotational", **SOFT}, []),
    "quadratic, mooney-rivlin": (
        "quadratic",
        {"law": "mooney-rivlin", "c10": 1e5, "c01": 5e4, "poisson_ratio": 0.45, "density": 1000.0},
        [],
    ),
}


def small_body(
    kind: str, cells: tuple[int, int, int] = (6, 2, 2), **changes: object
) -> Robot[NodalBody]:
    """A beam of one of `KINDS` with so many cells, and with changes of its settings."""
    element, material, materials = KINDS[kind]
    settings = beam_config(SIZE, material=material, materials=materials, **changes)
    settings["mesh"] = {"file": "beam.vtu", "element": element}
    config = RobotConfig.model_validate(settings)
    return build_robot(config, box_mesh(SIZE, cells), "beam")


MESH = box_mesh(SIZE, (8, 2, 2))
RUBBER = {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
ROOT = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
END = {"kind": "half_space", "point": [0.0874, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
MIDDLE = {"lower": [0.037, 0.0, 0.0], "upper": [0.051, 0.02, 0.02]}
TURN = {
    "name": "servo", "axis": [0.0, 1.0, 0.0], "through": [0.045, 0.0, 0.01],
    "max_angle": 3.0, "max_torque": 100.0, "max_rate": 100.0,
}  # fmt: skip
SLIDE = {
    "name": "slider", "motion": "translation", "axis": [0.0, 0.0, 2.0],
    "max_travel": 0.1, "max_force": 100.0, "max_rate": 1.0,
}  # fmt: skip
# two of them, one after the other, and what joins and moves them
SECOND = {"name": "second", "mesh": {"file": "b.vtu"}, "position": [0.1, 0.0, 0.0]}
FIRST = {"name": "first", "mesh": {"file": "a.vtu"}, "fixed": [ROOT]}
FACE = {"body": "second", "lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
LAST = {"kind": "half_space", "point": [0.1874, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
GLUE = {"kind": "glue", "region": FACE, "to": {"kind": "all", "body": "first"}}
TOUCH = {
    "surfaces": [
        {"name": side, "box": {"lower": [-1, -1, -1], "upper": [1, 1, 1]}, "normal": [0, 0, z]}
        for side, z in (("top", 1.0), ("bottom", -1.0))
    ],
    "contacts": [{"candidates": "top", "against": "bottom", "points": 20}],
    "contact": {"alarm_distance": 0.1},
}  # fmt: skip
HINGE = {
    "kind": "hinge",
    "region": {"body": "second", "lower": [0.024, 0, 0], "upper": [0.026, 0.02, 0.02]},
    "axis": [1.0, 1.0, 0.0],
    "through": [0.125, 0.01, 0.01],
}
WINCH = {
    "name": "winch", "members": ["tendon"], "gains": [-0.5], "pretensions": [2.0],
    "max_position": 1.0, "max_effort": 10.0, "max_rate": 1.0,
}  # fmt: skip


def constrained(
    meshes: TetMesh | Sequence[TetMesh] = MESH,
    size: tuple[float, float, float] = SIZE,
    **changes: object,
) -> Robot[ConstrainedBody]:
    """A beam with constraints; `changes` replace tables of its file, None removes them."""
    settings = {k: v for k, v in beam_config(size, **changes).items() if v is not None}
    robot = build_robot(validated(RobotConfig, settings, "beam.toml"), meshes, "beam.toml")
    assert isinstance(robot.body, ConstrainedBody)
    return robot


def rigid_box(mesh: TetMesh = MESH, **changes: object) -> Robot[ConstrainedBody]:
    """A whole box as one rigid body that nothing holds."""
    body = {"name": "box", "mesh": {"file": "beam.vtu"}, "rigid": True, "free": True}
    return constrained([mesh], mesh=None, bodies=[body], fixed=[], **changes)


def moved(robot: Robot[ConstrainedBody], state: State, dq: Array) -> State:
    """The state after a change dq (n,) of the coordinates."""
    return robot.advance(state, dq, 1.0)
