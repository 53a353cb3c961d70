"""The interface of all drivers: what turns actuation into motion of a robot, and measures what it does.

A driver knows the hardware and nothing of tauten but the robot's description. Packages add drivers as entry
points of the group "tauten.drivers", functions without arguments; `tauten drive` runs one beside a node.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from tauten.model.load import extension, extension_names, made
from tauten.model.numerics import Array
from tauten.service.wire import RobotDescription

GROUP = "tauten.drivers"  # of entry points


class DriverError(ValueError):
    """A driver that cannot be used, or hardware that fails; the text says what to change."""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What a driver measures, in SI units; NaN for a value that it does not measure.

    Attributes:
        position: (n_a,) of the actuators.
        effort: (n_a,) of the actuators.
        effectors: (n_v,) values of the effectors; None: it measures none.
        gap: smallest gap of the contacts [m]; None: not measured.
        facts: for health, by name.
        warning: what health warns of, "" where all is well.
    """

    position: Array
    effort: Array
    effectors: Array | None = None
    gap: float | None = None
    facts: Mapping[str, str] = field(default_factory=dict)
    warning: str = ""


class Driver(Protocol):
    """Hardware of a robot, or a simulation of it. Each method may raise a `DriverError`."""

    def configure(self, robot: RobotDescription, options: Mapping[str, str]) -> None:
        """Connect, without moving anything."""

    def activate(self) -> None:
        """Follow what is written from now on; called before the first actuation, and after each pause."""

    def read(self) -> Measured:
        """What is measured now, once a period, also while it is not active."""

    def write(self, position: Array, effort: Array) -> None:
        """Follow an actuation, within the limits of the description.

        Args:
            position: (n_a,) positions of the actuators.
            effort: (n_a,) efforts that the model needs for these.
        """

    def deactivate(self) -> None:
        """Bring the robot to rest safely: no actuation comes any more."""


def make_driver(name: str) -> Driver:
    """The driver that an installed package registers by a name.

    Raises:
        DriverError: there is none.
        RobotFileError: its package cannot be imported, or what it has makes no driver without arguments.
    """
    make = extension(GROUP, name)
    if make is None:
        known = ", ".join(extension_names(GROUP)) or "none"
        raise DriverError(f"no driver {name!r}; installed packages have: {known}")
    driver: Driver = made(make, Driver, f"driver {name}", {})
    return driver
