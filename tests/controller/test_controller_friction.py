"""The controller's model on a table with friction: steps, holds and what an inverse needs of them."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.blocks import block
from support.robots.bodies import beam_config, box_mesh, pressing_finger

from tauten.controller import Controller, ControllerSettings, Status
from tauten.controller.planning import FRICTION_SHARE
from tauten.controller.qpcc import TimeLimit
from tauten.controller.step import hold, prepare
from tauten.model import Command, Robot, Simulator
from tauten.model.friction import FrictionProblem, certify_friction
from tauten.model.load import build_robot
from tauten.model.schema import RobotConfig
from tauten.service.node.metrics import prometheus_text
from tauten.service.node.outputs import contact_diagnostic
from tauten.service.operate.contacts import certificate_in

SIZE = (0.1, 0.01, 0.01)


def finger(
    friction: float, scheme: str = "implicit-euler", table: float = -0.001, held: float = 0.0001
) -> Robot:
    """A beam above a table, by default 1 mm, which a cable on its lower side bends down.

    Args:
        friction: coefficient.
        scheme: of its steps.
        table: height of it [m].
        held: length of the beam that is fixed [m].
    """
    settings = beam_config(
        SIZE, fixed=[{"lower": [-1.0, -1.0, -1.0], "upper": [held, 1.0, 1.0]}], gravity=[0.0, 0.0, -9.81],
        integration={"scheme": scheme},
        regions=[{"name": "below", "kind": "normal", "direction": [0, 0, -1]}],
        obstacles=[
            {"name": "table", "shape": "plane",
             "parameters": {"point": [0.0, 0.0, table], "normal": [0.0, 0.0, 1.0]}}
        ],
        contacts=[
            {"candidates": "below", "against": "table", "points": 20, "friction": friction}
        ],
    )  # fmt: skip
    return build_robot(RobotConfig.model_validate(settings), box_mesh(SIZE, (10, 1, 1)), "finger")


@pytest.fixture(scope="module", params=["implicit-euler", "quasi-static"])
def pressing(request: pytest.FixtureRequest) -> Controller:
    """A finger that presses on a table and draws its tip back."""
    controller = Controller(finger(0.5, request.param))
    goal = controller.tip - [0.01, 0.0, 0.003]
    for _ in range(40):
        assert controller.step(goal).status.usable
    return controller


def test_forces_of_the_model_are_in_their_cones(pressing: Controller) -> None:
    contacts = pressing.contacts
    normal = contacts.normal_force
    across = np.linalg.norm(contacts.force - normal[:, None] * contacts.contacts.normal, axis=1)
    assert normal.max() > 0.01
    assert (across <= 0.5 * normal * (1.0 + 1e-6) + 1e-9).all()
    assert across.max() > 1e-3
    held = contacts.pushing & ~contacts.sliding
    np.testing.assert_allclose((0.5 * normal - across)[held], contacts.margin[held], atol=1e-9)


def test_contacts_of_a_hold_are_certified(pressing: Controller) -> None:
    """The forces that a forward step found, in the problem of its unit columns at these efforts."""
    settings = pressing.settings
    robot, now = pressing.robot.fork(), (pressing.state, pressing.forces, pressing.position)
    horizon = pressing.horizon
    prepared = prepare(horizon, pressing.space, *now, settings.enrichment)
    keep = Command.of(pressing.position, None)
    held = hold(robot, prepared, keep, pressing.position, settings.enrichment).predicted
    W, lam, a = held.step.compliance.W, held.lam, held.step.layout.actuators
    c = held.step.layout.contacts
    r, q = lam[c], held.step.compliance.delta_free[c] + W[c, a] @ lam[a]
    problem = FrictionProblem(W[c, c], q, held.step.friction)
    np.testing.assert_allclose(q + problem.W @ r, held.delta[c], atol=1e-12)
    found = certify_friction(problem, r)
    assert found.error < 1e-8 * max(np.abs(problem.q).max(), 1e-3)
    assert found.closed.any() and found.work <= 1e-10


def test_plans_count_on_a_share_of_the_friction(pressing: Controller) -> None:
    """What is decided stays within narrower cones: with 20 % less friction and 20 % more load too."""
    share = ControllerSettings(friction_share=FRICTION_SHARE)
    controller = Controller(pressing.robot, settings=share)
    goal = controller.tip - [0.01, 0.0, 0.003]
    slopes = []
    for _ in range(12):
        controller.step(goal)
        decision = controller.last_decision
        assert decision is not None and decision.plan is not None
        planned = decision.plan.predicted
        r = planned.lam[planned.step.layout.actuators.stop :].reshape(-1, 3)
        across = np.linalg.norm(r[:, 1:], axis=1)
        assert (1.2 * across <= 0.8 * 0.5 * r[:, 0] + 1e-7).all()
        slopes += (across[r[:, 0] > 1e-3] / r[r[:, 0] > 1e-3, 0]).tolist()
    assert max(slopes) > FRICTION_SHARE * 0.5 * 0.99  # and some slip at that border


def test_all_of_the_friction_counts_where_it_holds_nothing(pressing: Controller) -> None:
    """A finger that only presses; not one that keeps a force, nor a cube that lies on what it touches."""
    assert pressing.settings.friction_share == 1.0
    assert Controller(pressing_finger(0.5, max_force=0.1)).settings.friction_share == FRICTION_SHARE
    assert Controller(block()).settings.friction_share == FRICTION_SHARE
    own = ControllerSettings(friction_share=0.9)
    assert Controller(pressing.robot, settings=own).settings.friction_share == 0.9


def test_candidates_on_what_is_fixed_are_in_nobodys_way() -> None:
    """Nothing moves them, so no force on them is needed, and none would help."""
    robot = finger(0.5, table=0.00004, held=0.0301)
    simulator = Simulator(robot, "full")
    for _ in range(3):
        assert simulator.step(position=[0.0]).converged
    assert simulator.certificate is None or simulator.certificate.error < 1e-8
    controller = Controller(finger(0.5, held=0.0301))
    goal = controller.tip + np.array([0.0, 0.0, 0.05])  # out of reach: contact is looked for
    statuses = {controller.step(goal).status for _ in range(10)}
    assert Status.NOT_FOUND not in statuses


def test_contacts_are_those_of_the_obstacles_after_a_reset() -> None:
    controller = Controller(finger(0.5))
    before = len(controller.contacts.contacts)
    assert before > 0
    controller.place("table", [0.0, 0.0, -0.5])
    controller.step(controller.effector_values)
    assert len(controller.contacts.contacts) == 0
    controller.reset()
    assert len(controller.contacts.contacts) == before


def test_the_certificate_of_the_last_step_is_that_of_its_contacts(pressing: Controller) -> None:
    found, contacts = pressing.certificate, pressing.contacts
    assert found is not None
    assert 0.0 <= found.error < 1e-8
    assert found.cone <= 1e-9
    assert found.angle < 1e-4
    assert found.work <= found.error * contacts.normal_force.sum()  # slip within the error
    assert found.closed.sum() == contacts.pushing.sum()
    assert found.sticking.sum() == (contacts.pushing & ~contacts.sliding).sum()
    if found.sticking.any():
        assert found.least_margin == pytest.approx(contacts.margin[contacts.margin > 0.0].min())
    health = contact_diagnostic(pressing)
    assert health.values["error [m]"] == f"{found.error:.2g}"
    assert all(words in health.message for words in found.doubts)
    said = certificate_in(prometheus_text("finger", [health], {}).decode())  # of `tauten contacts`
    assert said.startswith(f"error {found.error:.2g} m, beyond the cone")
    assert f"least distance to slip {found.least_margin:.2g} N" in said
    assert all(words in said for words in found.doubts)


def test_without_friction_there_is_no_certificate_in_metrics() -> None:
    health = contact_diagnostic(Controller(finger(0.0)))
    assert certificate_in(prometheus_text("finger", [health], {}).decode()) == ""


def test_a_controller_that_touches_nothing_has_no_certificate() -> None:
    controller = Controller(finger(0.5, table=-0.02))
    assert controller.certificate is None
    controller.step(controller.tip)
    assert controller.certificate is None


@pytest.mark.parametrize(
    ("scheme", "checks"),
    [
        pytest.param(scheme, checks, marks=[] if usual else pytest.mark.slow)
        for scheme, few in (("implicit-euler", (0, 3)), ("quasi-static", (2,)))
        for checks in (0, 2, 3)
        for usual in [checks in few]
    ],
)
def test_decisions_that_are_all_cut_arrive_together(scheme: str, checks: int) -> None:
    """Whatever the time: each goes on where the one before was cut. Without that the finger stands still."""
    slow, free = Controller(finger(0.5, scheme)), Controller(finger(0.5, scheme))
    goal, statuses = free.tip - [0.01, 0.0, 0.003], []
    for _ in range(25):
        assert free.step(goal).status is Status.OK
        slow.prepare()
        slow.rehearse(goal)  # which changes nothing
        statuses.append(slow.decide(goal, TimeLimit(checks=checks)).status)
        decision = slow.last_decision
        assert decision is not None and decision.plan is not None
        problem, planned = decision.plan.problem, decision.plan.predicted
        z = planned.lam[planned.step.layout.actuators.start :]
        scale = np.abs(problem.g_hi - problem.g_lo).max()
        assert (problem.G @ z >= problem.g_lo - 1e-6 * scale).all()
        assert (problem.G @ z <= problem.g_hi + 1e-6 * scale).all()
        assert decision.certificate.complementarity < 1e-4
        slow.advance()
    assert set(statuses) == {Status.MAX_PIVOTS}
    missed, least = np.linalg.norm(slow.tip - goal), np.linalg.norm(free.tip - goal)
    assert missed < least + 1e-4 < 5e-3  # m, of 10.4 mm at first


@pytest.mark.parametrize("checks", [0, 3, 10])
def test_a_decision_that_was_cut_is_repeated_by_its_checks(checks: int) -> None:
    """Whatever the clock: as a replay does with the number of checks in a log."""
    first, again = Controller(finger(0.5)), Controller(finger(0.5))
    goal, cut = first.tip - [0.01, 0.0, 0.003], 0
    for _ in range(10):
        time = TimeLimit(checks / 1000.0, Clock())
        wanted = first.decide(goal, time)
        repeated = again.decide(goal, TimeLimit(checks=time.repeats) if time.cut else None)
        assert repeated.position.tolist() == wanted.position.tolist()
        assert repeated.status is wanted.status
        first.advance()
        again.advance()
        cut += time.cut
    assert cut > 0


class Clock:
    """A clock that is a millisecond further each time that it is read."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        """The time [s]."""
        self.now += 1e-3
        return self.now


@pytest.mark.parametrize("seconds", [-1.0, np.nan])
def test_a_time_that_is_none_is_refused(seconds: float) -> None:
    with pytest.raises(ValueError, match="expected 0 or more"):
        TimeLimit(seconds)
