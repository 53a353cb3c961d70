"""The robot of a run from the metadata of its log, checked before anything is opened or computed.

A log may come from another person. The paths in it are names that its writer chose: they are opened only
where they lie beside the log, unless the caller allows it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from tauten.model import ActuatorKind
from tauten.model.schema import COMPONENTS, EffectorKind
from tauten.service.log import LogError
from tauten.service.setup import Order, Setup, Start, load_setup

T = TypeVar("T")

KINDS: dict[str, EffectorKind] = {kind: kind for kind in COMPONENTS}
ORDERS: dict[str, Order] = {"full": "full", "reduced": "reduced"}
STARTS: dict[str, Start] = {"settled": "settled", "rest": "rest"}
ACTUATORS = {one.value: one for one in ActuatorKind}
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # of robots, as robot files allow it
_MAX_RATE = 10_000.0  # Hz, as robot files allow it


@dataclass(frozen=True, slots=True)
class RecordedSetup:
    """The robot of a run, as its log names it.

    Attributes:
        log: the file.
        robot: name.
        file: path of the robot file when it was recorded; "" for a shipped robot.
        rate: control rate [Hz].
        basis: "none", "full", name or path of the contact basis.
        order: which model decided.
        kind: of the first effector.
        weights: of its components in the objective, 0 where one is left free; 1 in logs that do not say it.
        actuators: kind of each; none in logs that do not say it, whose actuators are cables.
        start: where the model started; from rest in logs that do not say it.
    """

    log: Path
    robot: str
    file: str
    rate: float
    basis: str
    order: Order
    kind: EffectorKind
    weights: tuple[float, ...]
    actuators: tuple[ActuatorKind, ...]
    start: Start

    def load(
        self, against: str | None = None, model: Order | None = None, allowed: bool = False
    ) -> Setup:
        """The setup that decides again what the log has.

        Args:
            against: robot to use instead of the recorded one, a name or a file.
            model: model to use instead of the recorded one.
            allowed: whether files that are not beside the log may be opened.

        Raises:
            LogError: the recorded file lies elsewhere, and recorded paths are not allowed.
            RobotFileError, MeshError, BasisError, StateBasisError: the robot cannot be used.
        """
        if against is None:
            name, basis = self.robot_file(allowed), self.contact_basis(allowed)
        else:
            name, basis = against, None
        setup = load_setup(name, self.rate, basis, model or self.order, accept_error=True)
        return replace(setup, start=self.start)

    def robot_file(self, allowed: bool) -> str:
        """The robot to load: a file beside the log, the recorded path, or the name of a shipped robot.

        Args:
            allowed: whether files that are not beside the log may be opened.

        Raises:
            LogError: the recorded file lies elsewhere, and recorded paths are not allowed.
        """
        if self.file:
            beside = self.log.parent / Path(self.file).name
            if beside.suffix == ".toml" and beside.is_file():
                return str(beside)
            if Path(self.file).is_file() and not _is_shipped(self.file, self.robot):
                if allowed:
                    return self.file
                raise LogError(
                    f"{self.log}: recorded with {self.file}, which is not beside the log: allow "
                    "recorded paths (--recorded-paths), or name the robot (--against)"
                )
        return self.robot

    def contact_basis(self, allowed: bool) -> str:
        """The contact basis to load: a file beside the log, the recorded path, or a shipped name.

        Args:
            allowed: whether files that are not beside the log may be opened.

        Raises:
            LogError: the recorded file lies elsewhere, and recorded paths are not allowed.
        """
        if _NAME.fullmatch(self.basis):
            return self.basis
        beside = self.log.parent / Path(self.basis).name
        if beside.is_file():
            return str(beside.resolve())
        if allowed:
            return self.basis
        raise LogError(
            f"{self.log}: recorded with the basis {self.basis}, which is not beside the log: "
            "allow recorded paths (--recorded-paths)"
        )


def recorded_setup(log: Path, metadata: dict[str, str]) -> RecordedSetup:
    """The checked metadata of a log.

    Args:
        log: the file, for messages and for files beside it.
        metadata: as the log has them.

    Raises:
        LogError: a missing or wrong entry; the message names it, the value found and the values allowed.
    """

    def entry(name: str) -> str:
        if name not in metadata:
            raise LogError(f"{log}: its metadata have no {name!r}")
        return metadata[name]

    robot, rate, basis = entry("robot"), _rate(log, entry("rate")), entry("basis")
    if not _NAME.fullmatch(robot):
        raise _wrong(log, f"robot is {robot[:80]!r}, not the name of a robot")
    order = _known(log, "model is", metadata.get("model", "full"), ORDERS)
    first = metadata.get("effector_kinds", "point").split(" ")[0]
    kind = _known(log, "effector_kinds is", first, KINDS)
    weights = _weights(log, metadata.get("effector_weights", ""), kind)
    kinds = tuple(
        _known(log, "actuator_kinds has", name, ACTUATORS)
        for name in metadata.get("actuator_kinds", "").split()
    )
    file = metadata.get("robot_path", "")
    if "\0" in file + basis:
        raise _wrong(log, "a path has a zero byte")
    start = _known(log, "start is", metadata.get("start", "rest"), STARTS)
    return RecordedSetup(log, robot, file, rate, basis, order, kind, weights, kinds, start)


def _wrong(log: Path, what: str) -> LogError:
    return LogError(f"{log}: its metadata: {what}")


def _known(log: Path, what: str, found: str, allowed: Mapping[str, T]) -> T:
    """What a word of the metadata stands for.

    Args:
        log: the file, for the message.
        what: the entry, for the message.
        found: the word.
        allowed: words, and what they stand for.
    """
    if found not in allowed:
        names = list(allowed)
        listed = " and ".join(names) if len(names) == 2 else ", ".join(names)
        raise _wrong(log, f"{what} {found[:80]!r}, allowed are {listed}")
    return allowed[found]


def _weights(log: Path, text: str, kind: EffectorKind) -> tuple[float, ...]:
    """Weights of the components of the first effector, which are joined by commas."""
    first, count = text.split(" ")[0], COMPONENTS[kind]
    if not first:
        return (1.0,) * count
    try:
        weights = tuple(float(part) for part in first.split(","))
    except ValueError:
        weights = ()
    if len(weights) != count or not all(0.0 <= weight < math.inf for weight in weights):
        allowed = f"{count} numbers that are not negative"
        raise _wrong(log, f"effector_weights is {first[:80]!r}, allowed are {allowed}")
    return weights


def _rate(log: Path, text: str) -> float:
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not 0.0 < rate <= _MAX_RATE:
        raise _wrong(log, f"rate is {text[:80]!r}, allowed are numbers up to {_MAX_RATE:g} Hz")
    return rate


def _is_shipped(file: str, robot: str) -> bool:
    """Whether a path is that of the shipped robot of this name, in any installation."""
    return Path(file).parts[-3:] == ("model", "robots", f"{robot}.toml")
