"""The robot files of `docs/coming_from/sofa`, beside meshes of the reference data (its README has them)."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np

from support.robots.bodies import box_mesh
from tauten.model import load_robot
from tauten.model.constraints import ConstrainedRobot
from tauten.model.numerics import Array
from tauten.model.tetra import TetRobot

FILES = Path(__file__).parents[3] / "docs" / "coming_from" / "sofa"


@dataclass(frozen=True, slots=True)
class Source:
    """Where the mesh of a port is in the reference data.

    Attributes:
        file: the file of a mesh, or the model that has its nodes.
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
    "gripper_finger": Source(
        "gripperfinger_model.npz", "pneunetCutCoarse.vtk", "pneunetCavityCut.stl"
    ),
    "pneunets": Source("pneunets_model.npz", "PneuNets.vtk", "PneuNets_Cavity.stl"),
    "tripod": Source("tripod_low_model.npz", "tripod_low.vtu", moved=(0.0, 30.0, 0.0)),
    "trunk": Source("trunk.vtk", "trunk.vtk"),
}


def port(data: Path, folder: Path, name: str) -> TetRobot | ConstrainedRobot:
    """The robot of a file of `docs/coming_from/sofa`.

    Args:
        data: the folder `sofa_robots` of the reference data.
        folder: where the file is copied to, beside its mesh.
        name: of the robot.
    """
    source = SOURCES[name]
    path = shutil.copy(FILES / f"{name}.toml", folder)
    if name == "finger":
        plate = box_mesh((200.0, 20.0, 100.0), (1, 1, 1))
        nodes = plate.nodes + np.array([-150.0, 40.0, -40.0])
        meshio.write_points_cells(folder / "plate.vtu", nodes, [("tetra", plate.tets)])
    if source.file.endswith(".npz"):
        write_meshes(np.load(data / source.file), folder, source)
    else:
        shutil.copy(data / source.file, folder / source.mesh)
    robot = load_robot(path)
    assert isinstance(robot, TetRobot | ConstrainedRobot)
    return robot


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
