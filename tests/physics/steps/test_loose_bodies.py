"""Bodies that nothing holds beside bodies whose steps are quasi-static: each moves by its own law."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import beam_config, box_mesh
from support.robots.joined import joined

from tauten.model import Robot, Simulator
from tauten.model.load import build_robot
from tauten.model.parts import Assembly, Between, Part, Placement, join_parts
from tauten.model.schema import RobotConfig, RobotFileError, validated

SIDE, RATE, G = 0.02, 100.0, 9.81
SIZE = (0.06, 0.06, 0.02)
TABLE, CUBE = box_mesh(SIZE, (6, 6, 2)), box_mesh((SIDE, SIDE, SIDE), (2, 2, 2))
BASE = {"kind": "half_space", "point": [0.0, 0.0, 1e-6], "normal": [0.0, 0.0, -1.0]}
STATIC = {"scheme": "quasi-static"}


TOP = [{"candidates": "faces", "against": "top", "points": 100}]


def table_and_cube(
    above: float,
    scheme: dict[str, object],
    contacts: list[dict[str, object]] = TOP,
    obstacles: list[dict[str, object]] | None = None,
    **cube: object,
) -> Robot:
    """A soft table that stands on fixed nodes, and a cube some way above it [m]."""
    bodies = [
        {"name": "table", "mesh": {"file": "table.vtu"}, "fixed": [BASE]},
        {
            "name": "cube", "mesh": {"file": "cube.vtu"}, "free": True,
            "position": [0.02, 0.02, SIZE[2] + above], **cube,
        },
    ]  # fmt: skip
    settings = beam_config(
        SIZE, mesh=None, fixed=[], bodies=bodies, gravity=[0.0, 0.0, -G], integration=scheme,
        material={"young_modulus": 2e4, "poisson_ratio": 0.3, "density": 1000.0},
        controller={"rate": RATE},
        regions=[
            {"name": "faces", "kind": "skin", "body": "cube"},
            {"name": "top", "kind": "normal", "body": "table", "direction": [0.0, 0.0, 1.0]},
        ],
        contacts=contacts, obstacles=obstacles, contact={"alarm_distance": 5e-3},
    )  # fmt: skip
    known = {key: value for key, value in settings.items() if value is not None}
    return build_robot(validated(RobotConfig, known, "robot.toml"), [TABLE, CUBE], "robot.toml")


def parts_of(robot: Robot, simulator: Simulator) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of the table and of the cube [m]."""
    x = robot.motion(simulator.state).x  # type: ignore[attr-defined]
    return x[: len(TABLE.nodes)], x[len(TABLE.nodes) :]


@pytest.mark.parametrize("converged", [False, True])
@pytest.mark.parametrize("rigid", [True, False])
def test_a_loose_cube_falls_beside_a_table_that_is_always_at_rest(
    rigid: bool, converged: bool
) -> None:
    """By g h² k (k + 1) / 2 in k implicit steps; the table has sagged after a few Newton steps.

    A converged step looked for an equilibrium of what falls, and let it fall by 20 m.
    """
    robot = table_and_cube(0.1, STATIC, rigid=rigid)
    simulator = Simulator(robot, contact="none")
    _, start = parts_of(robot, simulator)
    for _ in range(12):
        simulator.step(effort=[0.0], converged=converged)
    table, cube = parts_of(robot, simulator)
    fallen = G / RATE**2 * 12 * 13 / 2
    np.testing.assert_allclose(cube.mean(axis=0) - start.mean(axis=0), [0, 0, -fallen], atol=1e-9)
    held = table_and_cube(0.1, STATIC, free=False, fixed=[{"kind": "all"}])
    alone = Simulator(held, contact="none")
    assert alone.settle(effort=[0.0], tolerance=1e-10).converged
    np.testing.assert_allclose(table, parts_of(held, alone)[0], atol=1e-9)


@pytest.mark.parametrize("gravity", [0.0, G])
@pytest.mark.parametrize("joint", [{"kind": "pin"}, {"kind": "hinge", "axis": [0.0, 1.0, 0.0]}])
def test_an_iterated_step_beside_a_loose_cube_takes_what_nothing_holds(
    joint: dict[str, object], gravity: float
) -> None:
    """What may turn about its pin has no stiffness there: steps raised that their matrix has no factor."""
    bar, whole = (
        (0.1, 0.02, 0.02),
        {name: {"kind": "all", "body": name} for name in ("bar", "link")},
    )
    robot = joined(
        [
            {"name": "bar", "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}]},
            {"name": "link", "rigid": True, "position": [0.1, 0.0, 0.0]},
            {"name": "cube", "rigid": True, "free": True, "position": [0.0, 0.0, 0.1]},
        ],
        {"bar": (bar, (3, 2, 2)), "link": (bar, (2, 1, 1)), "cube": ((SIDE,) * 3, (1, 1, 1))},
        attachments=[
            {"region": whole["link"], "to": whole["bar"], "through": [0.1, 0.01, 0.01], **joint}
        ],
        gravity=[0.0, 0.0, -gravity],
        effectors=[
            {"name": name, "point": [x, 0.01, 0.01]} for name, x in (("pin", 0.1), ("end", 0.2))
        ],
    )
    simulator = Simulator(robot, contact="none")
    for _ in range(2):
        assert simulator.step(effort=[0.0], converged=True).converged
    pin, end = simulator.effector
    np.testing.assert_allclose(end - pin, [0, 0, -0.1] if gravity else [0.1, 0, 0], atol=2e-4)


def test_a_cube_that_lies_on_a_quasi_static_table_presses_with_its_weight() -> None:
    robot = table_and_cube(1e-4, {**STATIC, "rayleigh_mass": 20.0}, rigid=True)
    simulator = Simulator(robot, contact="full")
    for _ in range(150):
        simulator.step(effort=[0.0])
    weight = 1000.0 * SIDE**3 * G
    pressed = simulator.contact_forces
    assert pressed[:, 2].sum() == pytest.approx(weight, rel=1e-3)
    assert np.abs(pressed[:, :2].sum(axis=0)).max() < 1e-3 * weight
    table, cube = parts_of(robot, simulator)
    under = (np.abs(table - [0.03, 0.03, 0.0]) < [0.008, 0.008, 1.0]).all(axis=1)
    assert cube[:, 2].min() == pytest.approx(table[under, 2].max(), abs=2e-4)
    assert table[:, 2].max() < SIZE[2]


def test_a_cube_of_a_static_part_lands_as_that_of_a_dynamic_one() -> None:
    """It stopped where it would have been a period later, 0.4 mm above the floor, and trembled there."""
    height, none = 0.003, np.zeros(0, dtype=np.int64)
    floor: dict[str, object] = {
        "name": "floor", "shape": "plane",
        "parameters": {"point": [0.0, 0.0, SIZE[2] - height], "normal": [0.0, 0.0, 1.0]},
    }  # fmt: skip
    on_floor: list[dict[str, object]] = [
        {"candidates": "faces", "against": "floor", "points": "vertices"}
    ]
    parts = [
        Part(
            scheme,
            table_and_cube(0.0, {"scheme": scheme}, on_floor, [floor], rigid=True),
            Placement(np.eye(3), np.array([place, 0.0, 0.0])),
        )
        for scheme, place in (("quasi-static", 0.0), ("implicit-euler", 0.2))
    ]
    gravity, between = np.array([0.0, 0.0, -G]), Between((none, none), ())
    robot = join_parts(Assembly("two", "base", "", gravity, 1e-6, 5e-3, 0.0, between), parts)
    simulator, count = Simulator(robot), len(TABLE.nodes) + len(CUBE.nodes)
    start = robot.points(simulator.state)
    for k in range(1, 6):
        simulator.move(effort=[0.0, 0.0])
        fallen = (start - robot.points(simulator.state))[:, 2].reshape(2, count)[
            :, len(TABLE.nodes) :
        ]
        expected = min(G / 2.0 * (k / RATE) ** 2, height)
        np.testing.assert_allclose(fallen, expected, atol=1e-7)


@pytest.mark.parametrize("place", [-0.31, -0.37])
@pytest.mark.parametrize("kind", ["step", "move"])
def test_a_cube_that_falls_fast_lies_on_a_thin_plate(kind: str, place: float) -> None:
    """It falls by 25 mm in a period, and went through the plate of 4 mm or stayed halfway in it."""
    lower, upper = [-0.1, -0.1, place - 0.004], [0.2, 0.2, place]
    plate: dict[str, object] = {
        "name": "plate", "shape": "box", "parameters": {"lower": lower, "upper": upper}
    }  # fmt: skip
    on_plate: list[dict[str, object]] = [
        {"candidates": "faces", "against": "plate", "points": "vertices"}
    ]
    robot = table_and_cube(0.0, STATIC, on_plate, [plate], rigid=True)
    simulator = Simulator(robot)
    for _ in range(30):
        getattr(simulator, kind)(effort=[0.0])
    _, cube = parts_of(robot, simulator)
    np.testing.assert_allclose(cube[:, 2].min(), place, atol=1e-7)


def test_what_is_glued_to_a_loose_body_is_loose() -> None:
    """A lid on the cube that is not said to be free falls with it; without the glue it is refused."""
    lid = {
        "name": "lid",
        "mesh": {"file": "lid.vtu"},
        "position": [0.02, 0.02, 0.14],
        "rigid": True,
    }
    cube = {
        "name": "cube", "mesh": {"file": "cube.vtu"}, "free": True, "position": [0.02, 0.02, 0.12],
    }  # fmt: skip
    table = {"name": "table", "mesh": {"file": "table.vtu"}, "fixed": [BASE]}
    face = {"body": "cube", "lower": [0.0, 0.0, SIDE], "upper": [SIDE, SIDE, SIDE]}
    glue = {"kind": "glue", "region": face, "to": {"kind": "all", "body": "lid"}}

    def made(attachments: list[dict[str, object]]) -> Robot:
        settings = beam_config(
            SIZE, mesh=None, fixed=[], bodies=[table, cube, lid], gravity=[0.0, 0.0, -G],
            integration=STATIC, controller={"rate": RATE}, attachments=attachments,
        )  # fmt: skip
        known = {key: value for key, value in settings.items() if value is not None}
        config = validated(RobotConfig, known, "robot.toml")
        return build_robot(config, [TABLE, CUBE, CUBE], "robot.toml")

    with pytest.raises(RobotFileError, match="to hold the body 'lid'"):
        made([])
    robot = made([glue])
    simulator = Simulator(robot, contact="none")
    _, start = parts_of(robot, simulator)
    for _ in range(5):
        simulator.step(effort=[0.0])
    fallen = parts_of(robot, simulator)[1] - start
    np.testing.assert_allclose(fallen.mean(axis=0), [0, 0, -G / RATE**2 * 15], atol=1e-8)
