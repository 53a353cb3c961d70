"""Robots of parts from files: objects, contact between parts, obstacles, and what is refused."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from support.robots.bodies import box_mesh
from support.robots.combinations import write_networks
from support.robots.solids import RIGID_CUBE

from tauten.model import (
    Robot,
    RobotFileError,
    Simulator,
    contact_wrenches,
    load_robot,
    touched_names,
)
from tauten.model.mesh.surface import boundary_triangles

EDGE, DENSITY = 0.02, 2000.0
WEIGHT = DENSITY * EDGE**3 * 9.81  # N

CUSHION = """
name = "cushion"
mesh = { file = "cushion.vtu" }
material = { young_modulus = 2e5, poisson_ratio = 0.3, density = 1000.0 }
integration = { scheme = "quasi-static" }
fixed = [{ lower = [-1.0, -1.0, -1e-6], upper = [1.0, 1.0, 1e-6] }]
[[effectors]]
name = "top"
point = [0.03, 0.03, 0.03]
[[cables]]
name = "down"
pull_point = [0.01, 0.01, -0.01]
points = [[0.01, 0.01, 0.0], [0.01, 0.01, 0.03]]
max_tension = 5.0
max_pull = 0.01
max_rate = 0.1
"""
TABLE = """
name = "table"
[[parts]]
name = "cushion"
robot = "cushion.toml"
[[parts]]
name = "cube"
robot = "cube.toml"
position = [0.02, 0.02, 0.0302]
"""
ON_CUSHION = """
[[contacts]]
candidates = { part = "cube", surface = "below" }
against = { part = "cushion" }
points = "vertices"
"""


def written(folder: Path, table: str) -> Path:
    """The files of a cushion, of a cube and of both as parts."""
    for name, size, cells in (
        ("cube", (EDGE, EDGE, EDGE), (1, 1, 1)),
        ("cushion", (0.06, 0.06, 0.03), (4, 4, 3)),
    ):
        mesh = box_mesh(size, cells)
        meshio.write(folder / f"{name}.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    (folder / "cube.toml").write_text(RIGID_CUBE)
    (folder / "cushion.toml").write_text(CUSHION)
    (folder / "table.toml").write_text(table)
    return folder / "table.toml"


def resting(robot: Robot, steps: int = 60) -> Simulator:
    """A simulation after some steps, the actuators at rest."""
    simulator = Simulator(robot, "full")
    for _ in range(steps):
        simulator.step(np.zeros(robot.n_a))
    return simulator


def test_a_cushion_in_static_steps_carries_the_weight_of_a_cube_in_dynamic_ones(
    tmp_path: Path,
) -> None:
    """Weight against the sum of contact forces: nature, not the solver."""
    robot = load_robot(written(tmp_path, TABLE + ON_CUSHION))
    assert [part.integration.static for part in robot.body.part_robots] == [True, False]
    simulator = resting(robot)
    forces = simulator.contact_forces.sum(axis=0)
    np.testing.assert_allclose(forces[2], WEIGHT, rtol=1e-6)
    assert np.abs(forces[:2]).max() < 1e-4 * WEIGHT  # no friction: the cube may slide on a dent
    speed = np.abs(simulator.state.v[robot.body.spans.columns[1]][2])
    assert speed < 1e-6


def test_wrenches_on_parts_and_obstacles_balance_the_weight(tmp_path: Path) -> None:
    """The cube lies on the cushion: action and reaction about one origin."""
    robot = load_robot(written(tmp_path, TABLE + ON_CUSHION))
    simulator = resting(robot, 40)
    assert touched_names(robot) == ("cube", "cushion")
    cube, cushion = contact_wrenches(robot, simulator.contacts)
    np.testing.assert_allclose(cube[2], WEIGHT, rtol=1e-4)
    np.testing.assert_allclose(cushion, -cube, atol=1e-12)
    middle = robot.body.part_robots[1].body  # of mass, over which the force acts
    x, y = simulator.robot.points(simulator.state)[-middle.n_nodes :, :2].mean(axis=0)
    np.testing.assert_allclose(cube[3:5], [y * WEIGHT, -x * WEIGHT], rtol=1e-2)


def test_it_falls_freely_before_it_touches(tmp_path: Path) -> None:
    high = TABLE.replace("0.0302", "0.2")
    robot = load_robot(written(tmp_path, high + ON_CUSHION), rate=1000.0)
    simulator = resting(robot, steps=100)
    cube = robot.body.states(simulator.state)[1]
    fallen = robot.body.part_robots[1].rest().q - cube.q
    # implicit Euler falls g h² k (k + 1) / 2 in k steps
    np.testing.assert_allclose(fallen.max(), 9.81 * 1e-6 * 100 * 101 / 2, rtol=1e-9)
    assert simulator.contact_forces.max() == 0.0


@pytest.mark.parametrize("angle", [0.0, 25.0])
def test_a_cube_on_a_plane_is_carried_by_it_and_slides_down_as_on_ice(
    tmp_path: Path, angle: float
) -> None:
    """N = m g cos(angle), a = g sin(angle)."""
    a = np.deg2rad(angle)
    table = TABLE.replace("[0.02, 0.02, 0.0302]", "[0.2, 0.02, 0.1]").replace(
        'robot = "cube.toml"',
        f'robot = "cube.toml"\nrotation = {{ axis = [0.0, 1.0, 0.0], angle_deg = {angle} }}',
    )
    normal = [float(np.sin(a)), 0.0, float(np.cos(a))]
    plane = f"""
    [[obstacles]]
    name = "floor"
    shape = "plane"
    parameters = {{ point = [0.2, 0.02, 0.1], normal = {normal} }}
    [[contacts]]
    candidates = {{ part = "cube", surface = "below" }}
    against = "floor"
    points = "vertices"
    """
    robot = load_robot(written(tmp_path, table + plane), rate=500.0)
    simulator = resting(robot, steps=50)
    forces = simulator.contact_forces.sum(axis=0)
    np.testing.assert_allclose(forces, WEIGHT * np.cos(a) * np.array(normal), atol=1e-6 * WEIGHT)
    speed = float(np.linalg.norm(simulator.state.v[robot.body.spans.columns[1]][:3]))
    np.testing.assert_allclose(speed, 9.81 * np.sin(a) * 0.1, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ('name = "cube"\nrobot = "cube', 'name = "cushion"\nrobot = "cube'),
            "is not unique|twice",
        ),
        (('robot = "cube.toml"', 'robot = "ball.toml"'), "ball.toml"),
        (
            ('part = "cube"', 'part = "ball"'),
            r"contacts.0.candidates: there is no part 'ball', known are cube, cushion",
        ),
        (
            ('against = { part = "cushion" }', 'against = "floor"'),
            r"contacts.0.against: there is no obstacle 'floor'",
        ),
        (('against = { part = "cushion" }', 'against = { part = "cube" }'), "both surfaces"),
        (
            ('surface = "below"', 'surface = "side"'),
            "contacts.0.candidates.surface: .*surface 'side' is not defined, known are below",
        ),
        (
            ("0.0302]", "0.0298]"),
            "contacts.0.against: cube.below is in part 'cushion' at rest: 0.2 mm deep at",
        ),
        (('robot = "cushion.toml"', 'robot = "cube.toml"'), "no part has one"),
        (('robot = "cube.toml"', 'robot = "table.toml"'), "has no parts of its own"),
        (('name = "table"', 'name = "table"\ncolour = "red"'), "colour"),
        (
            ("[[contacts]]", ON_CUSHION + "[[contacts]]"),
            r"contacts.1: it is 'cube.below on cushion.skin' as contacts.0 is; write one table",
        ),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    table = TABLE + ON_CUSHION
    assert change[0] in table
    path = written(tmp_path, table.replace(*change))
    with pytest.raises(RobotFileError, match=message):
        load_robot(path)


def test_an_object_within_a_part_is_found_where_no_candidate_lies_in_it(tmp_path: Path) -> None:
    inside = TABLE.replace("0.0302]", "0.005]")
    contact = """
    [[contacts]]
    candidates = { part = "cushion" }
    against = { part = "cube" }
    points = "vertices"
    """
    where = r"cube.skin is in part 'cushion' at rest: .* mm deep at .* move one of the parts"
    with pytest.raises(RobotFileError, match=where):
        load_robot(written(tmp_path, inside.replace("0.02, 0.02", "0.017, 0.017") + contact))


def test_a_file_of_an_object_is_no_robot_by_itself(tmp_path: Path) -> None:
    written(tmp_path, TABLE)
    with pytest.raises(RobotFileError, match="effectors"):
        load_robot(tmp_path / "cube.toml")


@pytest.mark.parametrize("order", [(0, 1), (1, 0), (0, 1, 2), (1, 0, 2)])
def test_objects_stand_anywhere_among_the_parts(tmp_path: Path, order: tuple[int, ...]) -> None:
    head, *parts = TABLE.split("[[parts]]")
    other = parts[0].replace('name = "cushion"', 'name = "other"') + "position = [0.2, 0.0, 0.0]\n"
    parts = [*parts, other]
    table = "[[parts]]".join([head, *(parts[k] for k in order)])
    robot = load_robot(written(tmp_path, table))
    assert robot.effector_layout.names == tuple(
        ("cushion_top", "", "other_top")[k] for k in order if k != 1
    )
    assert np.isfinite(robot.effector(robot.rest())).all()


def test_a_static_part_beside_a_dynamic_one_moves_as_it_does_alone(tmp_path: Path) -> None:
    """Steps of every kind: one linearisation, converged, and the second order of a controller's model."""
    both = Simulator(load_robot(written(tmp_path, TABLE.replace("0.0302", "5.0"))), "none")
    alone = Simulator(load_robot(tmp_path / "cushion.toml"), "none")
    for position, converged in ((1e-3, False), (2e-3, True), (1e-3, True), (0.0, True)):
        both.step(np.array([position]), converged=converged)
        alone.step(np.array([position]), converged=converged)
        np.testing.assert_allclose(both.effector, alone.effector, atol=1e-6)
        np.testing.assert_allclose(both.effort, alone.effort, rtol=1e-3, atol=1e-4)
    for position in (5e-4, 1e-3):
        both.move(np.array([position]))
        alone.move(np.array([position]))
        np.testing.assert_allclose(both.effector, alone.effector, atol=1e-6)


def test_names_of_parts_and_actuators_that_make_the_same_are_refused(tmp_path: Path) -> None:
    table = TABLE.replace('name = "cube"\nrobot = "cube.toml"', 'name = "a_b"\nrobot = "c.toml"')
    path = written(tmp_path, table.replace('name = "cushion"', 'name = "a"'))
    for file, name in (("cushion.toml", "b_c"), ("c.toml", "c")):
        (tmp_path / file).write_text(CUSHION.replace('name = "down"', f'name = "{name}"'))
    with pytest.raises(RobotFileError, match="a_b_c"):
        load_robot(path)


def test_the_region_that_touches_counts_in_the_digest(tmp_path: Path) -> None:
    first = load_robot(written(tmp_path, TABLE + ON_CUSHION)).digest
    cube = (tmp_path / "cube.toml").read_text()
    (tmp_path / "cube.toml").write_text(cube.replace("[0.0, 0.0, -1.0]", "[0.0, 0.0, 1.0]"))
    assert load_robot(tmp_path / "table.toml").digest != first


def test_what_lies_between_parts_changes_the_digest_and_no_part(tmp_path: Path) -> None:
    apart = load_robot(written(tmp_path, TABLE))
    touching = load_robot(written(tmp_path, TABLE + ON_CUSHION))
    assert apart.digest != touching.digest
    assert len(apart.digest) == len(touching.digest) == len(apart.body.part_robots[0].digest)
    pairs = zip(apart.body.part_robots, touching.body.part_robots, strict=True)
    assert all(one.digest == other.digest for one, other in pairs)


def test_the_content_of_an_obstacles_mesh_counts_in_the_digest_and_not_its_name(
    tmp_path: Path,
) -> None:
    obstacle = """
[[obstacles]]
name = "stone"
shape = "mesh"
parameters = {{ file = "{}", length_unit = "m" }}
position = [0.0, 0.0, -1.0]
[[contacts]]
candidates = {{ part = "cube" }}
against = "stone"
"""
    for name, size in (("a.stl", 0.02), ("b.stl", 0.03), ("c.stl", 0.02)):
        mesh = box_mesh((size, 0.02, 0.02), (1, 1, 1))
        triangles = boundary_triangles(mesh.tets)
        meshio.write(tmp_path / name, meshio.Mesh(mesh.nodes, [("triangle", triangles)]))
    first, second, third = (
        load_robot(written(tmp_path, TABLE + ON_CUSHION + obstacle.format(f"{name}.stl"))).digest
        for name in "abc"
    )
    assert first == third != second


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("density = 2000.0", "density = 0.0"), "density"),
        (("density = 2000.0", "density = -1.0"), "density"),
        (("density = 2000.0", "density = nan"), "density"),
        (("density = 2000.0", "density = 1e-30"), "density"),
        ((", density = 2000.0", ""), "density: .*missing|density: .*required"),
        (("density = 2000.0", "total_mass = 0.0"), "total_mass"),
    ],
)
def test_an_object_without_mass_is_refused(
    tmp_path: Path, change: tuple[str, str], message: str
) -> None:
    path = written(tmp_path, TABLE + ON_CUSHION)
    assert change[0] in RIGID_CUBE
    (tmp_path / "cube.toml").write_text(RIGID_CUBE.replace(*change))
    with pytest.raises(RobotFileError, match=message):
        load_robot(path)


ARM = """
name = "arm"
bodies = [{ name = "arm", beam = { file = "tree.json" } }]
regions = [{ name = "top", kind = "group", group = "top" }]
gravity = [0.0, 0.0, 0.0]
material = { young_modulus = 2e10, poisson_ratio = 0.3, density = 1.0 }
integration = { scheme = "quasi-static" }
fixed = [{ lower = [-1e-6, -1.0, -1.0], upper = [1e-6, 1.0, 1.0] }]
[[profiles]]
kind = "tube"
name = "rod"
outer = 4e-3
[[effectors]]
name = "tip"
point = [0.1, 0.01, 0.01]
max_outside = 0.05
[[cables]]
name = "tendon"
points = [[0.0, 0.01, 0.002], [0.1, 0.01, 0.002]]
max_outside = 0.05
max_tension = 5.0
max_pull = 0.01
max_rate = 0.1
"""


def test_an_arm_of_beams_bends_under_a_cube_as_a_cantilever(tmp_path: Path) -> None:
    """Contact of beams with a body of tetrahedra; P L³ / 3 E I with the moment of where the cube has slid."""
    write_networks(tmp_path)
    (tmp_path / "arm.toml").write_text(ARM)
    table = TABLE.replace("cushion", "arm").replace("[0.02, 0.02, 0.0302]", "[0.08, 0.0, 0.02001]")
    touching = ON_CUSHION.replace('part = "cushion"', 'part = "arm", surface = "top"')
    robot = load_robot(written(tmp_path, table + touching.replace('"vertices"', "25")))
    simulator = resting(robot, steps=20)
    forces = simulator.contact_forces.sum(axis=0)
    np.testing.assert_allclose(forces[2], WEIGHT, rtol=1e-3)
    cube = robot.body.parts[1]
    own = cube.robot.points(robot.body.states(simulator.state)[1])
    length = 0.1  # of the node that carries the surface
    offset = length - cube.placement.points(own).mean(axis=0)[0]
    bending = 2e10 * np.pi * 0.002**4 / 4.0
    sag = WEIGHT * (length**3 / 3.0 - offset * length**2 / 2.0) / bending
    np.testing.assert_allclose(0.01 - simulator.effector[0, 2], sag, rtol=0.02)


@pytest.mark.parametrize(
    ("part", "whole", "said"),
    [
        ("gravity = [0.0, 0.0, 0.0]", "", "parts.cushion: gravity [0.0, 0.0, 0.0] in cushion.toml is not"),
        ("controller = { rate = 20.0 }", "", "parts.cushion: controller.rate 20 Hz in cushion.toml is not"),
        ("gravity = [0.0, 0.0, 0.0]", "gravity = [0.0, 0.0, -1.6]", ""),
        ("gravity = [0.0, 0.0, -9.81]", "", ""),
        ("controller = { rate = 20.0 }", "controller = { rate = 30.0 }", ""),
    ],
)  # fmt: skip
def test_what_only_the_file_of_a_part_says_is_not_ignored_silently(
    part: str, whole: str, said: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Gravity and rate are those of the file of all parts; where it leaves them out, that is said."""
    path = written(tmp_path, f"{whole}\n{TABLE}")
    (tmp_path / "cushion.toml").write_text(f"{part}\n{CUSHION}")
    assert load_robot(path).n_a == 1
    notes = [record.getMessage() for record in caplog.records]
    assert len(notes) == (1 if said else 0)
    assert said in "".join(notes)
