"""`python -m benchmarks reduced-meshes`: full and reduced models on a mesh and its refinements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from benchmarks.steps.stages import StepTimes, time_steps
from tauten.model import load_robot, one_blas_thread
from tauten.reduction import ContactBasis
from tauten.reduction.contact import ReduceSettings, make_basis
from tauten.reduction.state import StateSettings, reduce_states, reduced_robot
from tauten.service.bench import (
    REACH,
    PathAccuracy,
    Sizes,
    path_accuracy,
    ramp_snapshots,
    reach_targets,
    sizes_of,
    unseen,
)
from tauten.service.process import HostInfo, Progress, host_info

RAMP_STEPS, FINE_STEPS = 200, 100  # equilibria of the training campaign; on refined meshes
FAST = 1000.0  # rate of the last column [Hz]


@dataclass(frozen=True, slots=True)
class MeshCase:
    """The automatic choice on one mesh: control steps of the full and the reduced model.

    Attributes:
        sizes: of the full model's problems.
        modes: state modes.
        elements: in the sample.
        training: along the training path, at states that took no part in it.
        full: steps of the full model.
        reduced: steps of the reduced model, same rate and targets.
        fast: the same at a higher rate.
        fast_hz: that rate.
    """

    sizes: Sizes
    modes: int
    elements: int
    training: PathAccuracy
    full: StepTimes
    reduced: StepTimes
    fast: StepTimes
    fast_hz: float


@dataclass(frozen=True, slots=True)
class ReducedMeshes:
    """Everything `python -m benchmarks reduced-meshes` measures."""

    machine: HostInfo
    robot: str
    meshes: tuple[MeshCase, ...]


def bench_reduced_meshes(
    robot_file: str,
    basis: ContactBasis,
    folder: Path,
    refinements: int,
    seconds: float,
    progress: Progress,
) -> ReducedMeshes:
    """Measure the automatic choice on a robot's own mesh and on its refinements.

    Args:
        robot_file: name or path.
        basis: contact basis of the robot's own mesh.
        folder: where campaigns are kept.
        refinements: how often the mesh is refined at most.
        seconds: of the path along what the cables reach.
        progress: called with the share of the work done and what comes next.
    """
    meshes = []
    with one_blas_thread():
        for count in range(refinements + 1):
            progress(0.0, f"mesh refined {count} times")
            meshes.append(run_mesh(robot_file, basis, folder, count, seconds))
            progress(1.0 / (refinements + 1))
    return ReducedMeshes(host_info(), load_robot(robot_file).name, tuple(meshes))


def run_mesh(
    robot_file: str, basis: ContactBasis, folder: Path, refinements: int, seconds: float
) -> MeshCase:
    """The automatic choice on one mesh.

    Args:
        robot_file: name or path.
        basis: contact basis of the robot's own mesh.
        folder: of the campaigns.
        refinements: of the mesh.
        seconds: duration of the path to follow.
    """
    robot = load_robot(robot_file, None, refinements)
    steps = FINE_STEPS if refinements else RAMP_STEPS
    training = ramp_snapshots(
        robot, folder / (f"ramp{refinements}" if refinements else "ramp"), steps
    )
    if refinements:
        basis, _ = make_basis(robot, training, ReduceSettings(k=basis.k))
    states = reduce_states(robot, training, basis, StateSettings())
    reduced, name = reduced_robot(robot, states), f"reduced, k = {basis.k}"
    targets = reach_targets(robot, seconds, REACH)
    quick = reduced_robot(load_robot(robot_file, FAST, refinements), states)
    return MeshCase(
        sizes=sizes_of(robot, basis.k),
        modes=states.r,
        elements=len(states.elements),
        training=path_accuracy(reduced, basis, unseen(training)),
        full=time_steps(robot, basis, name, targets),
        reduced=time_steps(reduced, basis, name, targets),
        fast=time_steps(quick, basis, name, reach_targets(quick, seconds, REACH)),
        fast_hz=FAST,
    )
