"""`tauten new`: mesh a part at several sizes, choose one by its error, write robot file and mesh.

Where the robot is held and where its cable runs is guessed once, on the finest mesh: guesses that follow
each mesh would compare different robots.
"""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import meshio
import numpy as np

from tauten.model import Robot, Simulator, load_robot
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array
from tauten.model.schema import NAME, RobotFileError
from tauten.service.new.guesses import Guess, guess_fields
from tauten.service.new.meshing import LARGE, CadPart, mesh_part
from tauten.service.new.part import PartError
from tauten.service.new.template import Values, robot_text
from tauten.service.process import Interrupted, Progress, StopFlag

NODES = (300, 700, 1500, 3000)  # of the meshes that are compared
PULL_SHARE = 0.5  # of the largest pull, where meshes are compared
LEAST_SHARE = (
    1.0 / 16.0
)  # of the guessed pull; a robot that cannot be pulled so far needs a look first
RATE = 50.0  # Hz
MOST = 0.8  # of the progress: the equilibria; the rest is meshing


@dataclass(frozen=True, slots=True)
class NewRobot:
    """What to make.

    Attributes:
        name: of the robot, its files and its folder.
        part: that becomes its body, from `read_part`.
        size: of the elements [m]; None: chosen by the error of the mesh.
        accuracy: largest difference of tension and tip to the finest mesh that is accepted.
        young: Young's modulus [Pa].
    """

    name: str
    part: CadPart
    size: float | None = None
    accuracy: float = 0.1
    young: float = 0.3e6

    @property
    def elements(self) -> int:
        """About how many elements the part needs at the size that is given; 0 where none is."""
        return 0 if self.size is None else self.part.tetrahedra(self.size)


@dataclass(frozen=True, slots=True)
class Trial:
    """One mesh of the part, pulled half way.

    Attributes:
        size: of its elements [m].
        nodes: of the mesh.
        effort: [N].
        tip: (3,) [m].
        share: of the guessed pull that has an equilibrium.
        error: difference of tension or tip to the finest mesh, the larger of both, relative to the tension
            and to the movement of the tip.
    """

    size: float
    nodes: int
    effort: float
    tip: Array
    share: float
    error: float = np.nan


@dataclass(frozen=True, slots=True)
class Made:
    """What was made.

    Attributes:
        file: the robot file.
        trials: the meshes that were compared, coarse to fine.
        chosen: index of the one that was taken.
        note: what was changed in the surface; "" for nothing.
    """

    file: Path
    trials: tuple[Trial, ...]
    chosen: int
    note: str


@dataclass(frozen=True, slots=True)
class _Draft:
    mesh: TetMesh
    text: str
    trial: Trial


def make_new_robot(new: NewRobot, folder: Path, stop: StopFlag, progress: Progress) -> Made:
    """Make the robot; nothing is written before everything is known.

    Args:
        new: what to make.
        folder: folder to write to, which must not exist.
        stop: ends the work; the meshes whose equilibria are done are compared.
        progress: called with the share of the work just done, and what comes next.

    Raises:
        PartError: the name is not allowed, the folder exists, the part cannot be meshed, or the robot has no
            equilibrium.
        MeshError: the mesh cannot be used.
        Interrupted: stopped before there is one; nothing is written.
    """
    if not re.fullmatch(NAME, new.name):
        raise PartError(
            f"the name is {new.name[:40]!r}: allowed are a letter, then letters, digits and _"
        )
    if folder.exists():
        raise PartError(f"{folder}: exists already; choose another name, or delete it")
    part = new.part
    sizes = [part.size_for(nodes) for nodes in NODES] if new.size is None else [new.size]
    if part.kind == "tetrahedra":
        sizes = [part.size_for(len(mesh_part(part, 1.0).nodes))]
    meshes = _meshes(part, sizes, stop, progress)
    guess = guess_fields(meshes[-1][1])
    drafts: list[_Draft] = []
    for number, (size, mesh) in enumerate(meshes, 1):
        progress(0.0, f"equilibria with elements of {1e3 * size:.3g} mm")
        try:
            with stop.interruptible():
                drafts.append(_draft(new, size, mesh, guess))
        except Interrupted:
            if not drafts:
                raise
            break
        except (PartError, RobotFileError):
            if not drafts and number == len(meshes):
                raise
        progress(MOST / len(meshes), "")
    trials = compared([draft.trial for draft in drafts])
    good = [i for i, trial in enumerate(trials) if trial.error <= new.accuracy]
    chosen = good[0] if good else len(trials) - 1
    file = write(folder, new.name, drafts[chosen])
    return Made(file, trials, chosen, part.surface.note if part.surface else "")


def compared(trials: list[Trial]) -> tuple[Trial, ...]:
    """The trials with their errors against the last, which has an error of its own only as an estimate.

    A trial that was pulled less far than the finest has no error.

    Halving the elements reduces the error of smoothed elements to about a third, so that the finest has
    about half of the last difference.

    Args:
        trials: coarse to fine.
    """
    finest = trials[-1]
    moved = max(float(np.linalg.norm(finest.tip)), 1e-9)
    errors = [
        max(
            abs(trial.effort / finest.effort - 1.0),
            float(np.linalg.norm(trial.tip - finest.tip)) / moved,
        )
        if trial.share == finest.share
        else np.nan
        for trial in trials
    ]
    errors[-1] = 0.5 * errors[-2] if len(trials) > 1 else np.nan
    return tuple(replace(one, error=error) for one, error in zip(trials, errors, strict=True))


def _meshes(
    part: CadPart, sizes: list[float], stop: StopFlag, progress: Progress
) -> list[tuple[float, TetMesh]]:
    """Element sizes and meshes of the part, coarse to fine; without those that the mesher cannot make."""
    meshes: list[tuple[float, TetMesh]] = []
    for size in sizes:
        if part.tetrahedra(size) > 10 * LARGE:
            raise PartError(
                f"{part.path}: elements of {1e3 * size:.3g} mm make about {part.tetrahedra(size)} "
                f"tetrahedra; choose a --size above {1e3 * part.size_for(50_000):.3g} mm"
            )
        progress(0.0, f"mesh of elements of {1e3 * size:.3g} mm")
        try:
            with stop.interruptible():
                meshes.append((size, mesh_part(part, size)))
        except PartError:
            if not meshes and size == sizes[-1]:
                raise
        progress((1.0 - MOST) / len(sizes), "")
    return meshes


def _draft(new: NewRobot, size: float, mesh: TetMesh, guess: Guess) -> _Draft:
    """Try and describe the robot of one mesh."""
    part = new.part
    first = Values(new.name, part.path.name, len(mesh.nodes), size, new.young, 1e3, RATE)
    robot = _robot(robot_text(first, guess, guess.max_pull), mesh, new.name)
    share, effort, tip = _pulled(robot, guess)
    if share < LEAST_SHARE:
        raise PartError(
            f"{part.path}: the guessed cable finds no equilibrium at "
            f"{1e3 * LEAST_SHARE * guess.max_pull:.2g} mm of pull; turn the part so that its longest side "
            "runs from where it is held to its tip"
        )
    values = Values(new.name, part.path.name, len(mesh.nodes), size, new.young, 4.0 * effort, RATE)
    text = robot_text(values, guess, share * guess.max_pull)
    return _Draft(mesh, text, Trial(size, len(mesh.nodes), effort, tip, share))


def _robot(text: str, mesh: TetMesh, name: str) -> Robot:
    """The robot of a text that has not been written yet."""
    with tempfile.TemporaryDirectory(prefix="tauten-") as folder:
        return load_robot(write_files(Path(folder), name, text, mesh))


def _pulled(robot: Robot, guess: Guess) -> tuple[float, float, Array]:
    """Share of the guessed pull that has an equilibrium, tension and movement of the tip half way there."""
    share = 1.0
    while share >= LEAST_SHARE:
        sim = Simulator(robot, contact="none")
        rest = sim.settle(position=[0.0])
        start = sim.effector[0]
        half = sim.settle(position=[PULL_SHARE * share * guess.max_pull])
        effort, tip = float(sim.effort[0]), sim.effector[0] - start
        whole = sim.settle(position=[share * guess.max_pull])
        if rest.converged and half.converged and whole.converged:
            return share, effort, tip
        share *= 0.5
    return 0.0, np.nan, np.full(3, np.nan)


def write(folder: Path, name: str, draft: _Draft) -> Path:
    """Write robot file and mesh; both or none.

    Args:
        folder: to make.
        name: of the files.
        draft: their contents.
    """
    partial = folder.with_name(f".{folder.name}.partial")
    partial.mkdir(parents=True)
    try:
        write_files(partial, name, draft.text, draft.mesh)
        partial.rename(folder)
    finally:
        if partial.exists():
            for left in partial.iterdir():
                left.unlink()
            partial.rmdir()
    return folder / f"{name}.toml"


def write_files(folder: Path, name: str, text: str, mesh: TetMesh) -> Path:
    """Write a robot file and its mesh into a folder that exists: the path of the robot file.

    Args:
        folder: where.
        name: of both files.
        text: of the robot file.
        mesh: the body [m].
    """
    cells = [("tetra", mesh.tets)]
    meshio.Mesh(mesh.nodes, cells).write(folder / f"{name}.vtu", compression="zlib")
    file = folder / f"{name}.toml"
    file.write_text(text, encoding="utf-8")
    return file
