"""A run read back from its log, as arrays over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tauten.model import VALUES, ActuatorKind
from tauten.model.numerics import Array, Bools
from tauten.model.schema import EffectorKind
from tauten.service.log import LogError, Logged, LogReader, logged_description
from tauten.service.wire import (
    CDR,
    FLOAT,
    JOINTS,
    MESSAGE_TYPES,
    Cause,
    Diagnostic,
    EffectorMessage,
    Joints,
    Keys,
    Mode,
    Rejection,
    RejectionReason,
    RunDescription,
    Tick,
    decode_effector,
    decode_health,
    decode_joints,
    decode_tick,
    from_cdr,
)

# Causes for not following a target that is there.
_HINDERED = frozenset({Cause.LATE, Cause.UNMEASURED, Cause.IMPLAUSIBLE, Cause.UNUSABLE})


@dataclass(frozen=True, slots=True)
class Series:
    """Values over time: time (m,) [s] since the first tick, value (m, d)."""

    time: Array
    value: Array


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """A run.

    Attributes:
        description: what the log says of its robot.
        ticks: the record of each tick.
        time: (m,) of the ticks [s].
        kind: of the first effector.
        weights: (c,) of the first effector's components, 0 where one is left free.
        goal: (m, v) values of the first effector, NaN without a goal.
        model: values of the first effector in the model.
        actuators: name and kind of each.
        position: commanded positions, one column for each actuator [m, m³, rad].
        effort: commanded efforts, one column for each actuator [N, Pa, N m].
        plant: values of the first effector in the plant; empty without plant.
        plant_gap: smallest gap in the plant [m]; empty without plant.
        health: last health of the node, by name.
        plant_health: last health of the plant, by name; empty without plant.
        complete: whether the log was finished.
    """

    description: RunDescription
    ticks: tuple[Tick, ...]
    time: Array
    kind: EffectorKind
    weights: Array
    goal: Array
    model: Series
    actuators: tuple[tuple[str, ActuatorKind], ...]
    position: Series
    effort: Series
    plant: Series
    plant_gap: Series
    health: dict[str, Diagnostic]
    plant_health: dict[str, Diagnostic]
    complete: bool

    @property
    def following(self) -> Array:
        """(m,) bool: ticks that followed a goal."""
        return np.array([tick.mode is Mode.RUN for tick in self.ticks])

    def plant_value(self, name: str, default: str) -> str:
        """A value of the plant's health."""
        found = self.plant_health.get("plant")
        return default if found is None else found.values.get(name, default)

    @property
    def active(self) -> slice:
        """Ticks from the first to the last that followed a goal or could not; all where there are none."""
        found = np.flatnonzero(
            [tick.mode is Mode.RUN or tick.cause in _HINDERED for tick in self.ticks]
        )
        return slice(int(found[0]), int(found[-1]) + 1) if len(found) else slice(None)

    @property
    def weighted(self) -> Bools:
        """(c,) components of the first effector that are to reach their goal."""
        weighted: Bools = self.weights > 0.0
        return weighted


def read_run(path: Path) -> RecordedRun:
    """Read a log.

    Raises:
        LogError: no log, a damaged one, or one without ticks or actuations.
    """
    reader = LogReader(path)
    by_key: dict[str, list[Logged]] = {}
    for message in reader.messages():
        by_key.setdefault(message.key, []).append(message)
    said = logged_description(path, reader.metadata)
    first, keys = said.effectors[0], Keys(said.name)
    kind, size = first.kind, VALUES[first.kind]
    decoded = [decode_tick(message.payload) for message in by_key.get(keys.tick, [])]
    ticks = tuple(tick for tick in decoded if isinstance(tick, Tick))
    if not ticks:
        raise LogError(f"{path}: no tick in it")
    start = ticks[0].stamp
    joints = [_joints(message) for message in by_key.get(keys.actuation, [])]
    names = joints[0].names if joints else ()
    if not names or any(len(one.names) != len(names) for one in joints):
        raise LogError(
            f"{path}: no actuation in it, or actuations of different numbers of actuators"
        )
    kinds = [one.kind for one in said.actuators]
    if len(kinds) != len(names):
        raise LogError(
            f"{path}: its metadata have {len(kinds)} actuators, its actuations have {len(names)}"
        )
    gaps = by_key.get(keys.plant_gap, [])
    health, plant_health = (
        [decode_health(message.payload) for message in by_key.get(key, [])]
        for key in (keys.health, keys.plant_health)
    )
    return RecordedRun(
        description=said,
        ticks=ticks,
        time=np.array([1e-9 * (tick.stamp - start) for tick in ticks]),
        kind=kind,
        weights=np.array(first.weight),
        goal=np.array([_first(tick.goal_values, size) for tick in ticks]),
        model=_values(by_key.get(keys.effectors(("",))[0], []), kind, start),
        actuators=tuple(zip(names, kinds, strict=True)),
        position=_series([(one.stamp, one.position) for one in joints], start),
        effort=_series([(one.stamp, one.effort) for one in joints], start),
        plant=_values(by_key.get(keys.plant_effectors(("",))[0], []), kind, start),
        plant_gap=_series([(gap.logged, [_float(gap.payload)]) for gap in gaps], start),
        health=_last(health),
        plant_health=_last(plant_health),
        complete=reader.complete,
    )


def _joints(message: Logged) -> Joints:
    """A recorded actuation.

    Raises:
        LogError: it is damaged.
    """
    found = decode_joints(message.payload, CDR, None)
    if isinstance(found, Rejection):
        raise LogError(f"a damaged actuation: {found.detail}")
    return found


def _last(health: list[dict[str, Diagnostic] | Rejection]) -> dict[str, Diagnostic]:
    """The last of several healths that could be decoded."""
    return next((found for found in reversed(health) if isinstance(found, dict)), {})


def _first(values: tuple[float, ...], size: int) -> list[float]:
    """Values of the first effector, NaN where there are none."""
    return list(values[:size]) if len(values) >= size else [np.nan] * size


def _values(messages: list[Logged], kind: EffectorKind, start: int) -> Series:
    found = [_message(message.payload, kind) for message in messages]
    rows = [(one.stamp, one.values) for one in found if isinstance(one, EffectorMessage)]
    return _series(rows, start) if rows else Series(np.zeros(0), np.zeros((0, VALUES[kind])))


def _message(payload: bytes, kind: EffectorKind) -> EffectorMessage | Rejection:
    """A recorded message of the first effector, whatever its name."""
    if MESSAGE_TYPES[kind] != JOINTS:
        return decode_effector(kind, "", payload, CDR)
    message = from_cdr(JOINTS, payload)
    if isinstance(message, Rejection) or len(message.name) != 1:
        return Rejection(RejectionReason.WRONG_SHAPE, "not one number")
    return decode_effector(kind, message.name[0], payload, CDR)


def _float(payload: bytes) -> float:
    message = from_cdr(FLOAT, payload)
    return np.nan if isinstance(message, Rejection) else float(message.data)


def _series(rows: Sequence[tuple[int, Sequence[float]]], start: int) -> Series:
    if not rows:
        return Series(np.zeros(0), np.zeros((0, 3)))
    return Series(
        np.array([1e-9 * (stamp - start) for stamp, _ in rows]),
        np.array([value for _, value in rows]),
    )
