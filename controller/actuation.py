"""What leaves a controller: positions and efforts of the actuators, with their certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tauten.controller.qpcc import Certificate, Status
from tauten.controller.winches import ROUNDING
from tauten.model import EffectorRows, Robot, RobotRows
from tauten.model.numerics import Array

if TYPE_CHECKING:
    from tauten.controller.step import Decision

NO_CERTIFICATE = Certificate(np.nan, np.nan, np.nan, np.nan)  # nothing was solved


@dataclass(frozen=True, slots=True)
class Actuation:
    """Positions and efforts of the actuators, and their certificate.

    Attributes:
        position: (n_a,) positions, of cables pulled lengths [m, m³].
        effort: (n_a,) efforts, of cables tensions, within their limits [N, Pa].
        needed: (n_a,) efforts of the model, which in a hold may be beyond the limits [N, Pa].
        effector: (p, 3) predicted positions of the effectors [m]; those of a distance, length or
            volume are where they are drawn before the step.
        effector_values: (n_v,) their predicted goal values, see `EffectorLayout`.
        status: how the decision or the hold ended; where it is not usable, the actuators hold.
        certificate: residuals and deepest predicted gap.
        conflict: names of the limits that conflict; where the status is NOT_FINITE, of the actuators,
            effectors and contacts of which something is not finite.
        clamped: whether limits changed positions or efforts.
    """

    position: Array
    effort: Array
    needed: Array
    effector: Array
    effector_values: Array
    status: Status
    certificate: Certificate
    conflict: tuple[str, ...] = ()
    clamped: bool = False

    def with_values(self, position: Array, effort: Array, clamped: bool) -> Actuation:
        """The same actuation with other values.

        Args:
            position: (n_a,) positions.
            effort: (n_a,) efforts.
            clamped: whether a limiter changed them.
        """
        return Actuation(
            position, effort, self.needed, self.effector, self.effector_values, self.status,
            self.certificate, self.conflict, clamped,
        )  # fmt: skip

    def copy(self) -> Actuation:
        """The same actuation in arrays of its own."""
        return Actuation(
            self.position.copy(), self.effort.copy(), self.needed.copy(), self.effector.copy(),
            self.effector_values.copy(), self.status, self.certificate, self.conflict, self.clamped,
        )  # fmt: skip


def values_known(effectors: EffectorRows) -> bool:
    """Whether the rows, goal values and positions of effectors are finite.

    Those of points are rows alone, in which solvers find what is not.
    """
    found = effectors.delta, effectors.values, effectors.positions.ravel()
    return bool(np.logical_and.reduce(np.isfinite(np.concatenate(found))))


def unknown_rows(robot: Robot, rows: RobotRows) -> tuple[str, ...]:
    """Names of the actuators, effectors and contacts of which something is not finite.

    Args:
        robot: whose rows these are.
        rows: of all effectors, and of contacts in range.
    """
    actuators, effectors, contacts = (
        ~(np.isfinite(found.delta) & np.isfinite(found.dense()).all(axis=1))
        for found in (rows.actuators, rows.effectors, rows.contacts.rows)
    )
    layout, pairs = robot.effector_layout, np.unique(rows.contacts.pair[contacts])
    values, positions = rows.effectors.values, rows.effectors.positions
    return (
        *(robot.actuators.names[i] for i in np.flatnonzero(actuators)),
        *(
            name
            for i, name in enumerate(layout.names)
            if effectors[layout.rows_of(i)].any()
            or not (
                np.isfinite(values[layout.values_of(i)]).all() and np.isfinite(positions[i]).all()
            )
        ),
        *(robot.pairs[i].name for i in pairs),
    )


def decided_actuation(
    robot: Robot, decision: Decision, status: Status, conflict: tuple[str, ...]
) -> Actuation:
    """What a decision sends, with efforts within their limits."""
    if status is Status.NOT_FINITE:
        conflict = unknown_rows(robot, decision.predicted.step.rows)
    rows, layout, limits = robot.layout, robot.effector_layout, robot.limits
    predicted, effectors = decision.predicted, decision.predicted.step.rows.effectors
    values = layout.values_at(effectors.values, predicted.delta[rows.effectors])
    needed = predicted.effort
    effort = np.minimum(np.maximum(needed, limits.effort_min), limits.effort_max)
    clamped = any((np.abs(effort - needed) > ROUNDING * limits.largest_effort).tolist())
    return Actuation(
        position=decision.position,
        effort=effort,
        needed=needed,
        effector=layout.positions_at(effectors.positions, values),
        effector_values=values,
        status=status,
        certificate=decision.certificate,
        conflict=conflict,
        clamped=clamped,
    )
