"""Designs of excitation: pulls, gravity and outer forces of the runs of a campaign.

The ramp is the paper's. The others start from a table of levels in [0, 1], a row for each run and a column
for each factor, and scale it to the ranges of the factors: the final pull of every cable, the tilt of
gravity about two axes, the force on every effector.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from tauten.model import Robot
from tauten.model.numerics import Array
from tauten.reduction.campaign.command_range import CommandRange, command_range

RAMP_STEPS = 200  # of one actuator whose position is commanded; the paper takes 800
EFFORT_STEPS = 60  # of one actuator whose effort is commanded
RUN_STEPS = 20  # of a run of several actuators
LEAST_RUNS, RUNS_EACH = 8, 2  # number of such runs, and more for each actuator
LEAST_LOADED_RUNS, LOADED_STEPS = 10, 10  # runs under other loads, and the steps of each
TILT = np.radians(20.0)  # of gravity there
PAYLOAD = 0.2  # on the effectors there, as a share of the weight
STANDARD_GRAVITY = 9.81  # m/s², by which payloads are chosen where a robot file has no gravity


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
    """

    position: Array
    gravity: Array
    effector_force: Array
    effort: Array | None = None

    def __len__(self) -> int:
        return int(self.position.shape[1])

    def piece(self, first: int, end: int) -> Run:
        """Equilibria first … end − 1."""
        part = slice(first, end)
        effort = None if self.effort is None else self.effort[:, part]
        return Run(
            self.position[:, part], self.gravity[:, part], self.effector_force[:, part], effort
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
            held = () if run.effort is None else (run.effort,)
            for levels in (run.position, run.gravity, run.effector_force, *held):
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


def exploring(robot: Robot, seed: int = 0) -> Design:
    """The design for a robot about which nothing else is known.

    Under the gravity of the robot file, one actuator goes through its range in small steps, as in the paper;
    several go from rest to commands of a Latin hypercube over their ranges, in as many runs as their number
    needs. Further runs go to such commands with gravity tilted by `TILT` to sides all round, and a payload of
    `PAYLOAD` of the weight that pushes on the effectors in random directions.

    Args:
        robot: its limits and gravity are used.
        seed: of the random commands and loads.
    """
    found = command_range(robot)
    if robot.n_a == 1 and not found.by_force[0] and found.least[0] == 0.0:
        own = ramp(robot, float(found.most[0]) / RAMP_STEPS).runs
    elif robot.n_a == 1:
        ends = np.array([[1.0], *([[-1.0]] if found.least[0] < 0.0 else [])])
        own = tuple(_to_command(robot, found, end, _risen(EFFORT_STEPS)) for end in ends)
    else:
        ends = _random_ends(found, LEAST_RUNS + RUNS_EACH * robot.n_a, seed)
        own = tuple(_to_command(robot, found, end, _risen(RUN_STEPS)) for end in ends)
    loaded = _loaded_runs(robot, found, seed)
    sizes = (
        f"{len(own)} runs of {len(own[0])} steps, {len(loaded)} of {LOADED_STEPS} under other loads"
    )
    return Design(
        f"exploring: {sizes}, within the range of each actuator, seed {seed}", (*own, *loaded)
    )


def _loaded_runs(robot: Robot, found: CommandRange, seed: int) -> tuple[Run, ...]:
    """Runs from rest, each with gravity tilted to another side and another payload.

    One actuator goes to the end of its range in each, several to random commands.

    Args:
        robot: its gravity, weight and effectors are used.
        found: range of each actuator.
        seed: of the commands and loads.
    """
    count = LEAST_LOADED_RUNS + RUNS_EACH * robot.n_a
    rng = np.random.default_rng(seed + 1)
    gravity, p = robot.gravity, len(robot.effector_names)
    across = null_space(gravity[None])[:, :2]  # (3, 2)
    sides = 2.0 * np.pi * (rng.permutation(count) + rng.uniform()) / count  # (runs,)
    axes = np.stack([np.cos(sides), np.sin(sides)], axis=1) @ across.T  # (runs, 3)
    push = rng.standard_normal((count, p, 3))
    push *= payload(robot) / np.linalg.norm(push, axis=2, keepdims=True)
    if robot.n_a == 1:  # each run passes through the whole range, or through one half of it
        both = found.least[0] < 0.0
        ends = np.where(both & (np.arange(count) % 2 == 1), -1.0, 1.0)[:, None]
    else:
        ends = _random_ends(found, count, seed + 1)
    shares = np.linspace(0.0, 1.0, LOADED_STEPS)
    return tuple(
        _to_command(
            robot, found, end, shares, Rotation.from_rotvec(TILT * axis).apply(gravity), force
        )
        for end, axis, force in zip(ends, axes, push.reshape(count, -1), strict=True)
    )


def payload(robot: Robot) -> float:
    """`PAYLOAD` of the weight, spread evenly over the effectors: the force on each of them [N]."""
    size = float(np.linalg.norm(robot.gravity)) or STANDARD_GRAVITY
    return PAYLOAD * robot.body.moving_mass * size / len(robot.effector_names)


def _random_ends(found: CommandRange, count: int, seed: int) -> Array:
    """Shares (count, n_a) of the ranges, from a Latin hypercube.

    Args:
        found: range of each actuator.
        count: number of ends.
        seed: of the random numbers.
    """
    levels = latin_hypercube_levels(count, len(found.least), seed)
    ends: Array = np.where(found.least < 0.0, 2.0 * levels - 1.0, levels)
    return ends


def _risen(steps: int) -> Array:
    """Equal steps (steps,) from just above 0 to 1."""
    return np.arange(1, steps + 1) / steps


def _to_command(
    robot: Robot,
    found: CommandRange,
    end: Array,
    rise: Array,
    gravity: Array | None = None,
    force: Array | None = None,
) -> Run:
    """A run from rest to a command, under constant loads.

    Args:
        robot: its gravity and effectors are used.
        found: range of each actuator.
        end: (n_a,) shares of the ranges at the end.
        rise: (s,) shares of the way there.
        gravity: (3,) [m/s²]; None: the robot's.
        force: (3 p,) on the effectors [N]; None: none.
    """
    commands = [found.command(share * end) for share in rise]
    pushed = np.zeros(3 * len(robot.effector_names)) if force is None else force
    return Run(
        position=np.stack([command.position for command in commands], axis=1),
        gravity=np.tile((robot.gravity if gravity is None else gravity)[:, None], len(rise)),
        effector_force=np.tile(pushed[:, None], len(rise)),
        effort=np.stack([command.effort for command in commands], axis=1),
    )


def ramp(robot: Robot, step: float = 5e-5) -> Design:
    """One run a cable: pulled from rest to its limit in equal steps, as in the paper.

    Args:
        robot: its limits and gravity are used.
        step: of the pulled length [m]; the finger's 25 mm make 500 snapshots.

    Raises:
        DesignError: the step is not positive or beyond the largest pull.
    """
    limit = robot.limits.farthest_position  # (n_a,)
    least = np.abs(limit).min()
    if not 0.0 < step <= least:
        raise DesignError(f"ramp step is {step} m: allowed are 0 to {least} m, above 0")
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
    """Levels in [0, 1), one in each of the `runs` classes of every factor, of low centred discrepancy.

    Args:
        runs: number of runs.
        factors: number of factors.
        seed: of the random numbers.

    Returns:
        (runs, factors).
    """
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
