"""Positions, efforts and loads that a simulation is given, checked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tauten.model.arguments import of_kind
from tauten.model.numerics import Array
from tauten.model.robot import Robot
from tauten.model.signals import Command, Laws
from tauten.model.state import State
from tauten.model.step import Forces, no_forces

Numbers = Sequence[float] | Array
LARGEST = 1e6  # m or N; no cable is pulled farther or harder
LARGEST_EFFORT = 1e9  # N or Pa, of any other actuator


def checked_command(robot: Robot, position: Numbers | None, effort: Numbers | None) -> Command:
    """The command of given positions and efforts (n_a,).

    Raises:
        ValueError: not exactly one of the two for each actuator, or values that are not allowed.
    """
    if position is None and effort is None:
        raise ValueError(
            "position and effort: each actuator needs a number in one of them, found neither"
        )
    n_a, cables = robot.n_a, ~robot.actuators.laws.bilateral
    mixed = position is not None and effort is not None
    least, most = np.full(n_a, -LARGEST), np.full(n_a, LARGEST)
    positions = None if position is None else _numbers("position", position, least, most, mixed)
    least = np.where(cables, 0.0, -LARGEST_EFFORT)
    most = np.where(cables, LARGEST, LARGEST_EFFORT)
    efforts = None if effort is None else _numbers("effort", effort, least, most, mixed)
    command = Command.of(positions, efforts)
    if (command.by_position == command.by_force).any():
        raise ValueError(
            "position and effort: each actuator needs a number in one of them and NaN in the other, found "
            f"{command.position.tolist()} and {command.effort.tolist()}"
        )
    return command


def efforts_at_end(laws: Laws, command: Command, before: Array, mean: Array) -> Array:
    """Efforts (n_a,) at the end of a period from the means of two, to second order where they are smooth.

    Actuators that move evenly change their velocity where a period begins. The stages of a step have this
    impulse with weights, the last one with the wrong sign; the mean has what accelerates the robot, which is
    half a period late then. An actuator that is given an effort has it.

    Args:
        laws: of the actuators.
        command: at the end.
        before: (n_a,) mean efforts of the period before [N, Pa].
        mean: (n_a,) of this one.
    """
    found: Array = np.where(command.by_force, command.effort, 1.5 * mean - 0.5 * before)
    return np.where(laws.bilateral, found, np.maximum(found, 0.0))


def diverged(robot: Robot, efforts: Sequence[Array], error: Exception) -> str:
    """What to say of a state that has diverged under a command.

    Args:
        robot: whose actuators they are.
        efforts: (n_a,) each, those that are known; the largest of each actuator counts [N, Pa].
        error: of the step.
    """
    limit, known = robot.limits.largest_effort, np.array(efforts)  # (k, n_a)
    effort = known[np.abs(known).argmax(axis=0), np.arange(robot.n_a)]
    excess = np.abs(effort) / np.where(limit > 0.0, limit, np.inf)
    if not (excess > 1.0).any():
        return f"robot {robot.name}: the state has diverged ({error})"
    worst = int(excess.argmax())
    name, found, most = robot.actuators.names[worst], effort[worst], limit[worst]
    return (
        f"robot {robot.name}: the state has diverged ({error}); {name} needed an effort of {found:.3g} for "
        f"its position, {most:g} is allowed: the robot cannot follow these positions, as where cables hold a "
        "rigid part against each other; let one of them pay out, or command its effort"
    )


def checked_loads(robot: Robot, gravity: Numbers, effector_force: Numbers) -> tuple[Array, Array]:
    """Gravity (3,) [m/s²] and forces on the effectors (3 p,) [N].

    Raises:
        ValueError: another shape, or values that are not allowed.
    """
    one, all_ = np.full(3, LARGEST), np.full(3 * len(robot.effector_names), LARGEST)
    return (
        _numbers("gravity", gravity, -one, one, False, "axis"),
        _numbers("effector_force", effector_force, -all_, all_, False, "axis of each effector"),
    )


def checked_state(robot: Robot, state: State) -> State:
    """A copy of a state of a robot.

    Raises:
        TypeError: it is no state.
        ValueError: it is one of another robot, by its size.
    """
    if len(of_kind("state", state, State).v) != robot.n:
        raise ValueError(
            f"state: found {len(state.v)} degrees of freedom, expected {robot.n}, those of {robot.name}"
        )
    return state.copy()


def checked_forces(robot: Robot, k: int, forces: Forces | None) -> Forces:
    """A copy of the constraint forces of a robot; zero where None is given.

    Raises:
        TypeError: these are no forces.
        ValueError: they are those of another robot or basis, by their size.
    """
    if forces is None:
        return no_forces(robot.n_a, k)
    sizes = len(of_kind("forces", forces, Forces).effort), len(forces.beta)
    if sizes != (robot.n_a, k):
        raise ValueError(
            f"forces: found {sizes[0]} efforts and {sizes[1]} coefficients of a basis, expected "
            f"{robot.n_a} and {k}, those of {robot.name}"
        )
    return forces.copy()


def _numbers(
    name: str,
    given: Numbers,
    least: Array,
    most: Array,
    gaps: bool,
    of: str = "actuator",
) -> Array:
    """An array of one number for each actuator (n_a,), or of other things, copied.

    Args:
        name: of the argument, for errors.
        given: what the caller gave.
        least: (n_a,) smallest values allowed.
        most: (n_a,) largest values allowed.
        gaps: whether NaN is allowed too.
        of: what it has one number for, for errors.
    """
    try:
        value = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name}: not an array of numbers: {error}") from error
    fits = value.shape == least.shape
    if not fits or not ((value >= least) & (value <= most) | (gaps & np.isnan(value))).all():
        raise ValueError(
            f"{name}: found {value.tolist()}, expected {len(least)} values from {least.max():g} to "
            f"{most.min():g}, one for each {of}"
        )
    return value
