"""What the distance of plant and model in a recorded run consists of.

The recorded actuation drives simulators of the robot, tick by tick and without delay:

    model   the recorded one: its decisions, one linearisation a step, its state and contact bases
    A       full order, contact basis of the model, one linearisation a step
    B       as A, but every step iterated to convergence
    C       as the plant: pointwise contact, its time steps
    plant   the recorded one, which uses an actuation up to a tick after the model

so that model to A is the share of state reduction, A to B that of linearisation, A (or B, where the plant's
steps are converged) to C that of the contact basis, and C to plant that of the delay. Shares of state
reduction and linearisation may cancel in part, so model to B is given too: all errors of the model in time.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tauten.model import Simulator, default_enrichment, load_robot
from tauten.model.load import robot_path
from tauten.service.log import LogError, LogReader
from tauten.service.process import Progress, one_blas_thread
from tauten.service.replay.recorded_setup import recorded_setup
from tauten.service.replay.report import TrackingError, error, held
from tauten.service.replay.run import RecordedRun, Series, read_run
from tauten.service.setup import load_contact


@dataclass(frozen=True, slots=True)
class Distances:
    """Shares of the distance of plant and model of the first effector, while following.

    Attributes:
        robot: its name.
        steps: the plant's time steps, "single" or "converged".
        linearisation: model without state reduction against converged steps [m].
        reduction: recorded model against the same with all degrees of freedom [m].
        model: recorded model against converged steps with all degrees of freedom [m].
        contact_basis: with the model's contact basis against pointwise contact [m].
        delay: the plant against the simulation of it without delay [m]; empty without plant.
        total: the plant against the model [m]; empty without plant.
        tick: how far the model moves from one tick to the next [m].
    """

    robot: str
    steps: str
    linearisation: Series
    reduction: Series
    model: Series
    contact_basis: Series
    delay: Series
    total: Series
    tick: Series

    def shares(self) -> dict[str, TrackingError]:
        """RMS and largest value of each share, by name."""
        named = {
            "linearisation": self.linearisation,
            "state reduction": self.reduction,
            "model against converged steps": self.model,
            "contact basis": self.contact_basis,
            "delay": self.delay,
            "plant against model": self.total,
            "motion of the model in a tick": self.tick,
        }
        return {name: error("point", series.value, np.zeros(0)) for name, series in named.items()}


def measure_distances(path: Path, recorded_paths: bool, progress: Progress) -> Distances:
    """Simulate a recorded run in three ways.

    Args:
        path: log of `tauten serve --record` or `tauten demo`.
        recorded_paths: as for `replay`.
        progress: called with the share of the work that is about to be done, and what it is.

    Raises:
        LogError: no log, a damaged one, or none that fits the robot.
        RobotFileError, MeshError, BasisError: the robot cannot be used.
    """
    run, recorded = read_run(path), recorded_setup(path, LogReader(path).read_metadata())
    name = recorded.robot_file(recorded_paths)
    robot = load_robot(name, rate=recorded.rate)
    if run.pull.value.shape[1:] != (robot.n_a,):
        raise LogError(
            f"{path}: {run.pull.value.shape[1]} cables, robot {robot.name} has {robot.n_a}"
        )
    if run.model.value.shape[1] < 3:
        raise LogError(f"{path}: its first effector has no position, distances need one")
    contact = load_contact(robot, robot_path(name), recorded.contact_basis(recorded_paths))
    own = Simulator(robot, contact, default_enrichment(robot.tolerance))
    if isinstance(contact, str):
        own = Simulator(robot, contact)
    converged = run.plant_value("steps", "single") == "converged"
    tension = run.tension if run.plant_value("drive", "pull") == "tension" else None
    plant = Simulator(robot, "full")
    with one_blas_thread():
        if recorded.start == "settled":
            for simulator in (own, plant):
                simulator.settle_start()
        progress(0.15, "one linearisation a step")
        single = simulated(own, run.pull, False, None)
        progress(0.5, "converged steps")
        own.reset()
        exact = simulated(own, run.pull, True, None)
        progress(0.35, "as the plant")
        as_plant = simulated(plant, run.pull, converged, tension)
    return distances(run, single, exact, as_plant)


def simulated(
    simulator: Simulator, pull: Series, converged: bool, tension: Series | None
) -> Series:
    """First effector after each actuation (m, 3) [m].

    Args:
        simulator: at the start of the run.
        pull: pulled lengths.
        converged: whether its steps are iterated.
        tension: tensions that drive it in place of the pulled lengths.
    """
    positions = []
    for values in pull.value if tension is None else tension.value:
        if tension is None:
            simulator.step(pull=values, converged=converged)
        else:
            simulator.step(tension=np.maximum(values, 0.0), converged=converged)
        positions.append(simulator.effector[0])
    return Series(pull.time, np.array(positions))


def distances(run: RecordedRun, single: Series, exact: Series, as_plant: Series) -> Distances:
    """Distances of a run and its simulations.

    Args:
        run: the run.
        single: simulated with one linearisation a step and the model's contact basis.
        exact: with converged steps.
        as_plant: with pointwise contact and the plant's steps.
    """
    steps = run.plant_value("steps", "single")
    nearest = exact if steps == "converged" else single
    model = run.model
    before = Series(model.time[1:], model.value[:-1])
    after = Series(model.time[1:], model.value[1:])
    return Distances(
        robot=run.robot,
        steps=steps,
        linearisation=apart(run, single, exact),
        reduction=apart(run, model, single),
        model=apart(run, model, exact),
        contact_basis=apart(run, nearest, as_plant),
        delay=apart(run, run.plant, as_plant),
        total=apart(run, run.plant, model),
        tick=apart(run, after, before),
    )


def apart(run: RecordedRun, series: Series, other: Series) -> Series:
    """Distance of one series from another, which is constant until its next value; NaN while not following.

    Args:
        run: with the ticks that followed a goal.
        series: (m, 3 or more) values that begin with positions [m].
        other: (k, 3 or more) values that begin with positions [m].
    """
    difference = series.value[:, :3] - held(other.time, other.value[:, :3], series.time)
    distance = np.linalg.norm(difference, axis=1)
    following = held(run.time, run.following[:, None].astype(float), series.time)[:, 0]
    return Series(series.time, np.where(following == 1.0, distance, np.nan))


def distance_rows(found: Distances) -> list[tuple[str, str]]:
    """Names and values with units, for a terminal."""
    rows = []
    for name, share in found.shares().items():
        values = (share.rms_mm, share.max_mm)
        text = " / ".join("-" if value is None else f"{value:.3f}" for value in values)
        rows.append((f"{name}, RMS / max", f"{text} mm"))
    return rows
