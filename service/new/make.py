"""`tauten new`: mesh a part at several sizes, choose one, try its robot, write robot file and mesh.

Where the robot is held and where its cable runs is guessed once, on the finest mesh: guesses that follow
each mesh would compare different robots. Each mesh is moved and timed; what is written has been checked as
`tauten check` does it, so that both say the same of it.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import meshio
import numpy as np

from tauten.model import Robot, load_robot
from tauten.model.mesh import TetMesh
from tauten.model.numerics import FactorisationError
from tauten.model.schema import NAME, RobotFileError
from tauten.service.check import (
    DECISION,
    CheckSettings,
    RobotCheck,
    certified,
    check_robot,
    fits,
    rate_for,
)
from tauten.service.new.choice import LEAST_RATE, Trial, chosen_trial, compared, verdict
from tauten.service.new.guesses import Guess, guess_fields
from tauten.service.new.meshing import LARGE, CadPart, mesh_part
from tauten.service.new.part import PartError
from tauten.service.new.template import RATE, Values, cable_table, chamber_tables, robot_text
from tauten.service.new.trial import PRESSURE, Reached, inflated, pulled, step_time
from tauten.service.process import Interrupted, Progress, StopFlag

NODES = (300, 700, 1500, 3000)  # of the meshes that are compared
SPARE = 1.2  # how much longer a control step may take than in the trial
MESHING, MOVING, CHECKING = 0.2, 0.5, 0.3  # shares of the progress


@dataclass(frozen=True, slots=True)
class NewRobot:
    """What to make.

    Attributes:
        name: of the robot, its files and its folder.
        part: that becomes its body, from `read_part`.
        size: of the elements [m]; None: chosen by the differences of meshes.
        accuracy: largest difference of effort and tip to the finest mesh that is accepted.
        young: Young's modulus [Pa].
        chambers: whether closed cavities become chambers.
    """

    name: str
    part: CadPart
    size: float | None = None
    accuracy: float = 0.1
    young: float = 0.3e6
    chambers: bool = True

    @property
    def elements(self) -> int:
        """About how many elements the part needs at the size that is given; 0 where none is."""
        return 0 if self.size is None else self.part.tetrahedra(self.size)


@dataclass(frozen=True, slots=True)
class Made:
    """What was made.

    Attributes:
        file: the robot file.
        guess: what was guessed.
        trials: the meshes that were compared, coarse to fine.
        chosen: index of the one that was taken.
        check: of the robot file, as `tauten check` finds it.
        notes: sentences on what was changed or what to do next.
    """

    file: Path
    guess: Guess
    trials: tuple[Trial, ...]
    chosen: int
    check: RobotCheck
    notes: tuple[str, ...]

    @property
    def usable(self) -> bool:
        """Whether a controller can decide from where the robot starts."""
        return all(
            item.level != "wrong" for item in self.check.findings if item.subject == DECISION
        )


@dataclass(frozen=True, slots=True)
class _Draft:
    mesh: TetMesh
    text: str
    trial: Trial
    rate: float


def make_new_robot(new: NewRobot, folder: Path, stop: StopFlag, progress: Progress) -> Made:
    """Make the robot; nothing is written before everything is known.

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
    guess = guess_fields([mesh for _, mesh in meshes], new.chambers)
    drafts: list[_Draft] = []
    for number, (size, mesh) in enumerate(meshes, 1):
        progress(0.0, f"equilibria with elements of {1e3 * size:.3g} mm")
        try:
            with stop.interruptible():
                drafts.append(_draft(new, size, mesh, guess, drafts[-1].trial if drafts else None))
        except Interrupted:
            if not drafts:
                raise
            break
        except (PartError, RobotFileError, FactorisationError):
            if not drafts and number == len(meshes):
                raise
        progress(MOVING / len(meshes), "")
    least = drafts[-1].trial.reached.share  # coarser meshes may be moved farther than finer ones
    drafts = [_moved_less(new, guess, one, least) for one in drafts]
    trials = compared([draft.trial for draft in drafts])
    chosen = chosen_trial(trials, new.accuracy)
    draft = drafts[chosen]

    def checking(share: float, what: str = "") -> None:
        progress(CHECKING * share, what)

    file, check = write(folder, new.name, draft, stop, checking)
    notes = [
        *_notes(new, guess),
        verdict(trials, chosen, new.accuracy, file, check, part.kind != "tetrahedra"),
    ]
    return Made(file, guess, trials, chosen, check, tuple(notes))


def _notes(new: NewRobot, guess: Guess) -> Iterator[str]:
    """What was changed, and what was guessed."""
    if new.part.surface is not None and new.part.surface.note:
        yield f"{new.part.path}: the surface {new.part.surface.note}."
    if guess.cavities:
        volumes = ", ".join(f"{1e6 * one.volume:.3g} ml" for one in guess.cavities)
        yield (
            f"Closed cavities ({volumes}) became chambers; with --no-chambers they stay empty and a cable "
            "moves the part."
        )
    else:
        yield f"The cable spans {100.0 * guess.span:.0f} % of the {1e3 * guess.length:.3g} mm of the part."


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
        progress(MESHING / len(sizes), "")
    return meshes


def _draft(
    new: NewRobot, size: float, mesh: TetMesh, guess: Guess, coarser: Trial | None
) -> _Draft:
    """Try and describe the robot of one mesh."""
    share = 1.0 if coarser is None else coarser.reached.share
    values = _values(new, size, mesh, RATE)
    found = _reached(new, guess, values, mesh, share)
    actuators = _actuators(guess, found)
    step = np.nan
    if coarser is None or coarser.in_time:
        step = step_time(_robot(robot_text(values, guess, actuators), mesh, new.name))
    rate = min(RATE, rate_for(SPARE * step)) if fits(LEAST_RATE, step) else RATE
    text = robot_text(replace(values, rate=rate), guess, actuators)
    return _Draft(mesh, text, Trial(size, len(mesh.nodes), found, step), rate)


def _moved_less(new: NewRobot, guess: Guess, draft: _Draft, share: float) -> _Draft:
    """The same mesh, moved by no more than a share of the guess."""
    trial, mesh = draft.trial, draft.mesh
    if trial.reached.share <= share:
        return draft
    values = _values(new, trial.size, mesh, draft.rate)
    found = _reached(new, guess, values, mesh, share)
    text = robot_text(values, guess, _actuators(guess, found))
    return replace(draft, text=text, trial=replace(trial, reached=found))


def _values(new: NewRobot, size: float, mesh: TetMesh, rate: float) -> Values:
    """What the text says of a mesh with elements of some size [m], controlled at a rate [Hz]."""
    return Values(new.name, new.part.path.name, len(mesh.nodes), size, new.young, rate)


def _reached(new: NewRobot, guess: Guess, values: Values, mesh: TetMesh, share: float) -> Reached:
    """Where the guessed actuators take the robot of a mesh, by no more than a share of the guess."""
    robot = _robot(robot_text(values, guess, _free_actuators(new, guess)), mesh, new.name)
    if guess.cavities:
        return inflated(robot, guess, new.young, str(new.part.path), share)
    return pulled(robot, guess, str(new.part.path), share)


def _free_actuators(new: NewRobot, guess: Guess) -> str:
    """Tables of the guessed actuators whose limits no trial meets."""
    if guess.cavities:
        return chamber_tables(
            guess, PRESSURE * new.young, sum(one.volume for one in guess.cavities)
        )
    return cable_table(guess, 2.0 * guess.max_pull, 1e3)


def _actuators(guess: Guess, found: Reached) -> str:
    """Tables of the guessed actuators with the limits that were found."""
    if guess.cavities:
        return chamber_tables(guess, found.command, found.volume)
    return cable_table(guess, found.command, 4.0 * found.effort)


def _robot(text: str, mesh: TetMesh, name: str) -> Robot:
    """The robot of a text that has not been written yet.

    Raises:
        RobotFileError: what was guessed makes no robot.
    """
    with tempfile.TemporaryDirectory(prefix="tauten-") as folder:
        try:
            return load_robot(write_files(Path(folder), name, text, mesh))
        except RobotFileError as error:
            guessed = str(error).replace(f"{folder}/", "what was guessed for ")
            raise RobotFileError(f"{guessed}; turn or mend the part in CAD") from error


def write(
    folder: Path, name: str, draft: _Draft, stop: StopFlag, progress: Progress
) -> tuple[Path, RobotCheck]:
    """Write robot file, mesh and the error of the mesh; all or none. Returns the file and its check."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{folder.name}.", dir=folder.parent) as hidden:
        beside = Path(hidden, folder.name)  # which has the usual permissions
        beside.mkdir()
        written = write_files(beside, name, draft.text, draft.mesh)
        check = check_robot(CheckSettings(str(written)), stop, progress)
        if check.estimate is not None:
            with suppress(ValueError):  # nothing to compare
                certified(check.estimate, check.digest).save(written)
        beside.rename(folder)
    file = folder / f"{name}.toml"
    found = tuple(
        replace(item, advice=item.advice.replace(str(written), str(file)))
        for item in check.findings
    )
    return file, replace(check, findings=found)


def write_files(folder: Path, name: str, text: str, mesh: TetMesh) -> Path:
    """Write a robot file and its mesh into a folder that exists: the path of the robot file."""
    cells = [("tetra", mesh.tets)]
    meshio.Mesh(mesh.nodes, cells).write(folder / f"{name}.vtu", compression="zlib")
    file = folder / f"{name}.toml"
    file.write_text(text, encoding="utf-8")
    return file
