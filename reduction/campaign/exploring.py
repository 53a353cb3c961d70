"""The design for a robot about which nothing else is known: its range, other loads, and what presses it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from tauten.model import Robot, static_compliance
from tauten.model.numerics import Array
from tauten.reduction.campaign.command_range import CommandRange, Report, command_range
from tauten.reduction.campaign.designs import Design, Run, latin_hypercube_levels, ramp
from tauten.reduction.campaign.touched import TouchedRobot, pressing_runs

PAYLOAD = 0.2  # of training and of comparisons, as a share of the weight
FARTHEST = (
    0.5  # how far a payload moves an effector of the robot at rest, of its size, to first order
)
STANDARD_GRAVITY = 9.81  # m/s², by which payloads are chosen where a robot file has no gravity
RAMP_STEPS = 200  # of one actuator whose position is commanded; the paper takes 800
EFFORT_STEPS = 60  # of one actuator whose effort is commanded
RUN_STEPS = 8  # of a run of several actuators
LEAST_RUNS, RUNS_EACH = 16, 4  # number of such runs, and more for each actuator
LOADED_RUNS, LOADED_STEPS = 40, 8  # runs under other loads of one actuator, and their steps
LEAST_LOADED_RUNS, LOADED_RUN_STEPS = 10, 5  # the same of several actuators, at least
LEAST_PRESSED_RUNS, PRESSED_EACH, PRESSED_STEPS = 30, 2, 10  # runs against spheres, and their steps
TILT = np.radians(20.0)  # of gravity there


def exploring(
    robot: Robot,
    seed: int = 0,
    touched: TouchedRobot | None = None,
    report: Report = lambda share, what: None,
) -> Design:
    """The design for a robot about which nothing else is known.

    Under the gravity of the robot file, one actuator goes through its range in small steps, as in the paper;
    several go from rest to commands of a Latin hypercube over their ranges, every second of them moved to the
    corner of the ranges that is nearest, in as many runs as their number needs. Further runs go to such
    commands with gravity tilted by `TILT` to sides all round, and a `payload` that pushes on the effectors in
    random directions.

    Where the robot touches what is not in its file, more runs drive its surfaces against spheres.

    Args:
        robot: its limits and gravity are used.
        seed: of the random commands and loads.
        touched: the robot with spheres, then `robot` is the one in it; None: nothing touches it.
        report: called with the share that is done since the last call, and with what is being done.
    """
    found = command_range(robot, report)
    if robot.n_a == 1 and not found.by_force[0] and found.least[0] == 0.0:
        own = ramp(robot, float(found.most[0]) / RAMP_STEPS).runs
    elif robot.n_a == 1:
        ends = np.array([[1.0], *([[-1.0]] if found.least[0] < 0.0 else [])])
        own = tuple(_to_command(robot, found, end, _risen(EFFORT_STEPS)) for end in ends)
    else:
        ends = _random_ends(found, LEAST_RUNS + RUNS_EACH * robot.n_a, seed)
        own = tuple(_to_command(robot, found, end, _risen(RUN_STEPS)) for end in ends)
    own_effectors = len(robot.effector_names) if touched is None else touched.own
    runs = (*own, *_loaded_runs(robot, found, own_effectors, seed))
    sizes = f"{len(own)} runs of {len(own[0])} steps, "
    sizes += f"{len(runs) - len(own)} of {len(runs[-1])} under other loads"
    if touched is not None:
        pressed = _pressed_runs(touched, found, seed)
        runs = (
            *(replace(run, pressed=np.tile(touched.away[:, None], len(run))) for run in runs),
            *pressed,
        )
        sizes += f", {len(pressed)} against spheres on {', '.join(touched.surfaces)}"
    return Design(f"exploring: {sizes}, within the range of each actuator, seed {seed}", runs)


def _pressed_runs(touched: TouchedRobot, found: CommandRange, seed: int) -> tuple[Run, ...]:
    """Runs from rest to random commands, with spheres in the way of the robot."""
    robot = touched.robot
    ends = _random_ends(found, LEAST_PRESSED_RUNS + PRESSED_EACH * robot.n_a, seed + 2)
    ends, centres = pressing_runs(touched, found, ends, seed + 2)
    shares = _risen(PRESSED_STEPS)
    return tuple(
        replace(_to_command(robot, found, end, shares), pressed=np.tile(at[:, None], PRESSED_STEPS))
        for end, at in zip(ends, centres, strict=True)
    )


def _loaded_runs(robot: Robot, found: CommandRange, effectors: int, seed: int) -> tuple[Run, ...]:
    """Runs from rest, each with gravity tilted to another side and another payload.

    One actuator goes to the end of its range in each, several to random commands.
    """
    count = LOADED_RUNS if robot.n_a == 1 else LEAST_LOADED_RUNS + RUNS_EACH * robot.n_a
    rng = np.random.default_rng(seed + 1)
    gravity = robot.gravity
    across = null_space(gravity[None])[:, :2]  # (3, 2)
    sides = 2.0 * np.pi * (rng.permutation(count) + rng.uniform()) / count  # (runs,)
    axes = np.stack([np.cos(sides), np.sin(sides)], axis=1) @ across.T  # (runs, 3)
    push = rng.standard_normal((count, effectors, 3))
    push *= payload(robot, effectors) / np.linalg.norm(push, axis=2, keepdims=True)
    others = 3 * (len(robot.effector_names) - effectors)
    pushes = np.pad(push.reshape(count, -1), [(0, 0), (0, others)])
    if robot.n_a == 1:  # each run passes through the whole range, or through one half of it
        both = found.least[0] < 0.0
        ends = np.where(both & (np.arange(count) % 2 == 1), -1.0, 1.0)[:, None]
    else:
        ends = _random_ends(found, count, seed + 1)
    shares = np.linspace(0.0, 1.0, LOADED_STEPS if robot.n_a == 1 else LOADED_RUN_STEPS)
    return tuple(
        _to_command(
            robot, found, end, shares, Rotation.from_rotvec(TILT * axis).apply(gravity), force
        )
        for end, axis, force in zip(ends, axes, pushes, strict=True)
    )


def _random_ends(found: CommandRange, count: int, seed: int) -> Array:
    """Shares (count, n_a) of the ranges, from a Latin hypercube; of several actuators every second a corner.

    Decisions for targets out of reach, and of cables that work against each other, go to corners.
    """
    levels = latin_hypercube_levels(count, len(found.least), seed)
    least = np.where(found.least < 0.0, -1.0, 0.0)  # (n_a,)
    corners = np.where(levels < 0.5, least, 1.0)  # (count, n_a)
    several = len(found.least) > 1
    at_corner = several & (np.arange(count) % 2 == 1) & corners.any(axis=1)  # rest is no command
    ends: Array = np.where(at_corner[:, None], corners, least + (1.0 - least) * levels)
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
    """A run from rest to a command under constant loads, by default those of the robot.

    The command has shares `end` (n_a,) of the ranges, of which the run goes shares `rise` (s,) of the way.
    """
    commands = [found.command(share * end) for share in rise]
    pushed = np.zeros(3 * len(robot.effector_names)) if force is None else force
    return Run(
        position=np.stack([command.position for command in commands], axis=1),
        gravity=np.tile((robot.gravity if gravity is None else gravity)[:, None], len(rise)),
        effector_force=np.tile(pushed[:, None], len(rise)),
        effort=np.stack([command.effort for command in commands], axis=1),
    )


def payload(robot: Robot, effectors: int) -> float:
    """`PAYLOAD` of the weight, spread evenly over the first effectors: the force on each of them [N].

    It is smaller where that would move one of them by more than `FARTHEST` of the robot's size, to first
    order: a soft robot whose file has no gravity may not bear its own weight.
    """
    size = float(np.linalg.norm(robot.gravity)) or STANDARD_GRAVITY
    heavy = PAYLOAD * robot.body.moving_mass * size / max(effectors, 1)
    places = robot.effectors.places(robot.body.motion(robot.rest()))
    W = static_compliance(robot, places.dense())  # (3 p, 3 p) [m/N]
    softest = max(
        (np.linalg.eigvalsh(W[i : i + 3, i : i + 3])[-1] for i in range(0, 3 * effectors, 3)),
        default=0.0,
    )
    return min(heavy, FARTHEST * robot.size / softest) if softest > 0.0 else heavy
