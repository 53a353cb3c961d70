"""A robot file in other axes, mirrored, or with a mesh that is numbered otherwise: the same decisions."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tauten.controller import Controller, controller_setup
from tauten.model.load import shipped_folder
from tauten.model.numerics import Array

VECTORS = {
    "point",
    "points",
    "pull_point",
    "position",
    "gravity",
    "inside",
    "through",
    "normal",
    "start",
    "end",
}
AXES = {
    "turned": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
    "mirrored": [[-1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "oblique": Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix().tolist(),
}
TICKS = 4


def in_axes(value: Any, S: Array, numbers: int | None, folder: Path, name: str = "") -> Any:
    """What a robot file says, in other axes.

    Args:
        value: a table, a list or a value.
        S: (3, 3) rotation or reflection.
        numbers: seed of other numbers of nodes and elements; None: they stay.
        folder: where meshes are written.
        name: of the field.
    """
    if name in VECTORS:
        return (np.array(value, dtype=float) @ S.T).tolist()
    if name == "axis":  # angles about it are of the other sense in a mirror
        return (np.linalg.det(S) * (S @ value)).tolist()
    if name == "rotation":
        turn = Rotation.from_rotvec(np.deg2rad(value["angle_deg"]) * np.array(value["axis"]))
        x, y, z, w = Rotation.from_matrix(S @ turn.as_matrix() @ S.T).as_quat()
        return {"quaternion": [w, x, y, z]}
    if name == "file":
        mesh = meshio.read(shipped_folder() / value)
        order = np.arange(len(mesh.points))
        cells = [(block.type, block.data) for block in mesh.cells]
        if numbers is not None:
            rng = np.random.default_rng(numbers)
            order = rng.permutation(order)
            place = np.argsort(order)
            cells = [(kind, place[data][rng.permutation(len(data))]) for kind, data in cells]
        meshio.write(folder / value, meshio.Mesh(mesh.points[order] @ S.T, cells))
        return str(folder / value)
    if isinstance(value, list):
        return [in_axes(one, S, numbers, folder, name) for one in value]
    if not isinstance(value, dict):
        return value
    if {"lower", "upper"} <= value.keys():
        return turned_box(value, S)
    return {key: in_axes(one, S, numbers, folder, key) for key, one in value.items()}


def turned_box(box: dict[str, Any], S: Array) -> dict[str, Any]:
    """A box in other axes: what lies behind all of its faces."""
    faces = [
        {"kind": "half_space", "point": (S @ box[end]).tolist(), "normal": (sign * axis).tolist()}
        for end, sign in (("lower", 1.0), ("upper", -1.0))
        for axis in S.T
    ]
    for face in faces:  # nodes on a face remain within it
        face["point"] = (np.array(face["point"]) - 1e-9 * np.array(face["normal"])).tolist()
    kept = {key: value for key, value in box.items() if key not in ("kind", "lower", "upper")}
    return {**kept, "kind": "intersection", "of": faces}


def decided(name: str, S: Array, numbers: int | None, folder: Path) -> tuple[Array, Array]:
    """Positions and efforts (2 TICKS, n_a) for targets that are turned alike and move, then stay far away."""
    folder.mkdir()
    contents = tomllib.loads((shipped_folder() / f"{name}.toml").read_text(encoding="utf-8"))
    for effector in contents["effectors"]:
        effector.pop("weight", None)  # of components along axes
    other = in_axes(contents, S, numbers, folder)
    setup = controller_setup(other, folder / f"{name}.toml", basis="none", model="full")
    controller = Controller(setup.robot, setup.contact, settings=setup.controller)
    assert controller.settle_start().converged
    start, rng = controller.effector_values, np.random.default_rng(3)
    layout = controller.robot.effector_layout
    metres = np.where(layout.units == 1.0, 1.0, 0.1)  # of a row, whatever the axes are
    positions, efforts = [], []
    ways = [*(2e-3 * rng.standard_normal((TICKS, layout.n_rows)))]
    ways += TICKS * [0.01 * rng.standard_normal(layout.n_rows)]  # damping is adapted
    for way in ways:
        rows = (way.reshape(-1, 3) @ S.T).ravel() / metres
        assert controller.step(layout.moved(start, rows)).status.ok
        positions.append(controller.position)
        efforts.append(controller.effort)
    return np.array(positions), np.array(efforts)


SHORT = [("gripper", "mirrored"), ("gripper", "oblique"), ("tripod", "oblique")]
LONG = [*((name, axes) for name in ("diamond", "trunk") for axes in AXES), ("gripper", "turned")]


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "axes"),
    [*SHORT, *(pytest.param(*case, marks=pytest.mark.slow) for case in LONG)],
)
def test_neither_axes_nor_numbers_choose_decisions(name: str, axes: str, tmp_path: Path) -> None:
    """The gripper's fingers were one cluster or three by the first node of its mesh.

    In oblique axes its tensions were 27 % others, as what counts as small was a share of its bounding box,
    and so were the tripod's angles, for which a radian counted as the diagonal of that.
    """
    expected = decided(name, np.eye(3), None, tmp_path / "as_shipped")
    found = decided(name, np.array(AXES[axes], dtype=float), 5, tmp_path / "other")
    for other, one in zip(found, expected, strict=True):
        np.testing.assert_allclose(other, one, atol=1e-7 * np.abs(one).max())


def test_a_reduced_part_decides_the_same_wherever_it_stands(tmp_path: Path) -> None:
    """Its targets move beyond its reach, where decisions take little to become others.

    They once took a target to be another one by its largest coordinate, which is another one in other axes.
    """
    turn, place = Rotation.from_matrix(AXES["oblique"]), np.array([0.3, -0.2, 1.1])
    quaternion = turn.as_quat()[[3, 0, 1, 2]].tolist()
    gravity = turn.apply([0.0, 0.0, -9.81]).tolist()
    file = tmp_path / "turned.toml"
    file.write_text(
        f"""name = "turned"
gravity = {gravity}

[[parts]]
name = "one"
robot = "diamond"
rotation = {{ quaternion = {quaternion} }}
position = {place.tolist()}

[model]
order = "reduced"
""",
        encoding="utf-8",
    )
    controllers = [Controller.of(robot) for robot in ("diamond", file)]
    rest, size = controllers[0].effector[0], controllers[0].robot.part_size
    for tick in range(60):
        ahead = [np.sin(0.07 * tick), np.cos(0.05 * tick) - 1.0, 0.5 * np.sin(0.03 * tick)]
        goal = rest + 0.13 * size * np.array(ahead)
        targets = (goal, turn.apply(goal) + place)
        one, other = map(Controller.step, controllers, targets)
        np.testing.assert_allclose(other.effort, one.effort, rtol=0.0, atol=1e-6)  # of 8 N
    assert np.linalg.norm(controllers[0].effector[0] - goal) > 0.05 * size, "out of reach"
