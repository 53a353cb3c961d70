"""Several bodies in a robot file: the same mesh in several places, materials and masses of each."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.bodies import beam_config, box_mesh

from tauten.model import Robot, Simulator
from tauten.model.load import beam_network, build_robot, make_robot
from tauten.model.mesh import MeshError
from tauten.model.numerics import Array
from tauten.model.schema import (
    Changes,
    RobotConfig,
    RobotFileError,
    RotationSettings,
    validated,
)
from tauten.model.tetra import NodalBody

SIZE = (0.1, 0.02, 0.02)
MESH = box_mesh(SIZE, (8, 2, 2))
RUBBER = {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
ROOT = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
ANGLES = (0.0, 120.0, 240.0)
TENDON = np.array([[0.01, 0.01, 0.002], [0.1, 0.01, 0.002]])
TIP = np.array([0.1, 0.01, 0.01])


def pose(angle: float) -> tuple[Rotation, Array]:
    """Fingers on a circle that hang down: x of the mesh along −z, its lower side inwards."""
    down = Rotation.from_euler("y", 90.0, degrees=True)
    around = Rotation.from_euler("z", angle, degrees=True)
    return around * down, around.apply([0.05, 0.0, 0.0])


OUTER_HALF = {"lower": [0.06, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]}


def finger_table(angle: float, **changes: object) -> dict[str, object]:
    turn, place = pose(angle)
    x, y, z, w = turn.as_quat()
    return {
        "name": f"finger{angle:.0f}",
        "mesh": {"file": "beam.vtu"},
        "rotation": {"quaternion": [w, x, y, z]},
        "position": place.tolist(),
        "fixed": [ROOT],
        **changes,
    }


def gripper_settings(**changes: object) -> dict[str, object]:
    cables, effectors = [], []
    for angle in ANGLES:
        turn, place = pose(angle)
        points = (turn.apply(TENDON) + place).tolist()
        name = f"tendon{angle:.0f}"
        limits = {"max_tension": 50.0, "max_pull": 0.03, "max_rate": 0.1, "max_outside": 1e-6}
        cables.append({"name": name, "points": points, **limits})
        tip = (turn.apply(TIP) + place).tolist()
        effectors.append({"name": f"tip{angle:.0f}", "point": tip, "max_outside": 1e-6})
    settings = beam_config(SIZE, cables=cables, effectors=effectors, fixed=[], material=RUBBER)
    del settings["mesh"]
    return settings | {"bodies": [finger_table(angle) for angle in ANGLES]} | changes


def built(settings: dict[str, object], count: int = 3) -> Robot[NodalBody]:
    config = validated(RobotConfig, settings, "gripper.toml")
    return build_robot(config, [MESH] * count, "gripper.toml")


def settled(robot: Robot[NodalBody], position: list[float]) -> Simulator:
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=position, tolerance=1e-10).converged
    return simulator


@pytest.mark.parametrize("element", ["linear", "quadratic"])
def test_three_fingers_of_one_mesh_move_like_one(element: str) -> None:
    """Without gravity each finger does what it does alone, turned by its pose."""
    mesh = {"file": "beam.vtu", "element": element}
    alone = beam_config(SIZE, material=RUBBER, mesh=mesh)
    alone["cables"] = [{**alone["cables"][0], "points": TENDON.tolist()}]  # type: ignore[index]
    config = validated(RobotConfig, alone, "one.toml")
    one = settled(build_robot(config, MESH, "one.toml"), [0.01])
    bodies = [finger_table(angle, mesh=mesh) for angle in ANGLES]
    three = settled(built(gripper_settings(bodies=bodies)), [0.01] * 3)
    assert three.effort == pytest.approx(one.effort[0], rel=1e-6)
    nodes = three.robot.body.nodes(three.state).reshape(3, -1, 3)  # type: ignore[attr-defined]
    for angle, found in zip(ANGLES, nodes, strict=True):
        turn, place = pose(angle)
        expected = turn.apply(one.robot.body.nodes(one.state)) + place  # type: ignore[attr-defined]
        assert np.allclose(found, expected, atol=1e-8)
    assert three.robot.body.tetrahedra.elements.is_plain == (element == "linear")  # type: ignore[attr-defined]


def test_bodies_do_not_couple_without_attachments() -> None:
    simulator = settled(built(gripper_settings()), [0.01, 0.0, 0.0])
    moved = simulator.robot.body.nodes(simulator.state) - simulator.robot.body.mesh.nodes  # type: ignore[attr-defined]
    moved = np.linalg.norm(moved.reshape(3, -1, 3), axis=2).max(axis=1)
    assert moved[0] > 5e-3
    assert moved[1:].max() < 1e-9


def test_scale_and_materials_of_each_body() -> None:
    stiff = {**RUBBER, "young_modulus": 4e6, "density": 2000.0}
    half = {"lower": [0.0, 0.0, 0.0], "upper": [0.1, 0.04, 0.04]}
    bodies = [
        {"name": "small", "mesh": {"file": "beam.vtu"}, "fixed": [ROOT]},
        {
            "name": "large",
            "mesh": {"file": "beam.vtu"},
            "scale": 2.0,
            "position": [0.0, 0.1, 0.0],
            "fixed": ["root"],
            "materials": [{**stiff, "region": half}],
        },
    ]
    region = {"name": "root", "body": "large", "lower": [0, 0, 0], "upper": [0, 0.04, 0.04]}
    settings = beam_config(SIZE, bodies=bodies, regions=[region], material=RUBBER, fixed=[])
    del settings["mesh"]
    robot = built(settings, 2)
    assert not robot.body.tetrahedra.elements.is_plain
    volume = np.prod(SIZE)
    assert robot.body.mesh.volumes.sum() == pytest.approx(9.0 * volume)
    assert np.ptp(robot.body.mesh.nodes[:, 0]) == pytest.approx(0.2)
    assert (robot.body.pattern.dof < 0).sum() == 18
    (domains,) = robot.body.tetrahedra.elements.domains
    share = domains.volumes[domains.law == 1].sum()
    assert share == pytest.approx(4.0 * volume)


@pytest.mark.parametrize("element", ["linear", "quadratic", "smoothed"])
def test_a_region_weighs_by_its_own_density(element: str) -> None:
    """Mass and centre of mass of what a beam gains whose outer half is three times as dense."""
    heavy = {
        **RUBBER,
        "density": 3000.0,
        "region": {"lower": [0.05, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]},
    }
    settings = beam_config(SIZE, mesh={"file": "b.vtu", "element": element})
    found, even = (
        build_robot(validated(RobotConfig, one, "robot.toml"), MESH, "robot.toml")
        for one in ({**settings, "materials": [heavy]}, settings)
    )
    added = (found.body.tetrahedra.mass - even.body.tetrahedra.mass)[::3]
    half = 2000.0 * np.prod(SIZE) / 2.0
    assert added.sum() == pytest.approx(half)
    assert added @ found.rest().q[::3] == pytest.approx(half * 0.075)


def test_the_total_mass_replaces_densities() -> None:
    material = {"young_modulus": 1e6, "poisson_ratio": 0.3, "total_mass": 0.25}
    tables = [finger_table(angle) for angle in ANGLES]
    heavy = [finger_table(ANGLES[0], material=material), *tables[1:]]
    mass = built(gripper_settings(bodies=heavy)).body.tetrahedra.mass.reshape(3, -1)
    reference = built(gripper_settings(bodies=tables)).body.tetrahedra.mass.reshape(3, -1)
    assert mass[0] == pytest.approx(reference[0] * 0.25 / (1000.0 * np.prod(SIZE)))
    assert np.array_equal(mass[1:], reference[1:])


@pytest.mark.parametrize("density", [None, 900.0])
def test_densities_of_parts_may_be_left_out_beside_a_total_mass(density: float | None) -> None:
    """A part is then as dense as the rest; a part with a density of its own has its share."""
    given = {} if density is None else {"density": density}
    whole = {"young_modulus": 1e6, "poisson_ratio": 0.3, "total_mass": 0.25, **given}
    part = {"young_modulus": 5e6, "poisson_ratio": 0.3, "region": OUTER_HALF}
    settings = beam_config(SIZE, material=whole, materials=[part])
    mass = build_robot(
        validated(RobotConfig, settings, "robot.toml"), MESH, "robot.toml"
    ).body.tetrahedra.mass
    alike = beam_config(SIZE, material=whole)
    reference = build_robot(
        validated(RobotConfig, alike, "robot.toml"), MESH, "robot.toml"
    ).body.tetrahedra.mass
    np.testing.assert_allclose(mass, reference, rtol=1e-12)
    tables = [{**finger_table(angle), "material": None} for angle in ANGLES]
    tables[0] = {**tables[0], "materials": [part]}
    bodies = [{k: v for k, v in table.items() if v is not None} for table in tables]
    assert built(gripper_settings(material=whole, bodies=bodies)).body.moving_mass > 0.0
    without = {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    with pytest.raises(RobotFileError, match=r"materials\.0\.density: Field required"):
        validated(RobotConfig, beam_config(SIZE, material=without, materials=[part]), "r.toml")


def test_the_size_of_a_body_is_that_of_its_scaled_mesh(tmp_path: Path) -> None:
    """A mesh in millimetres with a scale of 1e-3 is the robot of the mesh in metres."""
    body = {"name": "arm", "mesh": {"file": "beam.vtu"}, "scale": 1e-3, "fixed": [ROOT]}
    settings = beam_config(SIZE, bodies=[body], material=RUBBER, fixed=[])
    del settings["mesh"]
    cells = [("tetra", MESH.tets)]
    meshio.write(tmp_path / "beam.vtu", meshio.Mesh(1e3 * MESH.nodes, cells))
    robot = make_robot(settings, tmp_path / "arm.toml", Changes())
    np.testing.assert_allclose(robot.body.mesh.nodes, MESH.nodes, atol=1e-15)  # type: ignore[attr-defined]
    body["scale"] = 1.0
    found = r"beam.vtu: the body is 100 m long, .* bodies.0.mesh.length_unit and bodies.0.scale;"
    with pytest.raises(MeshError, match=found):
        make_robot(settings, tmp_path / "arm.toml", Changes())


def test_a_file_with_bodies_loads_refined_and_stiffer(tmp_path: Path) -> None:
    meshio.write(tmp_path / "beam.vtu", meshio.Mesh(MESH.nodes, [("tetra", MESH.tets)]))
    contents = gripper_settings()
    robot = make_robot(contents, tmp_path / "gripper.toml", Changes())
    finer = make_robot(contents, tmp_path / "gripper.toml", Changes(refinements=1))
    stiffer = make_robot(contents, tmp_path / "gripper.toml", Changes(young_scale=2.0))
    assert finer.body.n_elements == 8 * robot.body.n_elements == 8 * 3 * len(MESH.tets)
    efforts = [settled(one, [0.005] * 3).effort[1] for one in (robot, stiffer)]  # type: ignore[arg-type]
    assert efforts[1] == pytest.approx(2.0 * efforts[0], rel=1e-6)
    with pytest.raises(
        MeshError, match=r"gripper.toml: bodies.0.mesh.file: no such file '.*none.vtu'"
    ):
        table = finger_table(0.0, mesh={"file": "none.vtu"})
        make_robot(gripper_settings(bodies=[table]), tmp_path / "gripper.toml", Changes())


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"mesh": {"file": "a.vtu"}}, "mesh: a robot has a mesh or bodies, this one has both"),
        ({"bodies": []}, "mesh: a robot has a mesh or bodies, this one has neither"),
        ({"bodies": [finger_table(0.0), finger_table(0.0)]}, "bodies: name 'finger0' is used twice"),
        ({"material": None}, "bodies.0.material: Field required, or material for all"),
        (
            {"bodies": [finger_table(0.0, rotation={"quaternion": [1.0, 1.0, 0.0, 0.0]})]},
            "bodies.0.rotation: the quaternion has the norm 1.41421, a rotation has the norm 1",
        ),
        (
            {"bodies": [finger_table(0.0, rotation={"axis": [1.0, 0.0, 0.0]})]},
            "bodies.0.rotation: a rotation has an axis and angle_deg, or a quaternion, or euler_deg",
        ),
        (
            {"bodies": [finger_table(0.0, fixed=[{"kind": "all", "body": "other"}])]},
            "bodies.0.fixed.0: body 'other' is not one of the bodies here: finger0",
        ),
        (
            {"bodies": [finger_table(0.0), finger_table(120.0, fixed=[])]},
            "fixed: needs three nodes not on a line to hold the body 'finger120'",
        ),
        (
            {"materials": [{**RUBBER, "region": ROOT}]},
            "materials: with bodies they stand in the table of each body",
        ),
    ],
)  # fmt: skip
def test_bad_bodies_are_one_sentence(changes: dict[str, object], sentence: str) -> None:
    settings = gripper_settings(**changes)
    with pytest.raises(RobotFileError, match=sentence):
        built(settings, len(settings["bodies"]))  # type: ignore[arg-type]


def test_axis_and_angle_are_the_quaternion() -> None:
    by_axis = finger_table(0.0, rotation={"axis": [0.0, 2.0, 0.0], "angle_deg": 90.0})
    rest = [finger_table(angle) for angle in ANGLES[1:]]
    nodes = [
        built(gripper_settings(bodies=[table, *rest])).body.mesh.nodes
        for table in (by_axis, finger_table(0.0))
    ]
    assert np.allclose(*nodes, atol=1e-15)


def test_euler_angles_turn_about_the_fixed_axes_in_the_order_of_sofa() -> None:
    """The quaternion of SOFA's `Quat::createQuaterFromEuler` with its default order, by three turns."""
    angles = (30.0, -50.0, 110.0)
    turn = RotationSettings(euler_deg=angles)
    w, x, y, z = turn.unit_quaternion
    expected = np.eye(3)
    for axis, angle in zip("xyz", angles, strict=True):
        expected = Rotation.from_euler(axis, angle, degrees=True).as_matrix() @ expected
    np.testing.assert_allclose(Rotation.from_quat([x, y, z, w]).as_matrix(), expected, atol=1e-14)
    with pytest.raises(ValueError, match="or euler_deg"):
        RotationSettings(euler_deg=angles, quaternion=(1.0, 0.0, 0.0, 0.0))


def test_the_same_mass_on_every_node() -> None:
    """Fixed nodes have their share, as SOFA's UniformMass has it."""
    material = {"young_modulus": 1e6, "poisson_ratio": 0.3, "total_mass": 0.25, "mass": "nodes"}
    tables = [finger_table(angle) for angle in ANGLES]
    heavy = [finger_table(ANGLES[0], material=material), *tables[1:]]
    robots = [built(gripper_settings(bodies=bodies)) for bodies in (heavy, tables)]
    mass, reference = (robot.body.tetrahedra.mass.reshape(3, -1) for robot in robots)
    np.testing.assert_allclose(mass[0], 0.25 / len(MESH.nodes), rtol=1e-12)
    assert np.array_equal(mass[1:], reference[1:])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": "nodes"}, 'material: mass = "nodes" shares out total_mass, which is missing'),
        ({"mass": "points"}, "material.mass: Input should be 'volume' or 'nodes', found 'points'"),
    ],
)
def test_a_mass_that_cannot_be_shared_out_is_said(changes: dict[str, object], message: str) -> None:
    settings = beam_config(SIZE, material={**RUBBER, **changes})
    with pytest.raises(RobotFileError, match=message):
        validated(RobotConfig, settings, "robot.toml")


def test_examples_of_the_page_are_robot_files() -> None:
    page = (Path(__file__).parents[3] / "docs" / "bodies.md").read_text(encoding="utf-8")
    examples = re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)
    assert len(examples) == 4
    for example in examples:
        validated(RobotConfig, tomllib.loads(example), "bodies.md")


@pytest.mark.parametrize(("above", "pushed"), [(0.004, "rod"), (0.012, "block"), (-0.025, "rod")])
def test_points_beside_beam_and_mesh_move_with_the_nearer_one(above: float, pushed: str) -> None:
    """A rod of radius 2 mm, 20 mm below a block: planes of elements farther away do not count."""
    bodies = [
        {"name": "block", "mesh": {"file": "beam.vtu"}, "fixed": [ROOT]},
        {
            "name": "rod", "beam": {"points": [[0, 0.01, -0.02], [0.1, 0.01, -0.02]], "profile": "rod"},
            "fixed": [{"kind": "sphere", "centre": [0.0, 0.01, -0.02], "radius": 1e-6}],
        },
    ]  # fmt: skip
    force = {
        "name": "push", "point": [0.02, 0.01, -0.02 + above], "max_outside": 0.05,
        "direction": [0.0, 1.0, 0.0], "max_force": 1.0, "max_travel": 1.0, "max_rate": 1.0,
    }  # fmt: skip
    settings = beam_config(
        SIZE, bodies=bodies, profiles=[{"kind": "tube", "name": "rod", "outer": 4e-3}], fixed=[],
        cables=[], forces=[force],
    )  # fmt: skip
    del settings["mesh"]
    config = validated(RobotConfig, settings, "robot.toml")
    robot = build_robot(config, [MESH, beam_network(config, config.all_bodies[1])], "robot.toml")
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=[0.05]).converged
    body = robot.body
    moved = body.nodes(simulator.state) - body.nodes(robot.rest())  # type: ignore[attr-defined]
    moves = np.split(np.abs(moved).max(axis=1), [len(MESH.nodes)])
    block, rod = (one.max() > 1e-6 for one in moves)
    assert (block, rod) == (pushed == "block", pushed == "rod")
