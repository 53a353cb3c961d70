"""Stages of second order of what turns: the centrifugal and gyroscopic forces are those at their end."""

from __future__ import annotations

from dataclasses import replace

from tauten.model.robot import Robot
from tauten.model.step import CondensedStep, Forces, known_forces


def turning_as_at_end(robot: Robot, step: CondensedStep, forces: Forces) -> CondensedStep:
    """A stage with the centrifugal and gyroscopic forces of the velocity at its end.

    They depend on the velocity, and A has no derivative of them, which is not symmetric. With those of the
    velocity at the start, or at an end to which no cable and no contact pushes, a stage is of first order,
    and a body that tumbles gains energy. Forces of the stage before predict the end well enough.
    """
    system, known = step.system, step.compliance
    assert system.inertia is not None
    dv = system.v_free - system.v + system.h * known.pushed(known_forces(step, forces))  # (n,)
    there = robot.body.inertia_at(replace(step.state, v=step.state.v + dv))
    assert there is not None
    more = system.solve(system.h * (there - system.inertia))  # (n,) change of the velocity
    return replace(
        step,
        system=replace(system, v_free=system.v_free + more),
        compliance=replace(known, delta_free=known.delta_free + system.h * (known.H @ more)),
    )
