"""Designs of excitation: pulls, gravity and outer forces of the runs of a campaign.

The ramp is the paper's. The others start from a table of levels in [0, 1], a row for each run and a column
for each factor, and scale it to the ranges of the factors: the final pull of every cable, the tilt of
gravity about two axes, the force on every effector.
"""

from __future__ import annotations

import csv
import hashlib
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.model.schema import cause


class DesignError(ValueError):
    """A design that cannot be run; the text names what was found and what is allowed."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """Equilibria that follow one another, from rest.

    Attributes:
        position: (n_a, s) positions [m]; NaN where efforts are prescribed.
        gravity: (3, s) acceleration of gravity [m/s²].
        effector_force: (3 p, s) outer forces on the effectors [N].
        effort: (n_a, s) efforts prescribed instead of positions [N]; NaN where positions are.
        pressed: (3 k, s) centres of the spheres that press the robot [m], see
            `tauten.reduction.campaign.touched`; None: there are none.
    """

    position: Array
    gravity: Array
    effector_force: Array
    effort: Array | None = None
    pressed: Array | None = None

    def __len__(self) -> int:
        return int(self.position.shape[1])

    def piece(self, first: int, end: int) -> Run:
        """Equilibria first … end − 1."""
        part = slice(first, end)
        effort = None if self.effort is None else self.effort[:, part]
        pressed = None if self.pressed is None else self.pressed[:, part]
        return Run(
            self.position[:, part],
            self.gravity[:, part],
            self.effector_force[:, part],
            effort,
            pressed,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """Runs of a campaign, independent of each other.

    Attributes:
        description: one line for provenance.
        runs: the runs.
    """

    description: str
    runs: tuple[Run, ...]

    @property
    def size(self) -> int:
        """Number of equilibria."""
        return sum(len(run) for run in self.runs)

    def digest(self) -> str:
        """SHA-256 of all levels of all runs."""
        hasher = hashlib.sha256()
        for run in self.runs:
            more = [levels for levels in (run.effort, run.pressed) if levels is not None]
            for levels in (run.position, run.gravity, run.effector_force, *more):
                hasher.update(repr(levels.shape).encode())
                hasher.update(np.ascontiguousarray(levels).tobytes())
        return hasher.hexdigest()


@dataclass(frozen=True, slots=True)
class Ranges:
    """Values of the levels 0 and 1 of each factor.

    Attributes:
        position: (low, high) final pull as a share of a cable's largest one.
        tilt: gravity is turned by −tilt … tilt about both horizontal axes [rad]; 0 keeps it.
        force: every component of the force on an effector is −force … force [N]; 0 means no force.
        effort: (low, high) final tension as a share of a cable's largest one; where it is given, tensions
            are prescribed instead of pulled lengths, which suits antagonistic cables.
    """

    position: tuple[float, float] = (0.5, 1.0)
    tilt: float = np.pi / 2
    force: float = 0.2
    effort: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        low, high = self.position
        least, most = self.effort or (0.0, 0.0)
        good = 0.0 <= low <= high <= 1.0 and 0.0 <= least <= most <= 1.0
        if not good or min(self.tilt, self.force) < 0.0:
            held = "" if self.effort is None else f" tension {self.effort},"
            raise DesignError(
                f"ranges are pull {self.position},{held} tilt {self.tilt} rad, force {self.force} N: "
                "pull must be two shares of 0 to 1 in this order, tension too, the others not negative"
            )


def ramp(robot: Robot, step: float = 5e-5) -> Design:
    """One run a cable: pulled from rest to its limit in equal steps [m, rad, m³], as in the paper.

    Raises:
        DesignError: the step is not positive or beyond the largest pull.
    """
    limit = robot.limits.farthest_position  # (n_a,)
    nearest = int(np.abs(limit).argmin())
    least, units = abs(float(limit[nearest])), [one.position.unit for one in robot.actuators.kinds]
    if not 0.0 < step <= least:
        unit, name = units[nearest], robot.actuators.names[nearest]
        mixed = "; it is the step of all, whose units differ: take another design" * (
            len(set(units)) > 1
        )
        raise DesignError(
            f"ramp step is {step} {unit}: allowed are 0 to {least} {unit}, above 0, as far as {name} goes"
            + mixed
        )
    runs = []
    for cable in range(robot.n_a):
        steps = round(abs(float(limit[cable])) / step)
        final = np.zeros(robot.n_a)
        final[cable] = limit[cable]
        runs.append(
            _from_rest(final, robot.gravity, np.zeros(3 * len(robot.effector_names)), steps)
        )
    sizes = " + ".join(str(len(run)) for run in runs)
    return Design(f"ramp: each cable to its largest pull in {sizes} steps", tuple(runs))


def plackett_burman(robot: Robot, ranges: Ranges, steps: int = 100) -> Design:
    """Two-level screening design: all main effects of up to N − 1 factors from N runs.

    N = q + 1 with q the smallest prime of the form 4 i + 3 that is no less than the number of
    factors: 4, 8, 12, 20, 24, 32, … runs.

    Args:
        robot: its limits, gravity and effectors are used.
        ranges: of the factors.
        steps: equilibria in each run.

    Source: Plackett and Burman, Biometrika 33, 1946; the rows are shifted Legendre sequences
    (Paley's construction), which give their 12-, 20- and 24-run designs.
    """
    levels = plackett_burman_levels(_factor_count(robot, ranges))
    return _spread(robot, ranges, levels, steps, "Plackett-Burman")


def latin_hypercube(
    robot: Robot, ranges: Ranges, runs: int, seed: int = 0, steps: int = 100
) -> Design:
    """Random runs, every factor evenly stratified into as many classes as there are runs.

    Args:
        robot: its limits, gravity and effectors are used.
        ranges: of the factors.
        runs: number of runs.
        seed: of the random levels.
        steps: equilibria in each run.

    Raises:
        DesignError: fewer than one run.

    Source: McKay, Beckman, Conover, Technometrics 21, 1979.
    """
    if runs < 1:
        raise DesignError(f"a Latin hypercube of {runs} runs was requested: at least 1 is needed")
    levels = latin_hypercube_levels(runs, _factor_count(robot, ranges), seed)
    return _spread(robot, ranges, levels, steps, f"Latin hypercube, seed {seed}")


def plackett_burman_levels(factors: int) -> Array:
    """Levels 0 and 1: (N, factors); columns are balanced and orthogonal, the last row is all 0."""
    q = max(factors, 3)
    while q % 4 != 3 or any(q % p == 0 for p in range(3, int(q**0.5) + 1, 2)):
        q += 1
    squares = {i * i % q for i in range(1, q)}
    row = np.array([0.0 if i in squares else 1.0 for i in range(q)])
    shifted = np.array([np.roll(row, shift) for shift in range(q)])  # (q, q)
    levels: Array = np.vstack([shifted, np.zeros(q)])[:, :factors]
    return levels


def latin_hypercube_levels(runs: int, factors: int, seed: int) -> Array:
    """Levels (runs, factors) in [0, 1), one in each class of every factor, of low centred discrepancy."""
    from scipy.stats.qmc import (
        LatinHypercube,
    )  # here, because it is slow and not every process needs it

    sampler = LatinHypercube(
        factors, optimization="random-cd" if runs > 1 else None, seed=np.random.default_rng(seed)
    )
    levels: Array = sampler.random(runs)
    return levels


def _factor_count(robot: Robot, ranges: Ranges) -> int:
    forces = 3 * len(robot.effector_names) * (ranges.force > 0.0)
    return robot.n_a + 2 * (ranges.tilt > 0.0) + forces


def _spread(robot: Robot, ranges: Ranges, levels: Array, steps: int, name: str) -> Design:
    """Runs from levels (runs, factors) of cables, tilts, forces, in this order."""
    low, high = ranges.effort or ranges.position
    limit = robot.limits.effort_max if ranges.effort else robot.limits.farthest_position  # (n_a,)
    tilts = robot.n_a + 2 * (ranges.tilt > 0.0)  # where the columns of the tilts end
    gravity = robot.gravity
    axes = null_space(gravity[None])[:, :2]  # (3, 2) across gravity
    runs = []
    for row in levels:
        final = (low + (high - low) * row[: robot.n_a]) * limit
        turn = np.zeros(2)
        turn[: tilts - robot.n_a] = ranges.tilt * (2.0 * row[robot.n_a : tilts] - 1.0)
        force = np.zeros(3 * len(robot.effector_names))
        force[: len(row) - tilts] = ranges.force * (2.0 * row[tilts:] - 1.0)
        turned = Rotation.from_rotvec(axes @ turn).apply(gravity)
        runs.append(_from_rest(final, turned, force, steps, ranges.effort is not None))
    held = f"tension {low:g} to {high:g}, " if ranges.effort else ""
    varied = f"{held}tilt {np.degrees(ranges.tilt):.0f} deg, force {ranges.force} N"
    return Design(f"{name}: {len(runs)} runs of {steps} steps, {varied}", tuple(runs))


def _from_rest(final: Array, gravity: Array, force: Array, steps: int, effort: bool = False) -> Run:
    """Pulls or tensions from just above 0 to final (n_a,), gravity (3,) and force (3 p,) constant."""
    rise = np.outer(final, np.arange(1, steps + 1) / steps)  # (n_a, s)
    return Run(
        position=np.full_like(rise, np.nan) if effort else rise,
        gravity=np.tile(gravity[:, None], steps),
        effector_force=np.tile(force[:, None], steps),
        effort=rise if effort else None,
    )


def from_csv(robot: Robot, path: str | Path) -> Design:
    """Runs from a table with one equilibrium in each row.

    Columns: `run` (rows of equal value that follow one another are one run), `pull_CABLE` [m] for
    every cable, and optionally `gravity_x`, `gravity_y`, `gravity_z` [m/s²] (else the robot's)
    and `force_EFFECTOR_x`, … [N] (else 0).

    Raises:
        DesignError: unknown or missing columns, a field that is no finite number, a pull beyond the
            limits; names the file and the line.
    """
    path = Path(path)
    positions = [f"pull_{name}" for name in robot.actuators.names]
    gravities = [f"gravity_{axis}" for axis in "xyz"]
    forces = [f"force_{name}_{axis}" for name in robot.effector_names for axis in "xyz"]
    default = {
        **dict.fromkeys(forces, 0.0),
        **dict(zip(gravities, robot.gravity, strict=True)),
    }
    lines = _read(path, ["run", *positions], [*gravities, *forces])
    values = [default | _numbers(path, row, line) for row, line in enumerate(lines, start=2)]
    for row, value in enumerate(values, start=2):
        _check_position(robot, f"{path}, line {row}", np.array([value[name] for name in positions]))
    runs = []
    for _, group in groupby(range(len(lines)), key=lambda i: lines[i]["run"]):
        chosen = [values[i] for i in group]
        runs.append(Run(*(_table(chosen, names) for names in (positions, gravities, forces))))
    return Design(f"{path.name}: {len(runs)} runs", tuple(runs))


def _read(path: Path, required: list[str], optional: list[str]) -> list[dict[str, str]]:
    """Lines of a CSV file with a header, columns checked."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, restkey="(more fields than columns)", restval="")
            header = list(reader.fieldnames or [])
            lines = list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DesignError(f"{path}: cannot be read ({cause(error)})") from error
    missing = [name for name in required if name not in header]
    unknown = [name for name in header if name not in [*required, *optional]]
    if missing or unknown:
        raise DesignError(
            f"{path}: columns missing: {', '.join(missing) or 'none'}; "
            f"unknown: {', '.join(unknown) or 'none'}; "
            f"needed are {', '.join(required)}; allowed are {', '.join(optional)}"
        )
    if not lines:
        raise DesignError(f"{path}: has no rows, at least one is needed")
    return lines


def _numbers(path: Path, row: int, line: dict[str, str]) -> dict[str, float]:
    """Every field of a line but `run` as a finite number."""
    numbers = {}
    for name, text in line.items():
        if name == "run":
            continue
        try:
            numbers[name] = float(text)
        except (TypeError, ValueError):
            numbers[name] = np.nan
        if not np.isfinite(numbers[name]):
            raise DesignError(f"{path}, line {row}: {name} is {text!r}, expected a finite number")
    return numbers


def _check_position(robot: Robot, where: str, position: Array) -> None:
    low, high = robot.limits.position_min, robot.limits.position_max
    for i in np.flatnonzero((position < low) | (position > high)):
        raise DesignError(
            f"{where}: pull_{robot.actuators.names[i]} is {position[i]} m, "
            f"allowed are {low[i]} to {high[i]} m"
        )


def _table(rows: list[dict[str, float]], names: list[str]) -> Array:
    """Columns `names` of the rows: (len(names), len(rows))."""
    return np.array([[row[name] for row in rows] for name in names])
