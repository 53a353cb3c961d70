"""The campaigns of `tauten reduce`: over the whole range of the actuators, and within shares of it."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from tauten.service.cli.terminal import progress_bar

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from tauten.model import Robot
    from tauten.reduction.campaign import Design, Ranges, Snapshots, TouchedRobot
    from tauten.reduction.state import Narrower


LONG = 600.0  # s, from which on a campaign is worth advice
SHORTER = {
    "exploring": "--design latin-hypercube --runs 10 --steps 10",
    "ramp": "a longer --step",
    "plackett-burman": "fewer --steps",
    "latin-hypercube": "fewer --runs, or fewer --steps",
}  # by the name of the design


@dataclass(frozen=True, slots=True, eq=False)
class Campaigns:
    """What the campaigns of one command have in common.

    Attributes:
        plain: the robot.
        spheres: the robot with spheres that press it; None: nothing does.
        design: name of the design, or a CSV file.
        step: of the ramp [m].
        ranges: of the other designs.
        runs: of the Latin hypercube.
        steps: of a run.
        seed: of random numbers.
        folder: of the saved chunks.
        workers: that compute.
    """

    plain: Robot
    spheres: TouchedRobot | None
    design: str
    step: float
    ranges: Ranges
    runs: int
    steps: int
    seed: int
    folder: Path
    workers: Workers

    @property
    def robot(self) -> Robot:
        """The robot that the campaigns move."""
        return self.plain if self.spheres is None else self.spheres.robot

    def whole(self) -> Snapshots:
        """All equilibria over the whole range, with a progress bar."""
        with progress_bar("snapshots") as report:
            return self._computed(report)

    def narrower(self, whole: Snapshots) -> Narrower | None:
        """Campaigns within a share of the positions of the whole range; None: the design has no such."""
        from tauten.reduction.campaign import narrowed

        if self.design.endswith(".csv"):
            return None
        reached = whole.position

        def within(share: float, report: Callable[[float, str], None]) -> Snapshots:
            plain, spheres = narrowed(self.plain, reached, share), self.spheres
            if spheres is not None:  # whose plain robot is that of the campaigns
                robot = narrowed(spheres.robot, reached, share)
                spheres = replace(spheres, robot=robot, plain=plain)
            close = replace(
                self,
                plain=plain,
                spheres=spheres,
                step=share * self.step,
                folder=self.folder / f"within-{100.0 * share:.0f}",
            )
            found = close._computed(report)
            return found.select(found.converged)

        return within

    def _computed(self, report: Callable[[float, str], None]) -> Snapshots:
        """All equilibria of the design; says before how long they take."""
        from tauten.reduction.campaign import run_campaign

        plan = self._plan(lambda _, what: report(0.0, what))
        runs = len(plan.runs)

        def announce(count: int, seconds: float) -> None:
            said = expected(count, seconds, self.workers.count(runs), self.shorter())
            typer.echo(f"{self.folder}: {said}", err=True)

        with self.workers.executor(runs) as executor:
            return run_campaign(self.robot, plan, self.folder, executor, report, announce)

    def shorter(self) -> str:
        """What makes the campaign shorter."""
        is_file = self.design.endswith(".csv")
        own = f"fewer loads in {self.design}" if is_file else SHORTER[self.design]
        if not self.plain.body.part_robots:
            return own
        return (
            "tauten reduce with the robot file of each part, whose bases the robot of parts takes "
            f'(controller.basis = "parts"), or {own}'
        )

    def _plan(self, report: Callable[[float, str], None]) -> Design:
        """The design."""
        from tauten.reduction.campaign import (
            DesignError,
            exploring,
            from_csv,
            latin_hypercube,
            plackett_burman,
            ramp,
        )

        name, robot = self.design, self.plain
        if name == "exploring":
            return exploring(self.robot, self.seed, self.spheres, report)
        if name == "ramp":
            return ramp(robot, self.step)
        if name == "plackett-burman":
            return plackett_burman(robot, self.ranges, self.steps)
        if name == "latin-hypercube":
            return latin_hypercube(robot, self.ranges, self.runs, self.seed, self.steps)
        if not name.endswith(".csv"):
            raise DesignError(
                f"no design {name!r}: allowed are exploring, ramp, plackett-burman, latin-hypercube and "
                "files that end in .csv"
            )
        return from_csv(robot, name)


@dataclass(frozen=True, slots=True)
class Workers:
    """What computes the equilibria of a campaign.

    Attributes:
        scheduler: address of that of a Dask cluster, instead of processes; None: these.
        most: number of processes; None: one for each processor.
    """

    scheduler: str | None
    most: int | None

    def count(self, runs: int) -> int | None:
        """How many work at the runs of a campaign, at most one at each; None: the scheduler knows."""
        return None if self.scheduler is not None else min(self.most or os.cpu_count() or 1, runs)

    def executor(self, runs: int) -> AbstractContextManager[Executor]:
        """A new executor for a number of runs."""
        from tauten.reduction.campaign import dask_cluster, processes

        if self.scheduler is not None:
            return dask_cluster(self.scheduler)
        return processes(self.count(runs) or 1)


def expected(count: int, seconds: float, workers: int | None, advice: str) -> str:
    """What is said of a campaign before it begins, whose equilibria take some time each [s].

    Without a number of workers a cluster of unknown size computes them; what takes long gets an advice.
    """
    total = count * seconds / (workers or 1)
    said = f"{count} equilibria of about {seconds:.2g} s each"
    said += f", {workers} at a time" if workers else ", divided by the workers of the cluster"
    said += f": about {duration(total)}"
    return f"{said}; shorter: {advice}" if total > LONG else said


def duration(seconds: float) -> str:
    """A time [s] with its unit, of one or two digits."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s"
