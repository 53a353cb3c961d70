"""Effectors by kind: their goal values, the rows that a step has of them, and the way between the two.

| kind | goal values | rows | unit of a row |
|---|---|---|---|
| point, centre | position, 3 | 3 | m |
| frame | position, quaternion (w, x, y, z), 7 | 6: position, rotation about the frame's axes | m, rad |
| distance, length, function | 1 | 1 | m |
| volume | 1 | 1 | m³ |

Rotations need no chart that has a singular angle: the rows of a frame are those at its present rotation R,
where the rotation that is wanted has the value r, exp(r) = R⁻¹ R_goal. The value at present is zero.

Errors of different units are compared in metres: a radian counts like the size of the robot, and a
volume like the displacement that changes it over a surface of V^(2/3), V the volume at rest. The weights of
a robot file are unitless factors of these.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tauten.model.numerics import Array, Bools, Ints, rotated_by, rotation_between
from tauten.model.schema import COMPONENTS, EffectorKind, EffectorSettings
from tauten.model.signals.targets import VALUES, Target, target_values

ROWS = COMPONENTS
COMPONENT_NAMES = ("x", "y", "z", "rotation about x", "rotation about y", "rotation about z")
MISSED = 1e-3  # of the largest error; smaller ones are those of rows that reach their target
UNIT_LENGTH = 1e-3  # what the length of a quaternion may differ from one by
# Angle from which on a rotation pulls less [rad]. Half a turn can be made both ways round: there the pull is
# zero, so that it does not change its direction at once where a target passes that angle.
FARTHEST_PULL = 0.75 * np.pi


@dataclass(frozen=True, slots=True)
class EffectorLayout:
    """Kinds of a robot's effectors, and where each has its rows and values.

    Attributes:
        names: of the effectors, in row order.
        kinds: of the effectors.
        weights: (n_e,) of the rows in the objective, unitless; 0: this component is left free.
        units: (n_e,) metres that one unit of a row counts as [m, m/rad, 1/m²].
        exact: (n_e,) whether a row is to meet its target exactly.
        scale: (n_e,) weights times units: what makes a row a term of the objective, in metres.
        any_exact: whether there is one.
        positions_only: whether all effectors are points or centres, so that values are rows.
        row_starts: (p + 1,) first row of each effector.
        value_starts: (p + 1,) first value of each effector.
        n_rows: rows of all effectors, n_e.
        n_values: goal values of all effectors, n_v.
    """

    names: tuple[str, ...]
    kinds: tuple[EffectorKind, ...]
    weights: Array
    units: Array
    exact: Bools
    scale: Array = field(init=False)
    any_exact: bool = field(init=False)
    positions_only: bool = field(init=False)
    row_starts: Ints = field(init=False)
    value_starts: Ints = field(init=False)
    n_rows: int = field(init=False)
    n_values: int = field(init=False)

    def __post_init__(self) -> None:
        rows, values = ([of[kind] for kind in self.kinds] for of in (ROWS, VALUES))
        known = {
            "scale": self.weights * self.units,
            "any_exact": bool(self.exact.any()),
            "positions_only": {"point", "centre"}.issuperset(self.kinds),
            "row_starts": np.cumsum([0, *rows]),
            "value_starts": np.cumsum([0, *values]),
            "n_rows": sum(rows),
            "n_values": sum(values),
        }
        for name, value in known.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.names)

    def rows_of(self, effector: int) -> slice:
        """Rows of an effector."""
        return slice(int(self.row_starts[effector]), int(self.row_starts[effector + 1]))

    def values_of(self, effector: int) -> slice:
        """Goal values of an effector."""
        return slice(int(self.value_starts[effector]), int(self.value_starts[effector + 1]))

    def row_name(self, row: int) -> str:
        """What a row is called in messages."""
        effector = int(np.searchsorted(self.row_starts, row, side="right")) - 1
        kind, number = self.kinds[effector], row - int(self.row_starts[effector])
        component = COMPONENT_NAMES[number] if ROWS[kind] > 1 else kind
        return f"{component} of effector {self.names[effector]}"

    def missed_rows(self, errors: Array) -> tuple[str, ...]:
        """Names of the exact rows that share in errors (n_e,), by a thousandth of the largest at least."""
        sizes = np.where(self.exact, np.abs(self.scale * errors), 0.0)
        found = np.flatnonzero(sizes > MISSED * sizes.max(initial=0.0))
        return tuple(self.row_name(row) for row in found.tolist())

    def parts(self) -> list[slice]:
        """Rows that are one vector or number each: positions, rotations, scalars."""
        found = []
        for i, kind in enumerate(self.kinds):
            first = int(self.row_starts[i])
            found.append(slice(first, first + min(ROWS[kind], 3)))
            if kind == "frame":
                found.append(slice(first + 3, first + 6))
        return found

    def error(self, end: Array, start: Array) -> float:
        """Largest difference of a part with weight between values (n_v,), in metres by `units` [m]."""
        return float(self.lengths(self.counted(end, start)).max())

    def counted(self, end: Array, start: Array) -> Array:
        """Row values (n_e,) of the difference between values (n_v,), zero in those without weight."""
        found: Array = np.where(self.weights > 0.0, self.difference(end, start), 0.0)
        return found

    def lengths(self, rows: Array) -> Array:
        """Length of each part (`parts`) of rows (n_e,), in metres by `units`; inf where that overflows."""
        metres = (self.units * rows).tolist()
        return np.array([math.hypot(*metres[part]) for part in self.parts()])

    def in_metres(self, rows: Array) -> Array:
        """Rows (n_e, m) in metres by `units`: (3 q, m), three for each part (`parts`), zeros for scalars."""
        metres, parts = self.units[:, None] * rows, self.parts()
        found = np.zeros((3 * len(parts), rows.shape[1]))
        for i, part in enumerate(parts):
            found[3 * i : 3 * i + part.stop - part.start] = metres[part]
        return found

    def goal_values(self, target: Target) -> Array | None:
        """A target as a copy of goal values (n_v,), see `target_values`; None where they are not `checked`.

        Raises:
            ValueError: it has another shape, or entries that are no numbers.
        """
        return self.checked(target_values(target, self.names, self.kinds))

    def checked(self, values: Array) -> Array | None:
        """A copy of values (n_v,) with quaternions of length one; None: they are no goal of these effectors.

        That is: of another number, not finite, or with quaternions of another length.
        """
        if values.shape != (self.n_values,) or not all(np.isfinite(values).tolist()):
            return None
        values = values.copy()
        if self.positions_only:
            return values
        for _, part in self._rotations():
            q = values[part]  # a view
            size = math.hypot(*q.tolist())
            if abs(size - 1.0) > UNIT_LENGTH:
                return None
            q /= size
        return values

    def row_targets(self, now: Array, goal: Array) -> Array:
        """Values (n_e,) that rows are to reach in a step from values now (n_v,) towards a goal (n_v,)."""
        if self.positions_only:
            return goal
        target = self._rows(goal)
        for rows, values in self._rotations():
            r = rotation_between(now[values], goal[values])
            angle = float(np.linalg.norm(r))
            if angle > FARTHEST_PULL:
                r *= (np.pi - angle) / (np.pi - FARTHEST_PULL)
            target[rows] = r
        return target

    def values_at(self, now: Array, delta: Array) -> Array:
        """Goal values (n_v,) where the rows of a step from values now (n_v,) have values delta (n_e,)."""
        if self.positions_only:
            return delta
        return self._moved(now, delta, np.zeros(self.n_values))

    def moved(self, values: Array, change: Array) -> Array:
        """Values (n_v,) changed by some amount of each row (n_e,); rotations about their own axes."""
        if self.positions_only:
            return values + change
        return self._moved(values, change, values)

    def difference(self, end: Array, start: Array) -> Array:
        """The change (n_e,) of the rows from values `start` to `end`, each (n_v,): moved(start, …) = end."""
        if self.positions_only:
            return end - start
        change = self._rows(end) - self._rows(start)
        for rows, values in self._rotations():
            change[rows] = rotation_between(start[values], end[values])
        return change

    def positions_at(self, positions: Array, values: Array) -> Array:
        """Positions (p, 3) [m] of effectors at values (n_v,), the given ones where these have none."""
        if self.positions_only:
            return values.reshape(-1, 3)
        found = positions.copy()
        for i, kind in enumerate(self.kinds):
            if VALUES[kind] >= 3:
                first = int(self.value_starts[i])
                found[i] = values[first : first + 3]
        return found

    def position_values(self, values: Array) -> Array:
        """The positions among values (n_v,), of effectors that have one: (m, 3) [m]."""
        starts = [
            int(self.value_starts[i]) for i, kind in enumerate(self.kinds) if VALUES[kind] >= 3
        ]
        return np.array([values[first : first + 3] for first in starts]).reshape(-1, 3)

    def position_changes(self, change: Array) -> Array:
        """The part of row changes (n_e,) that are positions, zero for scalars: (p, 3) [m]."""
        found = np.zeros((len(self), 3))
        for i, kind in enumerate(self.kinds):
            if ROWS[kind] >= 3:
                first = int(self.row_starts[i])
                found[i] = change[first : first + 3]
        return found

    def _moved(self, values: Array, change: Array, base: Array) -> Array:
        """`base` (n_v,) plus the change of rows; quaternions are those of `values` turned by it."""
        result = np.empty(self.n_values)
        for rows, at in self._translations():
            result[at] = base[at] + change[rows]
        for rows, at in self._rotations():
            result[at] = rotated_by(values[at], np.ascontiguousarray(change[rows]))
        return result

    def _rows(self, values: Array) -> Array:
        """Values (n_v,) without their quaternions, zero in the rows of rotations: (n_e,)."""
        found = np.zeros(self.n_rows)
        for rows, at in self._translations():
            found[rows] = values[at]
        return found

    def _translations(self) -> list[tuple[slice, slice]]:
        """Rows and values of every effector but those of its rotation."""
        starts = zip(self.kinds, self.row_starts.tolist(), self.value_starts.tolist(), strict=False)
        return [
            (slice(row, row + min(ROWS[kind], 3)), slice(value, value + min(ROWS[kind], 3)))
            for kind, row, value in starts
        ]

    def _rotations(self) -> list[tuple[slice, slice]]:
        """Rows and values of every rotation."""
        starts = zip(self.kinds, self.row_starts.tolist(), self.value_starts.tolist(), strict=False)
        return [
            (slice(row + 3, row + 6), slice(value + 3, value + 7))
            for kind, row, value in starts
            if kind == "frame"
        ]


def effector_layout(
    effectors: Sequence[EffectorSettings], size: float, volumes: dict[str, float]
) -> EffectorLayout:
    """The layout of the effectors of a robot file.

    Args:
        effectors: of the file.
        size: of the robot [m].
        volumes: of cavities at rest, by the name of their effector [m³].
    """
    units, weights, exact = [], [], []
    for item in effectors:
        rows = ROWS[item.kind]
        unit = np.ones(rows)
        if item.kind == "frame":
            unit[3:] = size
        if item.kind == "volume":
            unit[:] = abs(volumes[item.name]) ** (-2.0 / 3.0)
        units.append(unit)
        weights.append(np.broadcast_to(np.asarray(item.weight, dtype=float), (rows,)))
        exact.append((weights[-1] > 0.0) & item.exact)
    return EffectorLayout(
        tuple(item.name for item in effectors),
        tuple(item.kind for item in effectors),
        np.concatenate([np.zeros(0), *weights]),
        np.concatenate([np.zeros(0), *units]),
        np.concatenate([np.zeros(0, np.bool_), *exact]),
    )
