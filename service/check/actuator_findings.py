"""What a robot's actuators can do: pulls against cables, times of ways, movement of the effectors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tauten.model import ActuatorKind, Ending, Robot, Simulator
from tauten.model.numerics import Array, Bools
from tauten.model.schema import RobotConfig
from tauten.service.check.findings import Finding

MOVEMENT = "movement of effectors"  # subject of findings
FAR = 10.0  # of the robot's size; a cable that starts farther from its first point is doubtful
SLOW = 600.0  # s from rest to the farthest position; a longer time is doubtful
SHARE = 0.1  # of the way, at which it is looked whether an actuator moves the effectors
MOVED = 1e-5  # of the robot's size; movements at this share that are smaller are none
TOLERANCE = 1e-8  # m; movement of the last step of an equilibrium
LEAST_TENSION = 1.0 / 16.0  # of the largest one, at which buckling is first looked for
HELD_BACK = 0.5  # of its movement, which an actuator keeps where others let out no more
NEAR = 0.05  # of the largest tension; how near the share at which a robot buckles is found


def actuator_findings(robot: Robot, config: RobotConfig, held: bool = True) -> Iterator[Finding]:
    """Cables against their pulls, rates against ways, and the movement of effectors.

    Effectors are moved where all bodies are held: it takes equilibria.
    """
    if config.cables:
        yield cable_lengths(config, robot.size)
    if robot.n_a:
        yield times_of_ways(robot)
        if robot.effector_layout.kinds and held:
            moved = movement(robot)
            share = buckling_share(robot) if moved.level == "fine" else 1.0
            yield moved if share == 1.0 else buckles(share)


def cable_lengths(config: RobotConfig, size: float) -> Finding:
    """Whether a cable is as long as its largest pull, and starts near a robot of some size [m]."""
    subject, shares = "cables against their pulls", []
    for cable in config.cables:
        points = np.array([cable.pull_point] * (cable.pull_point is not None) + cable.points)
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)  # (p - 1,)
        length = float(steps.sum())
        if cable.spring is not None:  # the winch pulls it beyond the length of its cable
            continue
        found = f"{cable.name} is {1e3 * length:.4g} mm long and pulled by {1e3 * cable.max_pull:.4g} mm"
        if cable.max_pull > length:
            return Finding(subject, "wrong", found, f"a smaller max_pull of {cable.name} [m]")
        if cable.pull_point is not None and steps[0] > FAR * size:
            found = f"{cable.name} starts {steps[0]:.3g} m from its first point"
            advice = f"check pull_point of {cable.name} [m]: the robot is {size:.3g} m long"
            return Finding(subject, "doubtful", found, advice)
        shares.append(cable.max_pull / length)
    if not shares:
        return Finding(subject, "fine", "all have springs")
    percent = interval(100.0 * np.array(shares))
    return Finding(subject, "fine", f"the largest pull is {percent} % of the cable")


def times_of_ways(robot: Robot) -> Finding:
    """The time in which actuators get from rest to their farthest position at their largest rate."""
    subject = "rates of actuators"
    times: Array = np.abs(robot.limits.farthest_position) / robot.limits.rate  # (n_a,)
    period = 1.0 / robot.integration.rate
    for which, wrong in (
        (int(times.argmax()), times > SLOW),
        (int(times.argmin()), times < period),
    ):
        if wrong[which]:
            name = robot.actuators.names[which]
            unit = robot.actuators.kinds[which].position.unit
            found = f"{name} gets from rest to its farthest position in {times[which]:.2g} s"
            advice = f"check max_rate of {name} [{unit}/s]; a control period is {period:.2g} s"
            return Finding(subject, "doubtful", found, advice)
    return Finding(subject, "fine", f"from rest to the farthest position in {interval(times)} s")


def interval(values: Array) -> str:
    """The least and the largest value, or both as one where they are shown the same."""
    least, most = f"{values.min():.3g}", f"{values.max():.3g}"
    return least if least == most else f"{least} to {most}"


def movement(robot: Robot) -> Finding:
    """Whether each actuator moves an effector, and each effector is moved, at equilibria without contact."""
    subject, layout = MOVEMENT, robot.effector_layout
    moved, efforts, lacking = movements(robot)  # (n_a, p), (n_a,), (n_a, n_a)
    owner = (
        np.searchsorted(layout.row_starts, [part.start for part in layout.parts()], side="right")
        - 1
    )
    least = MOVED * robot.size
    if not np.isfinite(moved).all():
        return Finding(
            subject, "doubtful", "not every actuator has an equilibrium a tenth of its way"
        )
    for effector, name in enumerate(layout.names):
        if moved[:, owner == effector].max() < least:
            found = f"no actuator moves {name} by more than {1e3 * least:.2g} mm a tenth of its way"
            return Finding(
                subject, "wrong", found, f"check where {name} is, fixed, and the actuators"
            )
    for actuator, name in enumerate(robot.actuators.names):
        if moved[actuator].max() < least:
            found = f"{name} moves no effector by more than {1e3 * least:.2g} mm a tenth of its way"
            return Finding(subject, "doubtful", found, f"check where {name} acts, and fixed")
    needed = efforts / robot.limits.largest_effort  # (n_a,)
    if needed.max() > 1.0:
        which = int(needed.argmax())
        name, unit = robot.actuators.names[which], robot.actuators.kinds[which].effort.unit
        limit = robot.limits.largest_effort[which]
        found = (
            f"{name} needs {efforts[which]:.3g} a tenth of its way, allowed are {limit:.3g} {unit}"
        )
        return Finding(
            subject, "doubtful", found, f"check young_modulus [Pa] and the limits of {name}"
        )
    if lacking.any():
        return held_back(robot, lacking)
    farthest = moved.max(axis=1)  # (n_a,)
    return Finding(
        subject, "fine", f"{interval(1e3 * farthest)} mm by each actuator a tenth of its way"
    )


def held_back(robot: Robot, lacking: Array) -> Finding:
    """Cables that are too short for what others do, by the lengths (n_a, n_a) of `movements`."""
    names = robot.actuators.names
    by, which = np.unravel_index(lacking.argmax(), lacking.shape)
    others = ", ".join(names[i] for i in np.flatnonzero(lacking.any(axis=0)))
    found = (
        f"{names[by]} a tenth of its way takes {1e3 * lacking[by, which]:.3g} mm more of {names[which]} than "
        "its min_pull lets out, which keeps the effectors from moving"
    )
    advice = f"a smaller min_pull of {others} [m], below zero, where winches let cable out"
    return Finding(MOVEMENT, "doubtful", found, advice)


def movements(robot: Robot) -> tuple[Array, Array, Array]:
    """How far each actuator alone moves the effectors from where gravity holds them, a tenth of its way.

    Drives stay where they are meanwhile, other actuators are slack.

    Returns:
        (n_a, p) movement of each part of the effectors, in metres by the units of `EffectorLayout` [m]; NaN
        where no equilibrium was found. (n_a,) magnitude of the effort that this takes, in its unit.
        (n_a, n_a) length by which each takes more of the cable of another than its least position lets out
        [m]; 0 where it moves the effectors nevertheless from where the cables hold them at positions of zero.
    """
    layout, limits = robot.effector_layout, robot.limits
    held, cables = motors(robot), pulling(robot)
    simulator = Simulator(robot, contact="none")
    found, efforts = np.full((robot.n_a, len(layout.parts())), np.nan), np.zeros(robot.n_a)
    lacking = np.zeros((robot.n_a, robot.n_a))
    position, effort = np.where(held, 0.0, np.nan), np.where(held, np.nan, 0.0)
    if not simulator.settle(position, effort, tolerance=TOLERANCE).converged:
        return found, efforts, lacking
    start, values = (simulator.state, simulator.forces), simulator.effector_values
    begin = np.where(robot.actuators.laws.bilateral, 0.0, np.maximum(simulator.position, 0.0))
    away = begin + SHARE * (limits.farthest_position - begin)  # (n_a,)
    least = np.minimum(limits.position_min, simulator.position)  # gravity may have taken more

    def at(given: Array) -> Array | None:
        """Values of the effectors with given positions (n_a,), NaN for a slack actuator; None: not found."""
        simulator.start_from(*start)
        effort = np.where(np.isnan(given), 0.0, np.nan)
        found = simulator.settle(given, effort, tolerance=TOLERANCE)
        return simulator.effector_values if found.converged else None

    def between(one: Array, other: Array) -> Array:
        """Distance of values of the effectors, by part (p,) [m]."""
        return layout.lengths(layout.counted(one, other))

    for actuator in range(robot.n_a):
        alone = np.arange(robot.n_a) == actuator
        slack = np.where(alone, away, np.where(held, 0.0, np.nan))
        free = at(slack)
        if free is None:
            continue
        found[actuator], efforts[actuator] = between(free, values), abs(simulator.effort[actuator])
        short = np.where(cables & ~alone, least - simulator.position, 0.0)
        if short.max() < MOVED * robot.size:
            continue
        wound = at(np.where(cables | held, 0.0, np.nan))
        kept = at(np.where(short > 0.0, least, slack))
        if kept is None or (
            wound is not None and between(kept, free).max() > HELD_BACK * between(free, wound).max()
        ):
            lacking[actuator] = np.maximum(short, 0.0)
    return found, efforts, lacking


def pulling(robot: Robot) -> Bools:
    """Which actuators are cables that only pull (n_a,)."""
    cables = [kind is ActuatorKind.CABLE for kind in robot.actuators.kinds]
    return np.array(cables, dtype=np.bool_) & (robot.limits.effort_min >= 0.0)


def motors(robot: Robot) -> Bools:
    """Which actuators are drives (n_a,): they stay at rest while others are looked at."""
    kinds = (ActuatorKind.DRIVE, ActuatorKind.SLIDE)
    return np.array([kind in kinds for kind in robot.actuators.kinds], dtype=np.bool_)


def buckles(share: float) -> Finding:
    """A robot that buckles under a share of the largest tensions of all its cables."""
    percent = 100.0 * share
    found = f"under {percent:.0f} % of the largest tensions of all cables it buckles"
    advice = (
        f"max_tension [N] below {percent:.0f} % of what it is: targets that only a shorter robot reaches "
        "lead decisions there, and what has buckled is not where they expect it"
    )
    return Finding(MOVEMENT, "doubtful", found, advice)


def buckling_share(robot: Robot) -> float:
    """Share of the largest tensions of all cables under which a robot buckles, without contact.

    It is 1 where it does not, where limits of positions are met before, and where no equilibrium is found for
    another reason. Drives stay where they are meanwhile, other actuators are slack.
    """
    limits, held = robot.limits, motors(robot)
    pulled = np.array([kind is ActuatorKind.CABLE for kind in robot.actuators.kinds])
    if not pulled.any():
        return 1.0
    simulator = Simulator(robot, contact="none")
    start, stable, share, least = None, 0.0, LEAST_TENSION, np.inf
    while least - stable > NEAR and stable < 1.0:
        if start is not None:
            simulator.start_from(*start)
        efforts = np.where(pulled, share * limits.effort_max, np.where(held, np.nan, 0.0))
        report = simulator.settle(np.where(held, 0.0, np.nan), efforts, tolerance=TOLERANCE)
        position = simulator.position
        if report.converged:
            if (
                pulled & ((position > limits.position_max) | (position < limits.position_min))
            ).any():
                return 1.0
            start, stable = (simulator.state, simulator.forces), share
        elif report.ending in (Ending.BUCKLED, Ending.LIMIT_POINT):
            least = share
        else:
            return 1.0
        share = min(2.0 * stable, 1.0) if least > 1.0 else 0.5 * (stable + least)
    return min(least, 1.0)
