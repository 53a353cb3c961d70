"""The robot files in `coming_from/sofa` with the meshes of the reference data."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import meshio
import numpy as np

from tauten.model import Robot, Simulator, load_robot
from tauten.model.numerics import Array

FILES = Path(__file__).resolve().parents[1] / "coming_from" / "sofa"
MM = 1e-3


@dataclass(frozen=True, slots=True)
class Source:
    """Where the mesh of a robot is in the data.

    Attributes:
        file: the file of the mesh, or the model that has its nodes.
        mesh: name that the robot file has for it.
        surface: name that the robot file has for the surface of its chamber; "": it has no chamber.
        moved: (3,) what the scene moves the mesh by, after a turn by 90° about x [mm]; None: it does not.
    """

    file: str
    mesh: str
    surface: str = ""
    moved: tuple[float, float, float] | None = None


SOURCES = {
    "accordion": Source("accordion_model.npz", "Springy.vtk", "Springy_Cavity.stl"),
    "diamond": Source("diamond.vtu", "diamond.vtu"),
    "finger": Source("../softrobots_finger.vtk", "finger.vtk"),
    "gripper_finger": Source("gripperfinger_model.npz", "pneunetCutCoarse.vtk", "pneunetCavityCut.stl"),
    "pneunets": Source("pneunets_model.npz", "PneuNets.vtk", "PneuNets_Cavity.stl"),
    "tripod": Source("tripod_low_model.npz", "tripod_low.vtu", moved=(0.0, 30.0, 0.0)),
    "trunk": Source("trunk.vtk", "trunk.vtk"),
}  # fmt: skip


def port(data: Path, folder: Path, name: str) -> Robot:
    """The robot of a file of `coming_from/sofa`.

    Args:
        data: with the meshes.
        folder: where the file is copied to, beside its mesh.
        name: of the robot.
    """
    source = SOURCES[name]
    path = shutil.copy(FILES / f"{name}.toml", folder)
    if source.file.endswith(".npz"):
        write_meshes(np.load(data / source.file), folder, source)
    else:
        shutil.copy(data / source.file, folder / source.mesh)
    return load_robot(path)


def write_meshes(model: Any, folder: Path, source: Source) -> None:
    """Write the mesh of a model as SOFA loads it, and the surface of its chamber."""
    nodes: Array = model["nodes"]
    if source.moved is not None:
        x, y, z = (nodes - source.moved).T
        nodes = np.stack([x, z, -y], axis=1)  # turned back about x
    cells = [("tetra", model["tets"].astype(np.int64))]
    meshio.write_points_cells(folder / source.mesh, nodes, cells)
    if source.surface:
        triangles = [("triangle", model["cavity_triangles"].astype(np.int64))]
        meshio.write_points_cells(folder / source.surface, model["cavity_nodes"], triangles)


def settled(
    robot: Robot, commands: list[tuple[Array, Array]], contact: Literal["none", "full"] = "none"
) -> tuple[Array, Array, Array]:
    """Tips (s, 3) [mm], efforts (s, n_a) and positions (s, n_a) under pairs of positions and efforts."""
    simulator, found = Simulator(robot, contact=contact), []
    for position, effort in commands:
        if not simulator.settle(position, effort, tolerance=1e-9).converged:
            raise RuntimeError(f"{robot.name}: no equilibrium at {position}, {effort}")
        found.append((simulator.effector[0] / MM, simulator.effort, simulator.position))
    tip, lam, delta = (np.array(part) for part in zip(*found, strict=True))
    return tip, lam, delta
