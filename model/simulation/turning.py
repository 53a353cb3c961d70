"""Stages of second order of what turns: the centrifugal and gyroscopic forces are those at their end."""

from __future__ import annotations

from dataclasses import replace

from tauten.model.robot import Robot
from tauten.model.step import CondensedStep, PredictedStep


def turning_as_at_end(robot: Robot, solved: PredictedStep) -> CondensedStep:
    """A stage with the centrifugal and gyroscopic forces of the velocity at its end, to be solved again.

    They depend on the velocity, and A has no derivative of them, which is not symmetric: with those of the
    velocity at the start a stage is of first order, and a body that tumbles gains energy. The velocity at the
    end is that under the cables and contacts of the stage: what they change of it counts to the same order.

    Args:
        robot: whose workspace contains the factors.
        solved: the stage with the forces of the velocity at its start.
    """
    step, system, known = solved.step, solved.step.system, solved.step.compliance
    there = robot.body.inertia_at(replace(step.state, v=step.state.v + solved.dv))
    assert there is not None
    assert system.inertia is not None
    more = system.solve(system.h * (there - system.inertia))  # (n,) change of the velocity
    return replace(
        step,
        system=replace(system, v_free=system.v_free + more),
        compliance=replace(known, delta_free=known.delta_free + system.h * (known.H @ more)),
    )
