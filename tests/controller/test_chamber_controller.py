"""Inverse control of chambers: targets are reached, limits hold, certificates are right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bodies import CABLE, CHAMBER, pneumatic_robot

from tauten.controller import (
    Controller,
    Status,
    energy_scale,
    hold_certificate,
    prepare,
)
from tauten.model import Command, Enrichment, Simulator, forward_step, row_layout
from tauten.model.numerics import Array

NONE = Enrichment(tolerance=np.inf, rounds=0, per_pair=0)


def reachable(pressure: float) -> Array:
    """Where the tip is under a pressure (1, 3) [m]."""
    simulator = Simulator(pneumatic_robot(), "none")
    assert simulator.settle(effort=[pressure]).converged
    return simulator.effector


@pytest.mark.long
@pytest.mark.parametrize("pressure", [3e4, pytest.param(1e4, marks=pytest.mark.slow), -4e3])
def test_the_pressure_of_a_reachable_target_is_found(pressure: float) -> None:
    damped = pneumatic_robot(integration={"rayleigh_stiffness": 0.02})
    follower, goal = Controller(damped), reachable(pressure)
    for _ in range(60):
        actuation = follower.step(goal)
        assert actuation.status is Status.OK
    np.testing.assert_allclose(follower.effector, goal, atol=1e-5)
    assert actuation.effort[0] == pytest.approx(pressure, rel=0.02)
    assert actuation.certificate.primal < 1e-6


def test_beyond_its_largest_pressure_the_nearest_is_decided() -> None:
    weak = pneumatic_robot(chambers=[{**CHAMBER, "max_pressure": 1e4}])
    follower, goal = Controller(weak), reachable(3e4)
    for _ in range(60):
        actuation = follower.step(goal)
        assert actuation.status is Status.OK
    assert actuation.effort[0] == pytest.approx(1e4)


def test_the_volume_changes_no_faster_than_its_rate() -> None:
    follower, goal, last = Controller(pneumatic_robot()), reachable(4e4), 0.0
    for _ in range(10):
        position = follower.step(goal).position[0]
        assert abs(position - last) <= CHAMBER["max_rate"] * 0.02 * (1.0 + 1e-9)  # type: ignore[operator]
        last = position


def test_a_hold_keeps_the_pressure_and_its_certificate_sees_errors() -> None:
    follower = Controller(pneumatic_robot(cables=[CABLE]))
    goal = follower.effector[0] + np.array([0.0, 0.0, -0.008])
    for _ in range(30):
        left = follower.step(goal)
    held = follower.hold()
    assert held.status is Status.OK
    np.testing.assert_array_equal(held.position[0], left.position[0])
    np.testing.assert_array_equal(held.effort[1], left.effort[1])
    assert held.certificate.complementarity < 1e-9
    robot, forces = follower.robot, follower.forces
    prepared = prepare(
        follower.horizon, follower.space, follower.state, forces, follower.position, NONE
    )
    command = Command.of(follower.position, None)
    solved = forward_step(prepared.step, NONE, forces, command)
    right = hold_certificate(solved, command, robot.limits, robot.actuators)
    wrong = replace(solved, lam=1.01 * solved.lam)
    worse = hold_certificate(wrong, command, robot.limits, robot.actuators)
    assert right.stationarity < 1e-9
    assert worse.stationarity > 1e-3
    assert worse.primal > 1e-3  # the volume is another one


def test_a_hold_beyond_the_least_pressure_names_the_chamber() -> None:
    tight = {**CHAMBER, "held": "position", "min_pressure": -1.0, "max_pressure": 1.0}
    robot = pneumatic_robot(chambers=[tight], gravity=[0.0, 0.0, -500.0])
    actuation = Controller(robot).hold()
    assert actuation.status is Status.INFEASIBLE
    assert actuation.conflict == ("pressure of chamber bellows",)


def test_the_weight_of_the_energy_does_not_depend_on_the_unit_of_a_pressure() -> None:
    """Pressures in kPa and volumes in mL give the same scale s; with one group they would not."""
    rng = np.random.default_rng(0)
    H = rng.standard_normal((6, 8))
    W, groups, open_ = H @ H.T, np.array([0, 0, 1]), np.zeros(0, dtype=np.bool_)
    unit = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 1e3])  # three effector rows, two cables, a chamber
    scale = energy_scale(W, row_layout(3, 3), open_, groups)
    assert energy_scale(unit @ W @ unit, row_layout(3, 3), open_, groups) == pytest.approx(
        scale, rel=1e-12
    )
    assert energy_scale(unit @ W @ unit, row_layout(3, 3), open_) != pytest.approx(scale, rel=0.1)


def test_a_chamber_that_stands_still_on_a_slider_breaks_no_law() -> None:
    """Where nothing changes the terms of a row are rounding, which was compared with itself: RELAXED."""
    root = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}
    slider = {
        "name": "slider", "motion": "translation", "region": root, "axis": [1.0, 0.4, -0.7],
        "max_travel": 0.1, "max_force": 100.0, "max_rate": 1.0,
    }  # fmt: skip
    robot = pneumatic_robot(fixed=[], drives=[slider], integration={"scheme": "quasi-static"})
    controller = Controller(robot, "none")
    assert controller.settle_start().converged
    goal = controller.tip + np.array([0.0, 0.0, 0.004])
    for _ in range(20):
        assert controller.step(goal).status is Status.OK
