"""Tetrahedra for a part: netgen in a process of its own, or those that the file already holds.

A mesher that does not like its input may crash or never end; in a process of its own that costs nothing but
a message.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from tauten.model.mesh import (
    UNITS,
    TetMesh,
    checked,
    mean_ratios,
    oriented,
    read_mesh,
    require_size,
)
from tauten.model.numerics import Array
from tauten.service.new.part import (
    Kind,
    PartError,
    Surface,
    kind_of,
    read_outside,
    read_surface,
)
from tauten.service.process import Progress

TIME_LIMIT = 600.0  # s
LEAST_QUALITY = 0.1  # mean ratio of the worst element that is accepted
LARGE = 200_000  # tetrahedra; more are asked about first
PER_CUBE = 8.5  # tetrahedra in a cube of the element size, as netgen makes them


@dataclass(frozen=True, slots=True)
class CadPart:
    """A part that has been read and checked.

    Attributes:
        path: its file.
        kind: what is meshed, or tetrahedra as they are.
        unit: of its coordinates.
        volume: [m³].
        surface: where the file holds one.
        repair: whether the mesher that closes holes is used.
    """

    path: Path
    kind: Kind
    unit: str
    volume: float
    surface: Surface | None = None
    repair: bool = False

    def tetrahedra(self, size: float) -> int:
        """About how many elements of this size [m] the part needs."""
        return int(PER_CUBE * self.volume / size**3)

    def size_for(self, nodes: int) -> float:
        """Element size [m] that gives about this number of nodes."""
        return float((PER_CUBE * self.volume / (4.0 * nodes)) ** (1.0 / 3.0))


def read_part(
    path: Path, unit: str, repair: bool, progress: Progress = lambda share, what="": None
) -> CadPart:
    """Read a part and refuse what cannot be meshed.

    Args:
        path: STL, OBJ, PLY, STEP, BREP, or a file with tetrahedra.
        unit: of its coordinates.
        repair: whether holes and crossings of a surface, or of the outside of tetrahedra, are left to the
            mesher.
        progress: called with the share of the work just done, and what is done.

    Raises:
        PartError: no such file, a surface that is not closed, an assembly, a missing extra.
        MeshError: the tetrahedra of the file cannot be used, or no desktop robot is as large in this unit.
    """
    if not path.is_file():
        raise PartError(
            f"{path}: " + ("is a folder, expected a file" if path.is_dir() else "no such file")
        )
    kind, scale = kind_of(path), UNITS[unit]
    if kind == "tetrahedra" and not repair:
        mesh = read_mesh(path, unit)
        require_size(mesh.nodes, 1.0, str(path), "--unit")
        return CadPart(path, kind, unit, float(mesh.volumes.sum()))
    if repair and kind == "solid":
        raise PartError(f"{path}: --repair is for surfaces (STL, OBJ, PLY) and tetrahedra")
    _require("wildmeshing" if repair else "netgen", "repair" if repair else "mesh")
    if kind != "solid":
        outside = kind == "tetrahedra"
        surface = read_outside(path) if outside else read_surface(path, repair, progress)
        volume, points = abs(surface.volume), surface.vertices
    else:
        surface = None
        volume, points = _solid_facts(path)
    require_size(points, scale, str(path), "--unit")
    meshed: Kind = "solid" if surface is None else "surface"
    part = CadPart(path, meshed, unit, volume * scale**3, surface, repair)
    if not part.volume > 0.0:
        raise PartError(f"{path}: encloses no volume")
    return part


def _require(module: str, extra: str) -> None:
    if importlib.util.find_spec(module) is None:
        raise PartError(
            f"{module} is not installed; run pip install -e '.[{extra}]' in the clone of tauten"
        )


def mesh_part(part: CadPart, size: float) -> TetMesh:
    """Tetrahedra of about one size, which is that of their longest edge [m].

    Raises:
        PartError: the mesher fails, or its worst element is below `LEAST_QUALITY`.
        MeshError: its mesh cannot be used.
    """
    if part.kind == "tetrahedra":
        return read_mesh(part.path, part.unit)
    scale = UNITS[part.unit]
    with tempfile.TemporaryDirectory(prefix="tauten-") as folder:
        source = part.path
        if part.surface is not None:
            source = Path(folder) / "surface.stl"
            cells = [("triangle", part.surface.triangles)]
            meshio.write(source, meshio.Mesh(part.surface.vertices, cells), binary=True)
        made = Path(folder) / "mesh.npz"
        which = "repair" if part.repair else part.kind
        _run([which, str(source.resolve()), str(size / scale), str(made)], part.path)
        arrays = np.load(made)
        nodes, tets = arrays["nodes"] * scale, arrays["tets"].astype(np.int64)
    mesh = checked(nodes, oriented(nodes, tets), str(part.path))
    worst = float(mean_ratios(mesh).min())
    if worst < LEAST_QUALITY:
        raise PartError(
            f"{part.path}: the worst of {len(tets)} elements has a mean ratio of {worst:.2f}, allowed is "
            f"{LEAST_QUALITY:g}; choose another --size than {1e3 * size:.3g} mm, or remove small "
            "details in CAD"
        )
    return mesh


def _solid_facts(path: Path) -> tuple[float, Array]:
    """Volume and bounding box (2, 3) of the one solid in a file, in the unit of the file."""
    with tempfile.TemporaryDirectory(prefix="tauten-") as folder:
        made = Path(folder) / "facts.npz"
        _run(["facts", str(path.resolve()), "1", str(made)], path)
        facts = np.load(made)
        solids = int(facts["solids"])
        if solids == 0:
            raise PartError(
                f"{path}: holds no solid; export the part as a solid, not as faces or curves"
            )
        if solids != 1:
            raise PartError(
                f"{path}: holds {solids} solids, one is needed; unite the parts of the assembly in CAD, or "
                "export one part"
            )
        return float(facts["volume"]), facts["box"]


def _run(arguments: list[str], path: Path) -> None:
    """Run the mesher's process; its last line of output is the reason where it fails.

    It has a process group of its own, which ends with whatever ends this function: a mesher in C++ hears
    no signal.
    """
    # as a file: a module would import all of tauten first, which it does not need
    script = Path(__file__).with_name("mesher.py")
    ended = threading.Event()
    meshers: list[subprocess.Popen[str]] = []

    def mesh() -> tuple[str, str]:
        mesher = subprocess.Popen(
            [sys.executable, "-P", str(script), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            cwd=Path(arguments[-1]).parent,  # fTetWild writes files of its own there
            start_new_session=True,
        )
        meshers.append(mesher)
        if ended.is_set():
            os.killpg(mesher.pid, signal.SIGKILL)
        return mesher.communicate(timeout=TIME_LIMIT)

    # Ctrl-C raises its exception in the main thread alone: where it meets a process that is only starting,
    # nobody would know which one to end
    with ThreadPoolExecutor(1) as thread:
        try:
            out, err = thread.submit(mesh).result()
        except subprocess.TimeoutExpired as error:
            raise PartError(
                f"{path}: meshing took more than {TIME_LIMIT:g} s; choose a larger --size"
            ) from error
        finally:
            ended.set()
            if meshers and meshers[0].poll() is None:
                os.killpg(meshers[0].pid, signal.SIGKILL)
    mesher = meshers[0]
    if mesher.returncode != 0 or not Path(arguments[-1]).is_file():
        lines = (err.strip() or out.strip()).splitlines()
        reason = lines[-1] if lines else f"it ended with code {mesher.returncode}"
        if arguments[0] == "facts":
            raise PartError(f"{path}: not readable as a solid ({reason}); export it again from CAD")
        advice = "choose another --size, or mend the part in CAD"
        if arguments[0] == "surface":
            advice += ", or use --repair"
        if arguments[0] == "solid":
            advice += ", or export it as STL and use --repair"
        raise PartError(f"{path}: the mesher fails ({reason}); {advice}")
