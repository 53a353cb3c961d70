"""All of a plan that needs no target: the step over the horizon, and where it leads when actuators hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.controller.planning.energy import energy_scales
from tauten.controller.planning.horizon import Horizon
from tauten.controller.planning.inverse import weighted_rows
from tauten.controller.planning.settings import DecideSettings
from tauten.model import (
    Clusters,
    Command,
    CondensedStep,
    Enrichment,
    Forces,
    PredictedStep,
    Robot,
    forward_step,
    under_friction,
)
from tauten.model.numerics import Array


@dataclass(frozen=True, slots=True)
class Prepared:
    """All of a step but the target.

    Attributes:
        step: of one tick: system, rows, compliance of effectors, cables, reduced contacts, unit columns.
        held: the step over the horizon in which the actuators keep what they have; plans start from it.
        forces: of the last step, where the solvers of the tick start.
        scales: of the actuation energy in each cluster (c,), s in (T1) [m/N].
        clusters: what of the robot acts on each other.
        farther: the step over the horizon with the friction of its contacts, from which `held` differs
            where there is any: plans have the friction of the last step as a load.
        effort: (n_a,) efforts of `held`, within their limits: two cables of one hinge that are both wound
            a little too far need any tension to stay so, which would outweigh all else [N, Pa].
    """

    step: CondensedStep
    held: PredictedStep
    forces: Forces
    scales: Array
    clusters: Clusters
    farther: CondensedStep
    effort: Array


@dataclass(frozen=True, slots=True)
class Situation:
    """What a plan starts from and what bounds it.

    Attributes:
        robot: limits, time step, weights of the effectors.
        prepared: the step.
        position: (n_a,) positions of the actuators commanded last [m].
        settings: weights and tolerances.
        locks: what locked actuators keep; None: all are decided.
    """

    robot: Robot
    prepared: Prepared
    position: Array
    settings: DecideSettings
    locks: Command | None


def prepared_plans(
    horizon: Horizon,
    step: CondensedStep,
    farther: CondensedStep,
    forces: Forces,
    keep: Command,
    enrichment: Enrichment,
) -> Prepared:
    """All of a step but the target, from its condensed rows."""
    robot, clusters = horizon.robot, horizon.clusters
    held = held_ahead(farther, forces, keep, enrichment)
    found, layout = held.step.compliance, held.step.layout
    W, _ = weighted_rows(found.W, found.delta_free, robot.effector_layout.scale)
    pushing = held.lam[layout.contacts] > 0.0
    if held.step.frictional:  # tangents never push
        gaps = np.zeros_like(pushing)
        gaps[held.step.gap_rows - layout.contacts.start] = True
        pushing &= gaps
    scales = energy_scales(W, layout, pushing, robot.actuators.groups, clusters)
    effort = np.minimum(np.maximum(held.effort, robot.limits.effort_min), robot.limits.effort_max)
    return Prepared(step, held, forces, scales, clusters, farther, effort)


def held_ahead(
    farther: CondensedStep, forces: Forces, keep: Command, enrichment: Enrichment
) -> PredictedStep:
    """The step over the horizon in which the actuators keep what they have.

    With friction, unless no forces within the cones are found: then that of the last step is a load.
    """
    solved = forward_step(farther, enrichment, forces, keep)
    if solved.converged or not farther.frictional:
        return solved
    return forward_step(under_friction(farther, forces), enrichment, forces, keep)
