"""`python -m benchmarks manipulator`: speed (the paper's Table II), contact (Fig. 11), accuracy (Fig. 12)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.manipulator.accuracy import PostureError, errors_over_k, posture_error
from benchmarks.manipulator.postures import bent_tensions, random_postures
from benchmarks.manipulator.speed import Speed, measure_speed, stage_times
from benchmarks.steps import StepTimes
from tauten.model import Robot, load_robot, one_blas_thread
from tauten.reduction import ContactBasis
from tauten.reduction.campaign import Ranges, Snapshots, plackett_burman, run_campaign
from tauten.service.bench import Comparison, Equilibrium, compare_equilibria, equilibrium
from tauten.service.process import HostInfo, Progress, host_info

ROBOTS = ("manipulator_1290", "manipulator")
STEPS = 120  # of a run of the campaign
_ON_THE_WAY = 6  # equilibria on the way to a posture that errors are measured at
_HELD_OUT, _SEED = 20, 1


@dataclass(frozen=True, slots=True)
class ArmBench:
    """Everything `python -m benchmarks manipulator` measures.

    Attributes:
        machine: on which.
        speed: Table II.
        stages: where the time of a reduced control step goes, 4,500 candidates, bent.
        contact: Fig. 11, the same tensions with and without contact.
        campaign: what the bases were made from.
        snapshots: of it, converged ones.
        shipped: errors of the shipped basis, certified.
        errors: Fig. 12.
    """

    machine: HostInfo
    speed: tuple[Speed, ...]
    stages: StepTimes
    contact: Comparison
    campaign: str
    snapshots: int
    shipped: tuple[PostureError, ...]
    errors: tuple[PostureError, ...]


@dataclass(frozen=True, slots=True)
class BentArm:
    """The bent arm with and without contact, for the figure."""

    robot: Robot
    touching: Equilibrium
    passing: Equilibrium


@dataclass(frozen=True, slots=True)
class ArmBenchSettings:
    """What to measure and where to put snapshots.

    Attributes:
        snapshots: folder that keeps campaigns; campaigns in it are not run again.
        ks: numbers of modes of Fig. 12.
    """

    snapshots: Path
    ks: tuple[int, ...]


def bench_manipulator(settings: ArmBenchSettings, progress: Progress) -> tuple[ArmBench, BentArm]:
    """Measure everything; campaigns come first and take longest.

    Args:
        settings: what and where.
        progress: called with the share of the work that has just been done.

    Returns:
        The numbers, and the bent arm whose contact they describe.
    """
    robot, shipped = load_robot("manipulator"), ContactBasis.load("manipulator")
    with one_blas_thread():
        campaign = campaign_of(robot, settings.snapshots / "manipulator")
        progress(0.2)
        held_out = run_campaign(
            robot,
            random_postures(robot, _HELD_OUT, _ON_THE_WAY, _SEED),
            settings.snapshots / "manipulator-held-out",
        )
        postures = {"training": thinned(campaign), "held-out": held_out}
        speed = speeds()
        stages = stage_times(robot, shipped, bent_tensions())
        progress(0.2)
        bent = bent_arm(robot)
        converged = campaign.select(campaign.converged)
        errors = errors_over_k(
            robot, shipped, converged, postures, settings.ks, lambda share: progress(0.6 * share)
        )
        own = [posture_error(robot, shipped, runs, name, True) for name, runs in postures.items()]
    result = ArmBench(
        machine=host_info(),
        speed=speed,
        stages=stages,
        contact=compare_equilibria(robot, bent.touching, bent.passing),
        campaign=campaign.origin.campaign,
        snapshots=len(converged),
        shipped=tuple(own),
        errors=errors,
    )
    return result, bent


def campaign_of(robot: Robot, folder: Path) -> Snapshots:
    """The paper's campaign: 12 Plackett-Burman runs of 120 steps, 1,440 snapshots.

    `tauten reduce manipulator --design plackett-burman --steps 120 --tension 0 1` does the same.
    """
    design = plackett_burman(robot, Ranges(tilt=0.0, force=0.0, effort=(0.0, 1.0)), STEPS)
    return run_campaign(robot, design, folder)


def thinned(campaign: Snapshots) -> Snapshots:
    """As few equilibria of each run as held-out postures have, the last one among them."""
    every = STEPS // _ON_THE_WAY
    return campaign.select(np.arange(every - 1, len(campaign), every))


def speeds() -> tuple[Speed, ...]:
    """Table II: both numbers of candidates, straight and bent."""
    found = []
    for name in ROBOTS:
        robot, basis = load_robot(name), ContactBasis.load(name)
        basis.check_robot(robot)
        for posture, effort in (("straight", np.zeros(robot.n_a)), ("bent", bent_tensions())):
            found.append(measure_speed(robot, basis, effort, posture))
    return tuple(found)


def bent_arm(robot: Robot) -> BentArm:
    """Fig. 11: the bent arm with and without contact."""
    effort = bent_tensions()
    passing = equilibrium(robot, "none", None, effort)
    touching = equilibrium(robot, "full", None, effort)
    return BentArm(robot, touching, passing)


def parse_ks(text: str) -> tuple[int, ...]:
    """Numbers of modes from "5,10,23".

    Raises:
        ValueError: not ascending positive numbers.
    """
    parts: Sequence[str] = text.split(",")
    if not all(part.strip().isdecimal() for part in parts):
        raise ValueError(f"modes are {text!r}, allowed are numbers joined by commas")
    ks = tuple(int(part) for part in parts)
    if ks[0] < 1 or any(b <= a for a, b in pairwise(ks)):
        raise ValueError(f"modes are {text!r}, allowed are ascending numbers from 1")
    return ks
