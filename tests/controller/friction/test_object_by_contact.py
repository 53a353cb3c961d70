"""A soft pad moves an object to a target through contact alone: only friction acts on it sideways."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from support.robots.bodies import box_mesh
from support.robots.examples import EXAMPLES, example
from support.robots.solids import RIGID_CUBE

from tauten.controller import Controller
from tauten.controller.friction import FrictionInverse, PlanSearch, with_slip
from tauten.controller.friction.problem import cones_at
from tauten.controller.friction.search import effort_search
from tauten.controller.planning import FRICTION_SHARE, Aim, Situation, make_plan
from tauten.controller.qpcc import Budget, Qpcc, Solution, TimeLimit
from tauten.model import load_robot, unit_start
from tauten.model.friction import error_of
from tauten.model.numerics import Array

CUBE = (
    RIGID_CUBE
    + """
[[effectors]]
name = "place"
kind = "centre"
region = { lower = [-1.0, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
weight = [1.0, 1.0, 0.0]
"""
)
PAD = """
name = "pad"
mesh = { file = "pad.vtu" }
material = { young_modulus = 3e4, poisson_ratio = 0.3, density = 1000.0 }
integration = { rayleigh_stiffness = 0.02 }
fixed = [{ lower = [-1.0, -1.0, -1e-6], upper = [1.0, 1.0, 1e-6] }]
[[cables]]
name = "left"
pull_point = [-0.03, 0.03, 0.03]
points = [[0.0, 0.03, 0.03]]
max_tension = 8.0
max_pull = 0.02
max_rate = 0.1
[[cables]]
name = "right"
pull_point = [0.09, 0.03, 0.03]
points = [[0.06, 0.03, 0.03]]
max_tension = 8.0
max_pull = 0.02
max_rate = 0.1
"""
TABLE = """
name = "table"
[[parts]]
name = "pad"
robot = "pad.toml"
[[parts]]
name = "cube"
robot = "cube.toml"
position = [0.02, 0.02, 0.0301]
[[contacts]]
candidates = {{ part = "cube", surface = "below" }}
against = {{ part = "pad" }}
points = "vertices"
friction = {friction}
[controller]
rate = 50.0
"""


def table(folder: Path, friction: float) -> Controller:
    """A cube that lies on a soft pad which cables pull sideways."""
    for name, size, cells in (
        ("cube", (0.02, 0.02, 0.02), (1, 1, 1)),
        ("pad", (0.06, 0.06, 0.03), (4, 4, 3)),
    ):
        mesh = box_mesh(size, cells)
        meshio.write(folder / f"{name}.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    (folder / "cube.toml").write_text(CUBE)
    (folder / "pad.toml").write_text(PAD)
    (folder / "table.toml").write_text(TABLE.format(friction=friction))
    return Controller(load_robot(folder / "table.toml"))


def moved(controller: Controller, way: Array, steps: int) -> Array:
    """How far the cube has gone (3,) after steps towards a target this far away."""
    for _ in range(10):
        controller.hold()
        controller.advance()
    start = controller.effector_values
    for _ in range(steps):
        assert controller.step(start + way).status.usable
    return controller.effector_values - start


@pytest.mark.parametrize("way", [2e-3, pytest.param(-2e-3, marks=pytest.mark.slow)])
def test_friction_carries_a_cube_to_its_target(tmp_path: Path, way: float) -> None:
    controller = table(tmp_path, 0.5)
    gone = moved(controller, np.array([way, 0.0, 0.0]), 30)
    assert gone[0] == pytest.approx(way, abs=2e-4)
    contacts = controller.contacts
    assert contacts.pushing.sum() >= 3
    assert contacts.normal_force.sum() == pytest.approx(2000.0 * 0.02**3 * 9.81, rel=0.02)


@pytest.mark.long
def test_a_cable_carries_it_beside_one_that_is_locked(tmp_path: Path) -> None:
    """A locked cable is a contact of the plan's problem; it keeps its length."""
    controller = table(tmp_path, 0.5)
    controller.lock("pad_left", position=0.0)
    gone = moved(controller, np.array([1e-3, 0.0, 0.0]), 15)
    assert gone[0] == pytest.approx(1e-3, abs=2e-4)
    left, right = controller.position
    assert left == 0.0 and right > 1e-3


@pytest.mark.long
def test_without_friction_nothing_carries_it(tmp_path: Path) -> None:
    gone = moved(table(tmp_path, 0.0), np.array([2e-3, 0.0, 0.0]), 20)
    assert gone[0] < 1e-3


def test_a_plan_is_not_held_back_to_where_an_object_slides(tmp_path: Path) -> None:
    """γ pulls half of the way to the target back: from holding, or from here where holding would lose it."""
    controller = table(tmp_path, 0.5)
    start, way = controller.effector_values, np.array([2e-3, 0.0, 0.0])  # m
    controller.prepare()
    prepared, robot = controller._prepared, controller.robot
    assert prepared is not None
    now, layout = prepared.step.rows.effectors.delta, robot.effector_layout
    aim = Aim(layout.row_targets(start, start + way), layout.scale, layout.exact, np.ones(1), None)
    for slides, back in ((1e-3, 1.5e-3), (-0.4, 1e-3)):
        delta = prepared.held.delta.copy()
        delta[: len(now)], delta[0] = now, now[0] + slides
        held = replace(prepared, held=replace(prepared.held, delta=delta))
        situation = Situation(robot, held, controller.position, controller.settings, None)
        plan = make_plan(situation, aim, ())
        away = plan.predicted.step.compliance.delta_free[:2] - now[:2] - [back, 0.0]
        wanted = 0.5 * np.square(away).sum()  # without the height, which has no weight
        assert plan.problem.constant == pytest.approx(wanted, rel=1e-9)


def test_slip_of_what_carries_an_object_is_weighed(tmp_path: Path) -> None:
    """A tenth of its mean square; none of a contact that pushed in the last step is left out."""
    controller = table(tmp_path, 0.1)
    moved(controller, np.array([2e-3, 0.0, 0.0]), 5)
    found = controller.contacts
    controller.prepare()
    prepared = controller._prepared
    assert prepared is not None
    planned = controller.decide(controller.shifted(1e-2))
    decision = controller.last_decision
    assert planned.status.usable and decision is not None and decision.plan is not None
    plan = decision.plan
    step = plan.predicted.step
    nothing = replace(plan.problem, Q=0.0 * plan.problem.Q, c=0.0 * plan.problem.c, constant=0.0)
    z = plan.predicted.lam[step.layout.n_e :]
    problem = with_slip(nothing, step, prepared.forces, 2.0)
    slip = plan.predicted.delta[step.layout.contacts].reshape(-1, 3)[:, 1:]  # (k, 2) m
    pushed = np.isin(step.extra, found.contacts.slots[found.pushing])
    assert pushed.sum() >= 3
    weighed = 0.5 * 0.1 * 2.0**2 * np.square(slip[pushed]).sum(axis=1).mean()
    value = 0.5 * z @ problem.Q @ z + problem.c @ z + problem.constant
    assert value == pytest.approx(weighed, rel=1e-6) and weighed > 1e-12


def test_contacts_of_an_object_that_no_effort_moves_carry_nothing() -> None:
    """The cube of the lift on its floor, before the fingers touch it."""
    controller = Controller(load_robot(example("12_lift")["FILE"]))
    target = controller.shifted(1e-6)
    controller.step(target)
    assert controller.contacts.pushing.sum() >= 3
    controller.prepare()
    prepared = controller._prepared
    controller.decide(target)
    decision = controller.last_decision
    assert prepared is not None and decision is not None and decision.plan is not None
    problem, step = decision.plan.problem, decision.plan.predicted.step
    assert with_slip(problem, step, prepared.forces, 1.0) is problem


def test_a_search_begins_at_the_forces_of_holding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With all of the friction they are exact. Those of the last tick are forces of another motion."""
    controller = table(tmp_path, 0.1)
    moved(controller, np.array([2e-3, 0.0, 0.0]), 5)
    controller.prepare()
    prepared, solve, asked = controller._prepared, PlanSearch.__call__, []
    assert prepared is not None

    def asks(plan: PlanSearch, program: Qpcc, near: Solution | None) -> Solution:
        asked.append((plan, program))
        return solve(plan, program, near)

    monkeypatch.setattr(PlanSearch, "__call__", asks)
    controller.settings = replace(controller.settings, friction_share=1.0)
    controller.decide(controller.shifted(1e-3))
    plan, program = asked[0]
    search = effort_search(FrictionInverse(program, plan.friction), "daqp", Budget(1, TimeLimit()))
    start = np.zeros((2, len(search.contacts.q)))
    start[0, search.place], start[1, search.place] = (
        plan.forces,
        unit_start(prepared.farther, prepared.forces),
    )
    now, before = (error_of(cones_at(search.contacts, plan.lam), r) for r in start)
    exact = 1e-7 * plan.size
    assert now <= exact < 10.0 * exact < before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "least", "most"), [(FRICTION_SHARE, 7e-4, 9e-4), (1.0, -2e-4, 2e-4)]
)
@pytest.mark.parametrize("way", [3e-3, 9e-3])
def test_a_block_ends_before_its_target_where_friction_that_resists_is_left_out(
    share: float, least: float, most: float, way: float
) -> None:
    """The finger is bent by what it has to push with and the plan leaves out; as docs/grasping.md says."""
    controller = Controller.of(EXAMPLES / "push.toml")
    controller.settings = replace(controller.settings, friction_share=share)
    start = controller.effector_values
    for tick in range(100):
        goal = start + np.array([way, 0.0, 0.0]) * min(tick, 40) / 40
        assert controller.step(goal).status.usable
    assert least < (goal - controller.effector_values)[0] < most  # m
