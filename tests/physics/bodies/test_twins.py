"""Files that say the same in other words, or more that has no effect: the same decisions."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.bodies import box_mesh

from tauten.controller import Controller, controller_setup
from tauten.model.numerics import Array

File = dict[str, Any]
SIZE, TICKS = (0.1, 0.02, 0.02), 12
ROOT = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
SIDES = {"top": 1.0, "bottom": -1.0}
ANYWHERE = {"lower": [-1.0, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
TURN, MOVE = Rotation.from_rotvec([0.7, -1.1, 0.4]), np.array([1.3, -2.2, 0.7])


def write_mesh(folder: Path, name: str, length: float, cells: int, unit: float = 1.0) -> str:
    """The file of a box along x."""
    mesh, file = box_mesh((length, *SIZE[1:]), (cells, 2, 2)), folder / f"{name}.vtu"
    meshio.write(file, meshio.Mesh(mesh.nodes / unit, [("tetra", mesh.tets)]))
    return str(file)


def tendon(name: str, y: float, z: float, *between: float) -> File:
    """A cable along the beam, with more points between those of its stiff end."""
    points = [[x, y, z] for x in (0.01, 0.076, *between, 0.1)]
    limits = {"max_tension": 20.0, "min_pull": -0.02, "max_pull": 0.02, "max_rate": 0.1}
    return {"name": name, "pull_point": [-0.01, y, z], "points": points, **limits}


def beam(folder: Path) -> File:
    """A soft beam with two tendons that hangs under its weight; its end is stiff."""
    return {
        "name": "beam", "gravity": [0.0, 0.0, -9.81], "fixed": [ROOT],
        "mesh": {"file": write_mesh(folder, "whole", 0.1, 8)},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
        "rigid": [{"name": "tip", "region": {"lower": [0.07, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}}],
        "cables": [tendon("below", 0.01, 0.002), tendon("beside", 0.002, 0.01)],
        "effectors": [{"name": "tip", "point": [0.1, 0.01, 0.01]}],
        "integration": {"rayleigh_stiffness": 0.02}, "controller": {"rate": 50.0},
    }  # fmt: skip


def decided(file: File, folder: Path, turn: Rotation | None = None) -> tuple[Array, Array, Array]:
    """Positions, efforts (TICKS, n_a) and way of the tip (TICKS, 3) for targets in and out of reach.

    Args:
        file: of the robot.
        folder: where it would be.
        turn: of its axes, in which the targets are turned, too.
    """
    setup = controller_setup(copy.deepcopy(file), folder / "robot.toml", basis="full")
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    assert controller.settle_start().converged
    start, rng, axes = controller.effector[0], np.random.default_rng(0), turn or Rotation.identity()
    found = []
    for far in np.repeat([0.01, 0.1], TICKS // 2):
        assert controller.step(start + axes.apply(far * rng.standard_normal(3))).status.ok
        way = axes.inv().apply(controller.effector[0] - start)
        found.append((controller.position, controller.effort, way))
    return tuple(np.array(values) for values in zip(*found, strict=True))  # type: ignore[return-value]


def glued(file: File, folder: Path) -> File:
    """Two halves with the same nodes where they meet."""
    half = {"mesh": {"file": write_mesh(folder, "half", 0.05, 4)}}
    kept = {name: value for name, value in file.items() if name not in ("mesh", "fixed")}
    bodies = [
        {"name": "first", **half, "fixed": [ROOT]},
        {"name": "second", **half, "position": [0.05, 0.0, 0.0]},
    ]
    joint = {
        "kind": "glue",
        "region": {"body": "second", **ROOT},
        "to": {"kind": "all", "body": "first"},
    }
    return {**kept, "bodies": bodies, "attachments": [joint]}


def with_points_between(file: File, folder: Path) -> File:
    """Cables that pass more points of the stiff end, on the straight line between two."""
    return {
        **file,
        "cables": [tendon("below", 0.01, 0.002, 0.08, 0.09), tendon("beside", 0.002, 0.01, 0.085)],
    }


def in_millimetres(file: File, folder: Path) -> File:
    """A mesh file in another unit."""
    mesh = {"file": write_mesh(folder, "mm", 0.1, 8, unit=1e-3), "length_unit": "mm"}
    return {**file, "mesh": mesh}


def only_part(file: File, folder: Path) -> File:
    """The robot as the only part of a world."""
    own = "\n".join(f"{name} = {toml(value)}" for name, value in file.items())
    (folder / "beam.toml").write_text(own, encoding="utf-8")
    part = {"name": "part", "robot": "beam.toml"}
    return {"name": "world", "gravity": file["gravity"], "parts": [part]}


def turned_part(file: File, folder: Path) -> File:
    """The same, where the world is turned and moved."""
    world = only_part(file, folder)
    x, y, z, w = TURN.as_quat()
    world["parts"][0] |= {"rotation": {"quaternion": [w, x, y, z]}, "position": MOVE.tolist()}
    return {**world, "gravity": TURN.apply(file["gravity"]).tolist()}


def with_idle_contact(file: File, folder: Path) -> File:
    """Two faces with friction that never meet."""
    surfaces = [
        {"name": name, "box": ANYWHERE, "normal": [0.0, 0.0, z]} for name, z in SIDES.items()
    ]
    contact = {"candidates": "top", "against": "bottom", "points": 20, "friction": 0.5}
    return {
        **file,
        "surfaces": surfaces,
        "contacts": [contact],
        "contact": {"alarm_distance": 2e-3},
    }


def heavier(file: File, folder: Path) -> File:
    """All masses, stiffnesses and limits of forces 16 times as large; its efforts are so, too."""
    material = {**file["material"], "young_modulus": 16e6, "density": 16e3}
    cables = [{**cable, "max_tension": 16.0 * cable["max_tension"]} for cable in file["cables"]]
    return {**file, "material": material, "cables": cables}


def toml(value: Any) -> str:
    """A value as a robot file has it."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name} = {toml(item)}" for name, item in value.items()) + "}"
    return "[" + ", ".join(map(toml, value)) + "]" if isinstance(value, list) else json.dumps(value)


@cache
def decided_alone(folder: Path) -> tuple[Array, Array, Array]:
    """What is decided for the beam as it is."""
    return decided(beam(folder), folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for all files."""
    return tmp_path_factory.mktemp("twins")


@pytest.mark.long
@pytest.mark.parametrize(
    ("twin", "efforts", "error"),
    [
        (glued, 1.0, 1e-8),
        (with_points_between, 1.0, 1e-8),
        (in_millimetres, 1.0, 1e-8),
        (only_part, 1.0, 0.0),
        (turned_part, 1.0, 1e-8),
        (with_idle_contact, 1.0, 0.0),
        (heavier, 16.0, 0.0),
    ],
)
def test_other_words_for_the_same_robot_lead_to_the_same_decisions(
    folder: Path, twin: Callable[[File, Path], File], efforts: float, error: float
) -> None:
    """Where nothing is rounded otherwise, no bit changes."""
    position, effort, way = decided_alone(folder)
    assert effort.max() > 1.0
    found = decided(twin(beam(folder), folder), folder, TURN if twin is turned_part else None)
    for other, one in zip(found, (position, efforts * effort, way), strict=True):
        np.testing.assert_allclose(other, one, rtol=0.0, atol=error * np.abs(one).max())


def on_a_table(world: File, turn: Rotation, move: Array) -> File:
    """A world whose part is above a table with friction, in other axes."""
    at = {
        "point": (turn.apply([0.0, 0.0, -0.008]) + move).tolist(),
        "normal": turn.apply([0, 0, 1]).tolist(),
    }
    touch = {
        "candidates": {"part": "part"},
        "against": "table",
        "points": "vertices",
        "friction": 0.4,
    }
    table = {"name": "table", "shape": "plane", "parameters": at}
    return {**world, "obstacles": [table], "contacts": [touch]}


@pytest.mark.long
def test_tangents_do_not_choose_how_a_robot_slides(folder: Path) -> None:
    """Its stiff end strikes the table with an edge, where forces are not unique: it slid 32 um elsewhere."""
    world = on_a_table(only_part(beam(folder), folder), Rotation.identity(), np.zeros(3))
    expected = decided(world, folder)
    turned = on_a_table(turned_part(beam(folder), folder), TURN, MOVE)
    for other, one in zip(decided(turned, folder, TURN), expected, strict=True):
        np.testing.assert_allclose(other, one, rtol=0.0, atol=1e-8 * np.abs(one).max())
