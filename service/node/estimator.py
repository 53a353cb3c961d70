"""What a closed loop adds to the targets: the interface of all estimators, and which one a robot file names.

An estimator gets what the model predicted and what was measured, and gives a correction of the targets. Its
rows are those of `EffectorLayout`: positions and scalars, rotations about the frame's own axes. `Feedback`
is the one of tauten; packages add others as entry points of the group "tauten.estimators", functions of
robot and settings. Measurements that are late, damaged or implausible never reach an estimator, and no
correction that is infinite or longer than `LARGEST` of the robot's size leaves the loop.
"""

from __future__ import annotations

from typing import Protocol

from tauten.model import Robot, RobotFileError, extension_error
from tauten.model.body import natural_frequencies
from tauten.model.load import check_interface, extension, extension_names
from tauten.model.numerics import Array, FactorisationError
from tauten.service.node.feedback import LARGEST, Feedback
from tauten.service.settings import ServiceSettings

GROUP = "tauten.estimators"  # of entry points
SLOWEST = 0.5  # s, over which differences of model and robot are averaged at most


class Estimator(Protocol):
    """From measurements to a correction of the targets."""

    def update(self, predicted: Array, measured: Array, seconds: float) -> Array:
        """The correction (n_e,) from now on.

        Args:
            predicted: (n_v,) the model's effectors when the measurement was made.
            measured: (n_v,) the measured effectors.
            seconds: since the measurement before.
        """

    def reset(self) -> None:
        """Forget all measurements; the correction is zero then."""


def own_estimator(robot: Robot, settings: ServiceSettings) -> Feedback:
    """The estimator of robot files that name none."""
    layout, largest = robot.effector_layout, LARGEST * robot.size
    gain, delay = settings.feedback_gain, settings.measurement_delay
    return Feedback(layout, gain, largest, delay, slowest_period(robot))


def slowest_period(robot: Robot) -> float:
    """The period of the slowest vibration at rest, at most `SLOWEST` [s]; 0 where none is known.

    Nothing is known of quasi-static robots, nor of what cables or contacts alone hold.
    """
    longest = 0.0
    for part in robot.body.part_robots or (robot,):
        rest, moving = part.rest(), part.body.n - len(part.body.motor_coordinates)
        if part.integration.static or moving < 2:
            continue
        try:
            found = natural_frequencies(part.body, rest, 1, part.spring_rows(rest))
        except FactorisationError:
            continue
        longest = max(longest, 1.0 / float(found[0]))
    return min(longest, SLOWEST)


OWN = {"feedback": own_estimator}


def make_estimator(robot: Robot, settings: ServiceSettings) -> Estimator:
    """The estimator that a robot file names.

    Raises:
        RobotFileError: no installed package has it, it refuses the robot or has no such methods, or as
            `extension`.
    """
    make = extension(GROUP, settings.estimator, OWN)
    if make is None:
        known = ", ".join((*OWN, *extension_names(GROUP)))
        raise RobotFileError(
            f"robot {robot.name}: service.estimator is {settings.estimator!r}, found are {known}"
        )
    what = f"robot {robot.name}: service.estimator {settings.estimator!r}"
    try:
        estimator: Estimator = make(robot, settings)
    except ValueError as error:
        raise RobotFileError(f"{what}: {error}") from error
    except Exception as error:
        raise RobotFileError(str(extension_error(what, error))) from error
    check_interface(estimator, Estimator, what)
    return estimator
