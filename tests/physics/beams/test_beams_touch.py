"""Bodies that are beams in contact with obstacles and with other bodies, against beam theory and statics."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import box_mesh
from support.robots.joined import PLASTIC, joined, joined_config, push, rod

from tauten.model import Robot, Simulator
from tauten.model.load import beam_network, build_bodies
from tauten.model.schema import RobotFileError

G, L, DIAMETER = 9.81, 0.1, 2e-3
ROOT = {"body": "rod", "kind": "sphere", "centre": [0.0, 0.0, 0.0], "radius": 1e-6}
LINE = [[0.0, 0.0, 0.0], [L, 0.0, 0.0]]
WEIGHT = PLASTIC["density"] * np.pi / 4.0 * DIAMETER**2 * G  # N/m


def bearing(robot: Robot, effort: list[float]) -> float:
    """Sum of the upward contact forces in equilibrium [N]."""
    simulator = Simulator(robot)
    assert simulator.settle(effort=effort).converged
    return float(np.abs(simulator.contact_forces[:, 2]).sum())


def test_a_propped_cantilever_rests_with_three_eighths_of_its_weight() -> None:
    """Under its weight w L, clamped and propped at its end, a beam presses 3 w L / 8 on the prop."""
    radius = 5e-3
    prop = {
        "name": "prop", "shape": "sphere",
        "parameters": {"centre": [L, 0.0, -radius - 0.5 * DIAMETER], "radius": radius},
    }  # fmt: skip
    robot = joined(
        [rod("rod", LINE, fixed=[ROOT])],
        gravity=[0.0, 0.0, -G],
        obstacles=[prop],
        contacts=[{"against": "prop", "points": "vertices"}],
    )
    assert bearing(robot, [0.0]) == pytest.approx(3.0 / 8.0 * WEIGHT * L, rel=0.02)


def test_a_rod_bears_on_a_block_what_it_is_loaded_with() -> None:
    size, force = (0.02, 0.01, 0.01), 0.02
    block = {
        "name": "block", "position": [L - 0.5 * size[0], -0.005, -0.5 * DIAMETER - size[2] - 1e-4],
        "material": {**PLASTIC, "young_modulus": 1e7},
        "fixed": [{"body": "block", "lower": [-1.0, -1.0, -1e-6], "upper": [1.0, 1.0, 1e-6]}],
    }  # fmt: skip
    robot = joined(
        [rod("rod", LINE, fixed=[ROOT]), block],
        {"block": (size, (4, 2, 2))},
        regions=[{"name": name, "kind": "all", "body": name} for name in ("rod", "block")],
        contacts=[{"candidates": "rod", "against": "block", "points": "vertices"}],
        forces=[push("push", LINE[1], [0.0, 0.0, -1.0])],
    )
    bending = 3.0 * 2e9 * np.pi / 64.0 * DIAMETER**4 / L**3 * 1e-4  # N, to close the gap
    assert bearing(robot, [force]) == pytest.approx(force - bending, rel=0.03)


def test_the_surface_of_a_bent_rod_is_closed_around_its_material() -> None:
    """Every edge has one triangle on each side; the volume is that of a prism but for the kink."""
    bent = [[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.05, 0.05, 0.0]]
    robot = joined(
        [rod("rod", bent, fixed=[ROOT])],
        obstacles=[{"name": "floor", "shape": "plane", "parameters": {
            "point": [0.0, 0.0, -0.01], "normal": [0.0, 0.0, 1.0],
        }}],
        contacts=[{"against": "floor", "points": 3}, {"against": "itself", "points": 3}],
    )  # fmt: skip
    triangles = robot.contacts.pairs[1].triangles
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert {(a, b) for a, b in edges.tolist()} == {(b, a) for a, b in edges.tolist()}
    at_rest = robot.motion(robot.rest()).placed(robot.vertices).y
    a, b, c = np.moveaxis(at_rest[triangles], 1, 0)
    volume = float(np.einsum("ti,ti->", a, np.cross(b, c))) / 6.0
    prism = 4.0 * np.sin(np.pi / 4.0) * (0.5 * DIAMETER) ** 2 * L
    assert volume == pytest.approx(prism, rel=0.05)


FLOOR = {
    "name": "floor", "shape": "plane",
    "parameters": {"point": [0.0, 0.0, -0.01], "normal": [0.0, 0.0, 1.0]},
}  # fmt: skip
TOUCHING = {"obstacles": [FLOOR], "contacts": [{"against": "floor", "points": "vertices"}]}
BESIDE = {"lower": [0.09, 0.0005, -1.0], "upper": [0.2, 0.00095, 1.0]}  # nodes of the surface alone


@pytest.mark.parametrize("region", ["box", "body"])
def test_contacts_do_not_move_effectors(region: str) -> None:
    """The centre and the frame of the end of a rod are at its end, with a surface around it and without."""
    end = {
        "box": {"lower": [0.0985, -1.0, -1.0], "upper": [0.2, 1.0, 1.0]},
        "body": {"body": "rod", "kind": "sphere", "centre": LINE[1], "radius": 3e-3},
    }[region]
    effectors = [
        {"name": "end", "kind": "centre", "region": end},
        {"name": "whole", "kind": "centre", "region": {"kind": "all"}},
        {"name": "axes", "kind": "frame", "region": end},
    ]
    force = [push("push", LINE[1], [0.0, 0.0, 1.0])]
    values = []
    for changes in ({}, TOUCHING):
        robot = joined(
            [rod("rod", LINE, fixed=[ROOT])], effectors=effectors, forces=force, **changes
        )
        found = robot.effector(robot.rest())
        np.testing.assert_allclose(found, [[L, 0, 0], [0.5 * L, 0, 0], [L, 0, 0]], atol=1e-12)
        simulator = Simulator(robot, contact="none")
        assert simulator.settle(effort=[1e-2]).converged
        values.append(robot.effector_values(simulator.state))
    np.testing.assert_allclose(values[0], values[1], rtol=1e-6, atol=1e-9)
    assert values[0][2] == pytest.approx(values[0][8], rel=1e-6)
    assert values[0][2] > 0.01 * L


@pytest.mark.parametrize("changes", [{}, TOUCHING])
@pytest.mark.parametrize("table", ["effectors", "forces"])
def test_a_region_beside_a_beam_has_no_nodes(table: str, changes: dict[str, object]) -> None:
    limits = {"max_force": 1.0, "max_travel": 1.0, "max_rate": 1.0}
    items = {
        "effectors": {"name": "end", "kind": "centre", "region": BESIDE},
        "forces": {"name": "push", "region": BESIDE, "direction": [0.0, 0.0, 1.0], **limits},
    }
    with pytest.raises(RobotFileError, match=rf"{table}\..*\.region: no node in .*, the mesh"):
        joined([rod("rod", LINE, fixed=[ROOT])], **{table: [items[table]]}, **changes)


@pytest.mark.parametrize("first", [0, 1])
def test_behind_each_triangle_of_a_beam_is_the_tetrahedron_of_a_node(first: int) -> None:
    size = (0.02, 0.01, 0.01)
    tables = [
        rod("rod", LINE, fixed=[ROOT]),
        {"name": "block", "mesh": {"file": "box.vtu"}, "position": [L, 0.0, 0.0]},
    ]
    config = joined_config(tables[:: 1 - 2 * first], **TOUCHING)
    meshes = [
        beam_network(config, body) if body.beam else box_mesh(size, (2, 2, 2))
        for body in config.all_bodies
    ]
    bodies = build_bodies(config, meshes, "joined.toml")
    touching, (beam,) = bodies.touching, bodies.beams
    start = touching.ranges["rod"].first_triangle
    own = slice(start, start + len(beam.triangles))
    np.testing.assert_array_equal(touching.boundary[own], beam.triangles)
    assert (touching.owner >= 0).all()
    assert touching.owner.max() < len(touching.tets)
    node = touching.tets[touching.owner[own], 0]  # the first corner is the beam's node
    assert np.isin(node, beam.nodes).all()
    centres = touching.nodes[beam.triangles].mean(axis=1)
    assert np.abs(centres - touching.nodes[node])[:, 0].max() < L / 8
