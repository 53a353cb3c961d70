"""Damaged robot files and meshes: each gives a robot, or one sentence that names the file.

Warnings are errors in the suite, so an overflow or a division by zero on the way is found as well.
"""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from support.robots.bodies import box_mesh

from benchmarks.robots.arm import ArmShape
from benchmarks.robots.make_manipulator import make_file, make_network
from tauten.model import MeshError, RobotFileError, load_robot
from tauten.model.numerics import FactorisationError

SIZE = (0.1, 0.02, 0.02)
ARM = ArmShape(length=0.16, sections=1, joints=3)
BODY: dict[str, Any] = {
    "name": "beam",
    "frame": "base",
    "gravity": [0.0, 0.0, -9.81],
    "mesh": {"file": "beam.vtu", "length_unit": "m"},
    "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
    "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}],
    "cables": [
        {
            "name": "tendon",
            "pull_point": [-0.01, 0.01, 0.002],
            "points": [[0.01, 0.01, 0.002], [0.09, 0.01, 0.002]],
            "min_tension": 0.0,
            "max_tension": 10.0,
            "min_pull": 0.0,
            "max_pull": 0.02,
            "max_rate": 0.05,
            "max_outside": 1e-3,
        }
    ],
    "effectors": [{"name": "tip", "point": [0.1, 0.01, 0.01], "max_outside": 1e-3}],
    "surfaces": [
        {
            "name": "top",
            "box": {"lower": [0.05, 0.0, 0.019], "upper": [0.1, 0.02, 0.021]},
            "normal": [0.0, 0.0, 1.0],
            "max_angle_deg": 45.0,
        },
        {"name": "bottom", "box": {"lower": [0.05, 0.0, -0.001], "upper": [0.1, 0.02, 0.001]}},
    ],
    "contacts": [{"candidates": "top", "against": "bottom", "points": 7}],
    "contact": {"alarm_distance": 1e-3, "tolerance": 5e-5},
    "integration": {"scheme": "implicit-euler", "rayleigh_mass": 0.1, "rayleigh_stiffness": 0.01},
    "controller": {"rate": 50.0, "regularisation": 1e-3},
    "service": {"release_time": 1.0, "target_timeout": 0.5},
}
HOSTILE = (
    float("nan"), float("inf"), 0, 0.0, -0.0, -1, 1, 2, True, 1e300, -1e300, 5e-324, 6e-15, 1e-9,
    1e9, 0.5, 10**30, 10**400, "", "top", "a\nb", "\0", "ü" * 300, [], {}, [[]], [1.0], [0.0] * 3,
    [1e300] * 3, [0.0, 0.0, 5e-324],
)  # fmt: skip


def places(tree: Any) -> list[tuple[Any, Any]]:
    """Every value of nested dicts and lists, as its container and its key."""
    found = []
    for key in list(tree) if isinstance(tree, dict) else range(len(tree)):
        found.append((tree, key))
        if isinstance(tree[key], dict | list):
            found += places(tree[key])
    return found


def damaged(tree: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """A copy with one to three values replaced, scaled, removed or repeated."""
    tree = copy.deepcopy(tree)
    for _ in range(rng.integers(1, 4)):
        found = places(tree)
        holder, key = found[rng.integers(len(found))]
        action = rng.integers(5)
        if action == 0:
            del holder[key]
        elif action == 1 and isinstance(holder, list):
            holder.append(copy.deepcopy(holder[key]))
        elif action == 2 and isinstance(holder[key], float):
            holder[key] *= float(10.0 ** rng.integers(-18, 19))
        elif action == 3 and isinstance(holder, dict):
            holder[f"{key}x"] = holder.pop(key)
        else:
            holder[key] = HOSTILE[rng.integers(len(HOSTILE))]
    return tree


def toml(value: Any) -> str:
    """A value as TOML, tables inline."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, dict):
        return (
            f"{{{', '.join(f'{json.dumps(key)} = {toml(item)}' for key, item in value.items())}}}"
        )
    return repr(value)


def toml_file(tree: dict[str, Any]) -> str:
    return "\n".join(f"{json.dumps(key)} = {toml(value)}" for key, value in tree.items())


def flipped(data: bytes, rng: np.random.Generator) -> bytes:
    """Some bytes replaced, mostly by such as numbers are made of, and sometimes the end cut off."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        byte = rng.choice(list(b"0123456789-+.eE ,")) if rng.random() < 0.8 else rng.integers(256)
        changed[rng.integers(len(changed))] = byte
    return bytes(changed[: rng.integers(1, len(changed))] if rng.random() < 0.2 else changed)


def load(path: Path) -> str:
    """Load a robot and take its first system; the sentence of a refusal, else "".

    A system that is not positive definite is a documented outcome of `linearise`.
    """
    try:
        robot = load_robot(path)
    except (RobotFileError, MeshError) as error:
        return str(error)
    state = robot.rest()
    assert np.isfinite(robot.rows(state).effectors.delta).all()
    try:
        assert robot.linearise(state).v_free.shape == (robot.n,)
    except FactorisationError as error:
        assert "\n" not in str(error)
    return ""


def body_file(folder: Path, rng: np.random.Generator) -> None:
    (folder / "robot.toml").write_text(toml_file(damaged(BODY, rng)))


def body_bytes(folder: Path, rng: np.random.Generator) -> None:
    (folder / "robot.toml").write_bytes(flipped(toml_file(BODY).encode(), rng))


def arm_file(folder: Path, rng: np.random.Generator) -> None:
    file = tomllib.loads(make_file(ARM, "small", 90))
    (folder / "manipulator.json").write_text(json.dumps(make_network(ARM)))
    (folder / "robot.toml").write_text(toml_file(damaged(file, rng)))


def arm_network(folder: Path, rng: np.random.Generator) -> None:
    network = damaged(json.loads(json.dumps(make_network(ARM))), rng)
    (folder / "manipulator.json").write_text(json.dumps(network))
    (folder / "robot.toml").write_text(make_file(ARM, "small", 90))


def mesh_arrays(folder: Path, rng: np.random.Generator) -> None:
    """A mesh with nodes moved or tetrahedra repeated, dropped or given other corners."""
    mesh = box_mesh(SIZE, (4, 2, 2))
    nodes, tets = mesh.nodes.copy(), mesh.tets.copy()
    for _ in range(rng.integers(1, 4)):
        action = rng.integers(5)
        if action == 0:
            value = HOSTILE[rng.integers(15)]
            nodes[rng.integers(len(nodes)), rng.integers(3)] = float(value)
        elif action == 1:
            tets = np.vstack([tets, rng.permutation(tets[rng.integers(len(tets))])])
        elif action == 2:
            tets = np.delete(tets, rng.integers(len(tets), size=rng.integers(1, 20)), axis=0)
        elif action == 3:
            corner = rng.choice([-1, 0, 1, len(nodes), 10**9, -(10**9)])
            tets[rng.integers(len(tets)), rng.integers(4)] = corner
        else:
            nodes *= 10.0 ** rng.integers(-3, 4)
    mesh_file(folder, nodes, tets)


def mesh_bytes(folder: Path, rng: np.random.Generator) -> None:
    mesh = box_mesh(SIZE, (4, 2, 2))
    kind = ("vtu", "vtk", "msh", "mesh", "inp")[rng.integers(5)]
    mesh_file(folder, mesh.nodes, mesh.tets, kind)
    path = folder / f"beam.{kind}"
    path.write_bytes(flipped(path.read_bytes(), rng))


def mesh_file(folder: Path, nodes: np.ndarray, tets: np.ndarray, kind: str = "vtu") -> None:
    mesh = meshio.Mesh(nodes, [("tetra", tets)])
    options = {
        "vtu": {"compression": None, "binary": False},
        "msh": {"file_format": "gmsh22", "binary": False},
        "vtk": {"binary": False},
    }
    mesh.write(folder / f"beam.{kind}", **options.get(kind, {}))
    file = {**BODY, "mesh": {"file": f"beam.{kind}"}}
    (folder / "robot.toml").write_text(toml_file(file))


def test_half_a_surrogate_pair_in_a_network_is_named(folder: Path) -> None:
    """JSON may hold one; no file in UTF-8 does."""
    network = json.loads(json.dumps(make_network(ARM)))
    (folder / "robot.toml").write_text(make_file(ARM, "small", 90))
    for place, found in (
        ("name", "discs.0.name"),
        ("x\ud800", r"discs.0.x\ud800: unknown"),
    ):
        changed = copy.deepcopy(network)
        changed["discs"][0][place] = "a\udfff"
        (folder / "manipulator.json").write_text(json.dumps(changed))
        sentence = load(folder / "robot.toml")
        assert found in sentence
        assert sentence.encode("utf-8")


DAMAGES = (body_file, body_bytes, arm_file, arm_network, mesh_arrays, mesh_bytes)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    mesh = box_mesh(SIZE, (4, 2, 2))
    mesh_file(tmp_path, mesh.nodes, mesh.tets)
    return tmp_path


def run(damage: Callable[[Path, np.random.Generator], None], folder: Path, cases: range) -> int:
    """Load the cases; of every kind of damage some are refused: how many."""
    refused = 0
    for case in cases:
        damage(folder, np.random.default_rng([DAMAGES.index(damage), case]))
        try:
            sentence = load(folder / "robot.toml")
        except Exception as error:
            raise AssertionError(f"case {case} of {damage.__name__}: {error!r}") from error
        assert "\n" not in sentence, f"case {case} of {damage.__name__}: {sentence}"
        assert not sentence or str(folder) in sentence, sentence
        refused += bool(sentence)
    assert refused
    return refused


@pytest.mark.long
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_files_give_a_robot_or_a_sentence(
    damage: Callable[[Path, np.random.Generator], None], folder: Path
) -> None:
    run(damage, folder, range(20))


@pytest.mark.parametrize(("damage", "case"), [(body_file, 1510), (arm_network, 314)])
def test_a_name_of_two_lines_and_a_disc_inside_out_are_a_sentence(
    damage: Callable[[Path, np.random.Generator], None], case: int, folder: Path
) -> None:
    run(damage, folder, range(case, case + 1))


@pytest.mark.slow
@pytest.mark.parametrize("damage", DAMAGES)
def test_many_damaged_files_give_a_robot_or_a_sentence(
    damage: Callable[[Path, np.random.Generator], None], folder: Path
) -> None:
    cases = range(20, 3000)
    assert run(damage, folder, cases) < len(cases), "and some are robots"
