"""Locked actuators: the others are decided, limits hold, and what is not possible is one sentence."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.bodies import CABLE, CHAMBER, beam_robot, box_mesh, pneumatic_robot

from tauten.controller import Controller, LockError, Status
from tauten.controller.planning.inverse import inverse_problem
from tauten.controller.planning.locks import LockedStep
from tauten.controller.qpcc import Certificate, Solution
from tauten.model import Command, EmptySpace, Simulator, condense_step, no_forces
from tauten.model.numerics import Array

SIZE = (0.1, 0.02, 0.02)
UPPER = {**CABLE, "name": "upper", "points": [[0.01, 0.01, 0.018], [0.1, 0.01, 0.018]]}

DAMPED = {"rayleigh_stiffness": 0.02}


def controller(**changes: object) -> Controller:
    return Controller(pneumatic_robot(cables=[CABLE], **changes))


def follow(follower: Controller, goal: Array, steps: int = 100) -> None:
    for _ in range(steps):
        actuation = follower.step(goal)
        assert actuation.status.usable, actuation


@pytest.mark.long
def test_a_sealed_chamber_keeps_its_volume_while_the_cable_follows() -> None:
    follower = controller(integration=DAMPED)  # what nothing damps never settles
    goal = follower.effector[0] + np.array([0.0, 0.0, -0.005])
    follower.lock("bellows", position=4e-7)
    follow(follower, goal)
    assert follower.position[1] == pytest.approx(4e-7, abs=1e-15)
    assert abs(follower.effector[0, 2] - goal[2]) < 1e-3
    settled = Simulator(follower.robot, "none")
    assert settled.settle(position=follower.position).converged
    np.testing.assert_allclose(settled.effort, follower.effort, rtol=1e-6)


@pytest.mark.long
def test_a_supply_that_keeps_its_pressure_is_no_longer_decided() -> None:
    follower = controller()
    goal = follower.effector[0] + np.array([0.0, 0.0, -0.005])
    follower.lock("bellows", force=2e4)
    follow(follower, goal)
    assert follower.effort[1] == pytest.approx(2e4)
    assert abs(follower.effector[0, 2] - goal[2]) < 1e-3
    follower.unlock("bellows")
    follow(follower, goal + np.array([0.0, 0.0, 0.003]))
    assert follower.effort[1] != pytest.approx(2e4, rel=1e-3)


@pytest.mark.long
def test_a_jammed_winch_may_go_slack() -> None:
    """The law of a cable holds for one that is locked too: it never pushes."""
    follower = Controller(pneumatic_robot(cables=[CABLE, UPPER], chambers=[]))
    rest = follower.effector[0]
    follower.lock("tendon", position=1e-3)
    follow(follower, rest + np.array([0.0, 0.0, -0.004]), 40)
    taut = follower.effort[0]
    assert taut > 0.0
    follow(follower, rest + np.array([0.0, 0.0, -0.012]), 60)
    assert follower.position[0] == pytest.approx(1e-3)
    follow(follower, rest + np.array([0.0, 0.0, 0.02]), 60)
    assert follower.effort[0] >= 0.0
    assert (follower.effort <= follower.robot.limits.effort_max).all()


def test_a_lock_is_approached_at_the_rate_of_the_actuator() -> None:
    follower, step = controller(), CABLE["max_rate"] * 0.02  # type: ignore[operator]
    follower.lock("tendon", position=0.005)
    goal, positions = follower.effector[0], [0.0]
    for _ in range(6):
        positions.append(float(follower.step(goal).position[0]))
    np.testing.assert_allclose(positions, np.minimum(step * np.arange(7), 0.005), atol=1e-12)
    follower.lock("bellows", force=4e4)
    before = follower.position[1]
    for _ in range(4):
        after = follower.step(goal).position[1]
        assert abs(after - before) <= 1.2 * CHAMBER["max_rate"] * 0.02  # type: ignore[operator]
        before = after


def test_a_hold_moves_nothing_and_keeps_the_locks() -> None:
    follower = controller()
    follower.lock("tendon", position=0.003)
    for _ in range(5):
        assert follower.hold().position[0] == 0.0
        follower.advance()
    follow(follower, follower.effector[0], 20)
    pressure = follower.effort[1]
    for _ in range(20):
        held = follower.hold()
        follower.advance()
    assert held.status is Status.OK
    assert held.position[0] == 0.003
    assert held.effort[0] > 0.0
    assert held.effort[1] == pressure  # the supply keeps the pressure it had


def test_with_all_locked_there_is_nothing_to_decide() -> None:
    follower = controller()
    follower.lock("tendon", position=0.002)
    follower.lock("bellows", force=5e3)
    follow(follower, follower.effector[0] + np.array([0.0, 0.0, -0.01]), 20)
    follower.rehearse(follower.effector)
    np.testing.assert_allclose([follower.position[0], follower.effort[1]], [0.002, 5e3])


def test_with_all_locked_an_exact_target_that_is_missed_is_named() -> None:
    exact = [{"name": "tip", "point": [0.1, 0.01, 0.01], "exact": True}]
    follower = controller(effectors=exact, integration={"scheme": "quasi-static"})
    follower.lock("tendon", position=0.002)
    follower.lock("bellows", force=5e3)
    for _ in range(10):  # until the locks are there
        here = follower.step(follower.effector[0])
    assert here.status is Status.OK
    away = follower.step(follower.effector[0] + np.array([0.0, 0.0, 1e-4]))
    assert (away.status, away.conflict) == (Status.NOT_EXACT, ("z of effector tip",))
    np.testing.assert_allclose(away.position, here.position, rtol=1e-9)
    assert follower.hold().status is Status.OK  # which was asked for nothing


@pytest.mark.long
def test_a_locked_pressure_beyond_its_limit_stops_the_others() -> None:
    """A sealed chamber that the cable squeezes: no decision lets its pressure leave the limits."""
    tight = {**CHAMBER, "max_pressure": 800.0}
    follower = Controller(pneumatic_robot(cables=[CABLE], chambers=[tight]))
    follower.lock("bellows", position=0.0)
    goal = follower.effector[0] + np.array([0.0, 0.0, -0.02])
    for _ in range(60):
        actuation = follower.step(goal)
        assert actuation.status.usable
        assert -5e3 <= actuation.effort[1] <= 800.0 * (1.0 + 1e-6)
    assert actuation.effort[1] == pytest.approx(800.0, rel=1e-3)


def test_reset_unlocks() -> None:
    follower = controller()
    follower.lock("bellows", force=1e3)
    assert follower.locks.by_force.tolist() == [False, True]
    follower.reset()
    assert not (follower.locks.by_force | follower.locks.by_position).any()


@pytest.mark.parametrize(
    ("name", "position", "force", "text"),
    [
        ("bellows", None, None, "lock of chamber bellows: give either a position or a force"),
        ("bellows", 0.0, 0.0, "lock of chamber bellows: give either a position or a force"),
        (
            "gripper",
            0.0,
            None,
            "balloon has no actuator 'gripper', its actuators are tendon, bellows",
        ),
        ("bellows", None, 1e9, "pressure of 1e.09 Pa: allowed are -5000 to 40000 Pa"),
        ("bellows", 1.0, None, "volume change of 1 m³: allowed are -8e-06 to 8e-06 m³"),
        ("tendon", float("nan"), None, "pull of nan m: allowed are 0 to 0.02 m"),
        ("tendon", None, "much", "lock of cable tendon: expected a number, found 'much'"),
        ("tendon", None, float("inf"), "tension of inf N: allowed are 0 to 20 N"),
    ],
)
def test_what_cannot_be_locked_is_one_sentence(
    name: str, position: float | None, force: float | None, text: str
) -> None:
    follower = controller()
    with pytest.raises(LockError, match=text):
        follower.lock(name, position, force)
    with pytest.raises(LockError, match=r"cable tendon is not locked"):
        follower.unlock("tendon")


def test_without_a_lock_nothing_is_solved_differently() -> None:
    """The same decisions bit for bit before a lock and after it was taken away."""
    robot = beam_robot(box_mesh(SIZE, (5, 2, 2)), SIZE)
    plain, other = Controller(robot), Controller(robot)
    goal = plain.effector[0] + np.array([0.0, 0.0, -0.01])
    other.lock("tendon", position=0.01)
    other.unlock("tendon")
    for _ in range(10):
        np.testing.assert_array_equal(plain.step(goal).effort, other.step(goal).effort)


PUSH = {"name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 3.0, 4.0],
        "max_force": 1.0, "max_travel": 0.1, "max_rate": 1.0}  # fmt: skip


def test_limits_of_what_is_locked_are_those_of_all_rows_of_the_step() -> None:
    """A chamber locked at a volume, a force at its effort, a cable at a length: by δ = δ_free + W λ."""
    robot = pneumatic_robot(cables=[CABLE, UPPER], forces=[PUSH])
    tendon, upper, bellows, push = map(
        robot.actuators.names.index, ("tendon", "upper", "bellows", "push")
    )
    locks = Command(np.full(4, np.nan), np.full(4, np.nan))
    locks.position[bellows], locks.position[upper], locks.effort[push] = 2e-7, 1e-3, 0.4
    none, limits = no_forces(4, 0), robot.limits
    step = condense_step(robot, EmptySpace(robot.n_c), robot.rest(), none, True, True)
    locked, target = LockedStep(step, locks), np.zeros(step.layout.n_e)
    assert locked.free.tolist() == [tendon]
    before = inverse_problem(
        locked.W, locked.delta_free, target, np.zeros(1), limits.at(locked.free), robot.h, 1e-6
    )
    problem = locked.bounded(before, limits, robot.actuators)
    x = np.array([3.0, 0.7])  # tensions of tendon and upper [N]
    certificate = Certificate(0.0, 0.0, 0.0, 0.0)
    taut = np.ones(1, np.bool_)
    lam = locked.forces(Solution(x[:1], x[1:], Status.OK, certificate, 0.0, 1, taut))
    delta = (step.compliance.delta_free + step.compliance.W @ lam)[step.layout.actuators]
    effort = lam[step.layout.actuators]
    assert effort[[tendon, upper, push]].tolist() == [3.0, 0.7, 0.4]
    assert abs(effort[bellows]) > 1.0  # Pa, which keep the volume
    assert delta[bellows] == pytest.approx(2e-7, rel=1e-9)
    np.testing.assert_allclose(problem.M @ x + problem.m, delta[upper] - 1e-3, rtol=1e-9)
    rows, added = problem.G @ x, slice(len(before.G), None)
    room = [
        delta[push] - limits.position_min[push],
        effort[bellows] - limits.effort_min[bellows],
        np.inf,
    ]
    np.testing.assert_allclose((rows - problem.g_lo)[added], room, rtol=1e-9)
    room = [
        limits.position_max[push] - delta[push],
        limits.effort_max[bellows] - effort[bellows],
        limits.effort_max[upper] - effort[upper],
    ]
    np.testing.assert_allclose((problem.g_hi - rows)[added], room, rtol=1e-9)
    said = [name for name, _ in problem.row_names[added]]
    assert [one.split()[-1] for one in said] == ["push", "bellows", "upper"]
