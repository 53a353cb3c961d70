"""What the distance of plant and model in a recorded run consists of.

The recorded actuation drives simulators of the robot, tick by tick and without delay:

    model   the recorded one: its decisions, its time steps, its state and contact bases
    A       full order, contact basis and time steps of the model
    B       as A, but with the time steps of the plant
    C       as the plant: pointwise contact, its time steps
    plant   the recorded one, which uses an actuation up to a tick after the model

so that model to A is the share of state reduction, A to B that of time, B to C that of the contact basis,
and C to plant that of the delay. Shares of state reduction and time may cancel, so model to B is given
too: all errors of the model but those of contact. What the model records is the end of a tick as it was
decided, with one linearisation; how far the model itself ends from it is in the share of state reduction.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.controller import load_contact, load_controller_settings, substeps_of
from tauten.model import Command, Simulator, default_enrichment, load_robot, one_blas_thread
from tauten.model.load import robot_path
from tauten.service.log import LogError, LogReader
from tauten.service.process import Progress
from tauten.service.replay.recorded_setup import recorded_setup
from tauten.service.replay.report import TrackingError, error, followed, held
from tauten.service.replay.run import RecordedRun, Series, read_run

TimeSteps = int | Literal["single", "converged"]


@dataclass(frozen=True, slots=True)
class Distances:
    """Shares of the distance of plant and model of the first effector, while following.

    Attributes:
        robot: its name.
        steps: the plant's time steps, "own", "single" or "converged".
        series: each share over time by its name [m]; those of the plant are empty without one.
    """

    robot: str
    steps: str
    series: dict[str, Series]

    def shares(self) -> dict[str, TrackingError]:
        """RMS and largest value of each share, by name."""
        return {name: error("point", one.value, np.zeros(0)) for name, one in self.series.items()}


def measure_distances(path: Path, recorded_paths: bool, progress: Progress) -> Distances:
    """Simulate a recorded run in three ways.

    Raises:
        LogError: no log, a damaged one, or none that fits the robot.
        RobotFileError, MeshError, BasisError: the robot cannot be used.
    """
    run, recorded = read_run(path), recorded_setup(path, LogReader(path).read_metadata())
    name = recorded.robot_file(recorded_paths)
    robot = load_robot(name, rate=recorded.description.rate)
    if run.position.value.shape[1:] != (robot.n_a,):
        raise LogError(
            f"{path}: {run.position.value.shape[1]} cables, robot {robot.name} has {robot.n_a}"
        )
    if run.model.value.shape[1] < 3:
        raise LogError(f"{path}: its first effector has no position, distances need one")
    contact = load_contact(robot, robot_path(name), recorded.contact_basis(recorded_paths))
    own = Simulator(robot, contact, default_enrichment(robot.tolerance))
    if isinstance(contact, str):
        own = Simulator(robot, contact)
    steps = substeps_of(robot, load_controller_settings(name))
    model_steps: TimeSteps = steps if steps > 0 else "single"
    effort = run.effort if run.plant_value("drive", "pull") == "tension" else None
    plant = Simulator(robot, "full")
    with one_blas_thread():
        if recorded.description.start == "settled":
            for simulator in (own, plant):
                simulator.settle_start()
        progress(0.3, "time steps of the model")
        as_model = simulated(own, run, model_steps, None)
        progress(0.3, "time steps of the plant")
        own.reset()
        timed = simulated(own, run, plant_steps(run), None)
        progress(0.4, "as the plant")
        as_plant = simulated(plant, run, plant_steps(run), effort)
    return distances(run, as_model, timed, as_plant)


def plant_steps(run: RecordedRun) -> TimeSteps:
    """Time steps of a run's plant: the number of its own in a period, or what they are."""
    kind = run.plant_value("steps", "single")
    if kind == "own":
        return int(run.plant_value("steps_per_period", "1"))
    return "converged" if kind == "converged" else "single"


def simulated(
    simulator: Simulator, run: RecordedRun, steps: TimeSteps, effort: Series | None
) -> Series:
    """First effector after each actuation (m, 3) [m].

    Actuators that a hold keeps by their effort, as of pressure, get their effort, the others their position.

    Args:
        simulator: at the start of the run.
        run: with its actuation.
        steps: so many of second order a period, along which actuators move evenly, or one of first order.
        effort: efforts that drive all actuators in place of that; None: they do not.
    """
    by_force = simulator.robot.actuators.laws.held_by_force | (effort is not None)
    efforts = run.effort if effort is None else effort
    positions = []
    for position, lam in zip(run.position.value, efforts.value, strict=True):
        lam = np.where(simulator.robot.actuators.laws.bilateral, lam, np.maximum(lam, 0.0))
        given = Command.either(by_force, position, lam)
        if isinstance(steps, int):
            simulator.move(given.position, given.effort, steps)
        else:
            simulator.step(given.position, given.effort, converged=steps == "converged")
        positions.append(simulator.effector[0])
    return Series(run.position.time, np.array(positions))


def distances(run: RecordedRun, as_model: Series, timed: Series, as_plant: Series) -> Distances:
    """Distances of a run and its simulations.

    Args:
        run: the run.
        as_model: simulated with the model's time steps and contact basis.
        timed: with the plant's time steps.
        as_plant: with pointwise contact too.
    """
    model = run.model
    before = Series(model.time[1:], model.value[:-1])
    after = Series(model.time[1:], model.value[1:])
    pairs = {
        "state reduction": (model, as_model),
        "time": (as_model, timed),
        "model without contact": (model, timed),
        "contact basis": (timed, as_plant),
        "delay": (run.plant, as_plant),
        "plant against model": (run.plant, model),
        "motion of the model in a tick": (after, before),
    }
    series = {name: apart(run, *pair) for name, pair in pairs.items()}
    return Distances(run.description.name, run.plant_value("steps", "single"), series)


def apart(run: RecordedRun, series: Series, other: Series) -> Series:
    """Distance of positions (m, 3 or more) from others [m], of which each is there until the next one.

    NaN while the run does not follow a goal.
    """
    difference = series.value[:, :3] - held(other.time, other.value[:, :3], series.time)
    distance = np.linalg.norm(difference, axis=1)
    return Series(series.time, np.where(followed(run, series.time), distance, np.nan))


def distance_rows(found: Distances) -> list[tuple[str, str]]:
    """Names and values with units, for a terminal."""
    rows = []
    for name, share in found.shares().items():
        values = (share.rms_mm, share.max_mm)
        text = " / ".join("-" if value is None else f"{value:.3f}" for value in values)
        rows.append((f"{name}, RMS / max", f"{text} mm"))
    return rows
