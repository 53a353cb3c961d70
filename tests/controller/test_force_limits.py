"""Limits of contact forces that decisions keep: on a table, in a grasp, and where they cannot be kept."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.bodies import pressed, pressing_finger

from tauten.controller import Controller, Status
from tauten.model import ContactSpace, ReducedContacts, Robot, Simulator, load_robot
from tauten.model.contact import ForceBounds
from tauten.model.load import make_robot, shipped_folder
from tauten.model.numerics import Array
from tauten.model.rows import ContactRows
from tauten.model.schema import Changes, read_toml
from tauten.model.step.force_limits import (
    DIRECTIONS,
    force_limits,
    friction_sums,
)
from tauten.reduction.state import StateBasis, reduced_robot
from tauten.service.node.outputs import contact_diagnostic
from tauten.service.wire import Level

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_finger_presses_as_hard_as_it_may(friction: float) -> None:
    """The target lies 20 mm behind the table; at the positions found a simulator presses as hard."""
    robot = pressing_finger(friction, max_force=0.06)
    controller = Controller(robot)
    free, _, _ = pressed(Controller(pressing_finger(friction)), 0.02)
    force, statuses, conflict = pressed(controller, 0.02)
    assert free > 0.1
    assert set(statuses[-5:]) == {Status.OK}  # and not that it seeks contact
    assert force == pytest.approx(0.06, rel=0.02) and conflict == ()
    simulator = Simulator(robot)
    assert simulator.settle(position=controller.position).converged
    assert simulator.contacts.normal_force.sum() == pytest.approx(
        0.06, rel=0.1 if friction else 1e-3
    )


def test_the_largest_force_of_all_contacts_counts_too() -> None:
    force, statuses, _ = pressed(Controller(pressing_finger(0.0, total=0.05)), 0.02)
    assert force == pytest.approx(0.05, rel=1e-3) and statuses[-1] is Status.OK


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_the_largest_force_on_an_obstacle_is_kept(friction: float) -> None:
    """Of all that touches it, whatever its contacts may each."""
    controller = Controller(pressing_finger(friction, table=0.05, max_force=0.5))
    force, statuses, _ = pressed(controller, 0.02)
    assert force == pytest.approx(0.05, rel=0.02) and statuses[-1] is Status.OK
    controller.lock("tendon", position=1.4 * float(controller.position[0]))
    _, _, conflict = pressed(controller, 0.02)
    assert conflict == ("largest force of all contacts on table",)


def test_a_finger_that_slides_keeps_no_distance_to_slip() -> None:
    """Nobody has asked for one: health warns of nothing, and holds are not relaxed."""
    controller = Controller(pressing_finger(0.1, max_force=5.0))
    pressed(controller, 0.02, 10)
    found, grasp = controller.contacts, controller.grasp
    assert grasp is not None and any(grasp.kept)
    slid = replace(found, force=found.force + 0.2 * found.normal_force.sum() * np.eye(3)[0])
    assert grasp.exceeded(slid) == ()
    assert contact_diagnostic(controller).level is Level.OK


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_what_has_been_touched_is_not_let_go(friction: float) -> None:
    """The target goes 20 mm up: the finger presses on with the smallest force, until it is to let go."""
    controller = Controller(pressing_finger(friction, min_force=0.08))
    pressed(controller, 0.02)
    force, _, _ = pressed(controller, -0.02)
    assert force == pytest.approx(0.08, rel=0.1)
    controller.let_go()
    force, _, _ = pressed(controller, -0.02, 5)
    assert force == 0.0
    pressed(controller, 0.02, 15)  # the next grasp is kept again
    force, _, _ = pressed(controller, -0.02, 10)
    assert force == pytest.approx(0.08, rel=0.1)


def test_what_has_been_brushed_is_let_go() -> None:
    """With less than a tenth of the smallest force there is no grasp: the finger comes off by itself."""
    controller = Controller(pressing_finger(0.0, min_force=5.0))
    force, _, _ = pressed(controller, 0.004)
    assert 0.0 < force < 0.1 * 5.0
    force, statuses, _ = pressed(controller, -0.02, 5)
    assert force == 0.0 and set(statuses) == {Status.OK}


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_of_contradicting_limits_the_largest_force_is_kept(friction: float) -> None:
    """A grasp with 0.12 N, of which both together may have no more than 0.06 N: both are named."""
    controller = Controller(pressing_finger(friction, min_force=0.12))
    force, _, _ = pressed(controller, 0.02, 15)
    assert force > 0.12
    both = Controller(pressing_finger(friction, min_force=0.12, total=0.13))
    assert both.settings.forces is not None
    one, total = both.settings.forces.limited
    less = replace(total, bounds=ForceBounds(largest=0.06))
    both.settings = replace(
        both.settings, forces=replace(both.settings.forces, limited=(one, less))
    )
    both.start_from(controller.state, controller.forces, controller.position)
    both.hold()  # in which what pushes counts as a grasp
    both.advance()
    controller = both
    force, statuses, conflict = pressed(controller, 0.02)
    assert statuses[-1] is Status.RELAXED
    assert force == pytest.approx(0.06, rel=0.01 if friction else 1e-4)
    assert conflict == ("smallest force of below on table", "largest force of all contacts")


def test_limits_that_locked_actuators_exceed_are_named() -> None:
    """With its only cable locked nothing can be decided; in a hold neither."""
    controller = Controller(pressing_finger(0.0, max_force=0.06))
    pressed(controller, 0.02)
    controller.lock("tendon", position=1.4 * float(controller.position[0]))
    force, statuses, conflict = pressed(controller, 0.02)
    assert force > 0.08
    assert statuses[-1] is Status.RELAXED and conflict == ("largest force of below on table",)
    health = contact_diagnostic(controller)
    assert health.level is Level.WARN and "not kept: largest force of below" in health.message
    held = controller.hold()
    assert held.status is Status.RELAXED and held.conflict == conflict


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_force_out_of_reach_is_named_and_approached(friction: float) -> None:
    """No tension presses so hard: as much as the winch can do is left, and the limit is named."""
    controller = Controller(pressing_finger(friction, min_force=1.2))
    pressed(controller, 0.02, 15)
    force, statuses, conflict = pressed(controller, 0.002, 40)
    assert statuses[-1] is Status.RELAXED
    assert "smallest force of below on table" in conflict
    assert controller.position[0] > 0.9 * controller.robot.limits.position_max[0]
    assert force > 0.5


def test_the_distance_to_slip_is_kept() -> None:
    """A finger that presses lightly is near slipping; with a least distance to it, it presses harder."""
    margins = []
    for least in (0.0, 0.02):
        controller = Controller(pressing_finger(0.5, min_slip_margin=least))
        goal = controller.tip - [0.0, 0.0, 0.004]
        for _ in range(25):
            controller.step(goal)
        found = controller.contacts
        across = found.force - found.normal_force[:, None] * found.contacts.normal
        slip = 0.5 * found.normal_force.sum() - np.linalg.norm(across.sum(axis=0))
        margins.append(float(slip))
    assert margins[0] < 0.005
    assert 0.02 <= margins[1] < 0.021


class TwoColumns:
    """A basis of contact forces with two columns: one half of the candidates each, with unequal weights."""

    def __init__(self, robot: Robot) -> None:
        """For a robot."""
        self.Psi = np.zeros((robot.n_c, 2))
        half = robot.n_c // 2
        self.Psi[:half, 0] = np.linspace(0.2, 0.6, half)
        self.Psi[half:, 1] = np.linspace(0.3, 0.9, robot.n_c - half)

    @property
    def k(self) -> int:
        """Number of columns."""
        return 2

    def reduce(self, contacts: ContactRows) -> ReducedContacts:
        """Rows of both columns."""
        chosen = self.Psi[contacts.slots]
        return ReducedContacts(
            chosen.T @ contacts.rows.dense(), chosen.T @ contacts.rows.delta, np.arange(2)
        )

    def lift(self, beta: Array) -> Array:
        """Forces of all candidates."""
        forces: Array = self.Psi @ beta
        return forces


def test_columns_of_a_basis_count_with_the_forces_that_they_are() -> None:
    robot = pressing_finger(0.0, max_force=0.05)
    space: ContactSpace = TwoColumns(robot)
    force, statuses, _ = pressed(Controller(robot, space), 0.02)
    assert force == pytest.approx(0.05, rel=1e-3) and statuses[-1] is Status.OK


def test_rows_of_the_distance_to_slip_are_safe_within_two_percent() -> None:
    """They never promise more than μ Σ λ_n − |Σ λ_t|, and at most 2 % of the friction less."""
    robot = pressing_finger(0.5, min_slip_margin=0.01)
    controller = Controller(robot)
    pressed(controller, 0.004, 15)
    decision = controller.last_decision
    assert decision is not None and decision.plan is not None
    step, limits = decision.plan.predicted.step, force_limits(robot.contacts, controller.space)
    assert limits is not None
    one, found = limits.limited[0], step.rows.contacts.found
    normal, across = limits.normal_sum(step, one), friction_sums(step, one)
    assert len(across) == DIRECTIONS
    rng = np.random.default_rng(0)
    for _ in range(20):
        r = rng.normal(size=(len(step.extra), 3))
        whole = np.einsum("rt,rti->i", r[:, 1:], found.axes()[step.extra, 1:])
        reached = (across @ r.ravel()).max()
        size = np.linalg.norm(whole)
        assert size <= reached * (1.0 + 1e-12) and reached <= 1.02 * size
        assert normal @ r.ravel() == pytest.approx(r[:, 0].sum())


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"min_force": 2.0, "max_force": 1.0}, "min_force 2 N must be at most max_force 1 N"),
        ({"min_slip_margin": 0.1}, "min_slip_margin needs a friction above 0"),
        ({"max_force": 0.0}, "more than 0"),
        ({"max_force": float("nan")}, "finite"),
        ({"min_force": -1.0}, "greater than or equal to 0"),
        ({"friction": 1e300}, "less than or equal to 100"),
        (
            {"friction": 0.5, "max_force": 1.0, "min_slip_margin": 1.0},
            "needs a normal force of 2 N, and max_force is 1 N",
        ),
        ({"min_force": 1.0, "total": 0.5}, "contact.max_force is 0.5 N, and .* need 1 N"),
        (
            {"min_force": 1.0, "table": 0.5},
            "obstacles.0.max_force is 0.5 N, and .* against table need 1 N",
        ),
        ({"table": 0.0}, "more than 0"),
        (
            {"friction": 0.5, "min_slip_margin": 0.4, "total": 0.5},
            "contact.max_force is 0.5 N, and .* need 0.8 N",
        ),
    ],
)
def test_limits_that_make_no_sense_are_refused(table: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        pressing_finger(**{"friction": 0.0, **table})


@pytest.mark.long
def test_the_largest_force_of_a_part_is_kept_in_a_robot_of_parts(tmp_path: Path) -> None:
    """Of each part its own, beside that of all contacts."""
    whole = (EXAMPLES / "finger_on_plate.toml").read_text()
    finger_file = (shipped_folder() / "finger.toml").read_text()
    shutil.copy(shipped_folder() / "finger.vtu", tmp_path)
    limited = finger_file.replace("[contact]\n", "[contact]\nmax_force = 0.3\n")
    (tmp_path / "thumb.toml").write_text(limited)
    (tmp_path / "hand.toml").write_text(
        whole.replace('robot = "finger"', 'robot = "thumb.toml"').replace(
            'shape = "plane"', 'shape = "plane"\nmax_force = 0.6'
        )
        + "\n[contact]\nmax_force = 0.7\n"
    )
    robot = load_robot(tmp_path / "hand.toml")
    thumb = load_robot(tmp_path / "thumb.toml")
    own = thumb.contacts
    assert [(one.name, one.force) for one in robot.contacts.sums] == [
        ("finger: all contacts", 0.3), ("all contacts on plate", 0.6), ("all contacts", 0.7),
    ]  # fmt: skip
    assert robot.contacts.sums[1].pairs == (len(robot.contacts.pairs) - 1,)
    assert robot.contacts.sums[0].pairs == own.sums[0].pairs
    assert len(robot.contacts.sums[2].pairs) == len(robot.contacts.pairs) == len(own.pairs) + 1
    assert reduced_robot(thumb, StateBasis.load("finger")).contacts.sums == own.sums


def exact_pusher_beside(tmp_path: Path) -> Controller:
    """A robot that pushes a block with limited forces, and beside it one whose tip has exact targets."""
    for name in ("push.toml", "pusher.toml", "pusher.vtu", "block.toml", "block.vtu"):
        shutil.copy(EXAMPLES / name, tmp_path)
    tip = '[[effectors]]\nname = "tip"\npoint = [0.0, 0.0, 0.006]\nexact = true\nweight = [1.0, 0.0, 0.0]\n'
    other = tmp_path / "other.toml"
    other.write_text((EXAMPLES / "pusher.toml").read_text() + tip)
    contents = read_toml(tmp_path / "push.toml")
    contents["parts"].append({"name": "other", "robot": "other.toml", "position": [0.3, 0.3, 0.0]})
    contents["contacts"][0]["max_force"] = 0.015
    return Controller(make_robot(contents, tmp_path / "push.toml", Changes()))


@pytest.mark.long
def test_limits_of_one_robot_relax_nothing_of_another_beside_it(tmp_path: Path) -> None:
    """The plan of the other one had the limits of these contacts, too, which none of its efforts changes."""
    controller = exact_pusher_beside(tmp_path)
    start, statuses, pressed = controller.effector_values, [], False
    for tick in range(14):
        way = np.array([4e-4, 0.0, 0.0]) * min(tick, 10)
        goal = start + np.concatenate([way, way])
        actuation = controller.step(goal)
        statuses.append(actuation.status)
        pressed |= bool(
            controller.contacts.normal_force[controller.contacts.contacts.pair == 0].any()
        )
    assert pressed and not {Status.RELAXED, Status.NOT_EXACT} & set(statuses[2:])  # it sags first
    assert controller.effector_values[3] == pytest.approx(goal[3], abs=5e-5)


def gripper(folder: Path, limits: str) -> Controller:
    """The gripper of `examples/grasp.toml` with one contact for each finger.

    Args:
        folder: for its files.
        limits: lines of both contacts.
    """
    for name in ("cube.vtu", "fork.vtu", "cube.toml"):
        shutil.copy(EXAMPLES / name, folder)
    fork, grasp = ((EXAMPLES / name).read_text() for name in ("fork.toml", "grasp.toml"))
    box = '[[surfaces]]\nname = "{}"\nbox = {{ lower = [-1.0, {}, -1.0], upper = [-0.05, {}, 1.0] }}\n'
    sides = box.format("left", 0.0, 0.0135) + box.format("right", -0.0135, 0.0)
    own = fork[fork.index("[[surfaces]]") : fork.index("[integration]")]
    (folder / "fork.toml").write_text(fork.replace(own, sides))
    inside = grasp[
        grasp.index("[[contacts]]") : grasp.index('[[contacts]]\ncandidates = { part = "cube"')
    ]
    both = "".join(
        inside.replace("inside", side).rstrip() + f"\n{limits}\n\n" for side in ("left", "right")
    )
    (folder / "grasp.toml").write_text(grasp.replace(inside, both))
    return Controller(load_robot(folder / "grasp.toml"))


@pytest.mark.slow
def test_each_side_of_a_grasp_presses_with_half_a_newton(tmp_path: Path) -> None:
    """The finger's target closes, then opens the grasp: both sides keep the smallest force, up in the air."""
    controller = gripper(tmp_path, "min_force = 0.5\nmax_force = 0.8")
    tip = controller.effector_values
    for inwards, steps in ((0.004, 10), (-0.002, 15)):
        goal = tip - np.array([0.0, inwards, 0.0])
        for _ in range(steps):
            assert controller.step(goal).status.usable
            found = controller.contacts
            sides = [found.normal_force[found.contacts.pair == pair].sum() for pair in (0, 1)]
        assert all(0.48 < side < 0.84 for side in sides)


@pytest.mark.long
@pytest.mark.parametrize("parts", [("other",), ("other", "pusher")])
def test_an_exact_target_is_missed_by_name_where_all_that_moves_it_is_locked(
    tmp_path: Path, parts: tuple[str, ...]
) -> None:
    """Also beside a robot that has friction and is decided, and where nothing is decided at all."""
    controller = exact_pusher_beside(tmp_path)
    start = controller.effector_values
    for name in controller.robot.actuators.names:
        if name.startswith(parts):
            controller.lock(name, position=0.0)
    sagged = [controller.step(start).status for _ in range(5)]
    assert sagged[-1] is Status.NOT_EXACT  # by a little
    goal = start + np.array([0.0, 0.0, 0.0, 1e-3, 0.0, 0.0])
    for _ in range(50):  # until it hangs still
        actuation = controller.step(goal)
        assert actuation.status is Status.NOT_EXACT
        assert actuation.conflict == ("x of effector other_tip",)
    goal[3:] = controller.effector_values[3:]
    assert controller.step(goal).status is Status.OK
