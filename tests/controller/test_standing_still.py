"""A constant target gives a robot that stands still, at the place that descent on equilibria finds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar
from support.robots.beam_robots import tendon_arm
from support.robots.bodies import beam_robot, box_mesh, hollow_beam, pneumatic_robot
from support.robots.examples import shipped_setup

from benchmarks.control.still import random_goals
from tauten.controller import Controller, Status
from tauten.controller.damping import TICK, Damping, Objective, adapted, undamped
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.service.setup import load_setup

OFFSET = np.array([0.03, 0.0, 0.0])  # m, out of reach


@pytest.fixture(scope="module")
def finger() -> Robot:
    """The model that the shipped finger is served with."""
    return shipped_setup("finger").robot


def at_rest(robot: Robot, offset: Array, ticks: int = 150) -> tuple[Controller, Array, Array]:
    """A controller after a constant target, and the positions and efforts of its last 40 ticks."""
    controller = Controller(robot)
    assert controller.settle_start().converged
    goal = controller.effector + offset
    positions, efforts = [], []
    for _ in range(ticks):
        actuation = controller.step(goal)
        assert actuation.status is Status.OK
        positions.append(actuation.position)
        efforts.append(actuation.effort)
    return controller, np.array(positions[-40:]), np.array(efforts[-40:])


def test_a_target_out_of_reach_does_not_make_the_finger_tremble(finger: Robot) -> None:
    controller, positions, efforts = at_rest(finger, OFFSET)
    limits = finger.limits
    assert (np.ptp(positions, axis=0) < 1e-6 * (limits.position_max - limits.position_min)).all()
    assert (np.ptp(efforts, axis=0) < 1e-6 * limits.largest_effort).all()
    start = Simulator(finger, "none")
    start.settle_start()
    goal = start.effector + OFFSET

    def distance(position: float) -> float:
        simulator = Simulator(finger, "none")
        assert simulator.settle(position=[position]).converged
        return float(np.linalg.norm(simulator.effector - goal))

    best = minimize_scalar(distance, bounds=(0.0, 0.025), method="bounded", options={"xatol": 1e-6})
    assert np.linalg.norm(controller.effector - goal) == pytest.approx(best.fun, rel=1e-3)


@pytest.mark.long
def test_a_force_on_the_tip_of_a_lightly_damped_robot_comes_to_rest() -> None:
    """Within a tick only inertia resists: a force that goes to its position in each would swing."""
    size = (0.1, 0.02, 0.02)
    force = {
        "name": "push", "point": [0.1, 0.01, 0.01], "direction": [0.0, 0.0, 1.0], "max_force": 0.3,
        "max_travel": 0.05, "max_rate": 0.2,
    }  # fmt: skip
    robot = beam_robot(
        box_mesh(size, (8, 2, 2)), size, cables=[], forces=[force],
        material={"young_modulus": 3e5, "poisson_ratio": 0.4, "density": 1100.0},
        integration={"rayleigh_stiffness": 0.002, "rayleigh_mass": 0.5}, controller={"rate": 50.0},
    )  # fmt: skip
    _, positions, efforts = at_rest(robot, np.array([0.0, 0.0, 0.005]), ticks=240)
    assert np.ptp(positions) < 1e-4 * 0.05
    assert np.ptp(efforts) < 1e-3 * 0.3
    simulator = Simulator(robot, "none")
    assert simulator.settle(effort=efforts[-1]).converged
    assert simulator.position == pytest.approx(positions[-1], rel=2e-3)


@pytest.mark.long
@pytest.mark.parametrize("damping", ["rayleigh_stiffness = 0.002", "rayleigh_mass = 5.0"])
def test_an_arm_with_light_damping_comes_to_rest_at_the_best_place(
    damping: str, tmp_path: Path
) -> None:
    """Decisions kept its vibrations swinging by 100 mm, 0.37 mm from the target at best, with status OK."""
    file = tendon_arm(tmp_path, 12.0)
    text = file.read_text(encoding="utf-8")
    file.write_text(f"{text}[integration]\n{damping}\n", encoding="utf-8")
    controller, goal = Controller.of(str(file)), np.array([0.05, -0.02, 0.3955])
    tips = []
    for _ in range(120):
        assert controller.step(goal).status is Status.OK
        tips.append(controller.tip)
    assert np.ptp(tips[-40:], axis=0).max() < 1e-6
    limits = controller.robot.limits

    def distance(position: Array) -> float:
        simulator = Simulator(controller.robot, "none")
        inside = np.clip(position, limits.position_min, limits.position_max)
        assert simulator.settle(position=inside).converged
        excess = np.maximum(simulator.effort - limits.effort_max, 0.0).max()
        return float(np.linalg.norm(simulator.tip - goal) + excess)

    options = {"maxfev": 100, "xatol": 1e-6, "fatol": 1e-8}
    best = minimize(distance, controller.position, method="Nelder-Mead", options=options)
    assert np.linalg.norm(tips[-1] - goal) == pytest.approx(best.fun, rel=5e-3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "most", "ticks"),
    [
        pytest.param("finger", 0.15, 100, marks=pytest.mark.slow),
        *[("trunk", 0.15, 40), ("diamond", 0.15, 40), ("tripod", 0.15, 40)],
        ("pneumatic_finger", 0.8, 130),
    ],
)
def test_a_target_in_reach_is_reached(name: str, most: float, ticks: int) -> None:
    """The energy of the actuators selects among equally good efforts, and does not hold the robot back.

    On a long way the pneumatic finger's momentum decreases the objective. Where that was not counted for
    the plans that had given the momentum, ways became zero in the middle.
    """
    setup = shipped_setup(name)
    robot, held = setup.robot, setup.robot.actuators.laws.held_by_force
    simulator = Simulator(robot, "none")
    simulator.settle_start()
    share = most * np.linspace(1.0, 0.2, robot.n_a)
    position = np.where(held, np.nan, share * robot.limits.farthest_position)
    effort = np.where(held, share * robot.limits.effort_max, np.nan)
    assert simulator.settle(position, effort).converged
    controller = Controller(robot, settings=setup.controller)
    assert controller.settle_start().converged
    goal = simulator.effector_values
    away = robot.effector_layout.error(goal, controller.effector_values)
    assert away > 5e-4
    for _ in range(ticks):
        controller.step(goal)
    left = robot.effector_layout.error(controller.effector_values, goal)
    assert left < 1e-5 * away + 1e-6 * robot.size


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "offset"),
    [("finger", 0.05), ("trunk", 0.1), ("trunk", 0.15), ("diamond", 0.04), ("gripper", 0.03)],
)
def test_robots_stand_still_far_out_of_reach(name: str, offset: float) -> None:
    robot = shipped_setup(name).robot
    far = offset * np.array([1.0, 0.0, 0.0])
    _, positions, efforts = at_rest(robot, far, 250)
    limits = robot.limits
    assert (np.ptp(positions, axis=0) < 1e-6 * (limits.position_max - limits.position_min)).all()
    assert (np.ptp(efforts, axis=0) < 1e-6 * limits.largest_effort).all()


def test_damping_grows_where_changes_reverse_and_decreases_where_they_repeat() -> None:
    step, still = np.array([1e-3, 0.0, 0.0]), Objective(0.0, 0.0, 0.0, 0.0, 1.0)
    grown = adapted(replace(undamped(), change=step), -step, 0.1, TICK, still)
    assert grown.gamma == pytest.approx(1.0)
    damping = replace(undamped(), gamma=4.0, change=step)
    assert adapted(damping, 0.4 * step, 0.1, TICK, still).gamma == 4.0
    for _ in range(20):
        damping = adapted(damping, step, 0.1, TICK, still)
    assert damping.gamma == 0.0
    damping = replace(undamped(), gamma=2.0, change=1e-12 * step)
    assert adapted(damping, -step, 0.1, TICK, still).gamma == 2.0  # rounding
    assert undamped().gamma == 0.0


def test_ways_become_shorter_where_nothing_is_gained_until_something_is() -> None:
    """The objective of holding goes to and fro, as if plans jumped between two pieces."""
    change = np.array([1e-3])

    def after(damping: Damping, objectives: list[float], gain: float = 1e-6) -> Damping:
        for holding in objectives:
            damping = adapted(
                damping,
                change,
                0.1,
                TICK,
                Objective(holding, holding, holding, holding - gain, damping.share),
            )
        return damping

    damping = after(undamped(), [2e-4, 2.01e-4] * 8)
    assert damping.share < 0.1
    assert damping.starting().share == 1.0
    falling = [2e-4 - 1e-6 * k for k in range(60)]  # decreases by more than what is predicted
    assert after(damping, falling).share > 2.0 * damping.share
    small = after(damping, [2e-4, 2.01e-4] * 20)
    assert small.share < 1e-3
    once = after(after(small, [2e-4], gain=1e-5), [2e-4])
    assert once.share < 1e-3, "a plan of another piece promises more in one tick"
    again = after(small, [2e-4] * 2, gain=1e-5)
    assert again.share == again.most >= 0.1, "an obstacle has gone: much can be gained"
    damping = undamped()
    for k in range(10):  # as predicted
        held = 1e-4 * 0.5**k
        damping = adapted(damping, change, 0.1, TICK, Objective(held, held, held, 0.0, 0.5))
    assert damping.share == 1.0


def test_ways_that_have_shrunk_grow_again_where_they_gain_what_is_predicted() -> None:
    """What was predicted of longer ways was remembered longer than ways shrink: they became zero for ever."""
    damping, held = undamped(), 1e-4
    shares = list[float]()
    for tick in range(120):
        gain = 0.5 * held
        planned = Objective(held, held, held, held - gain, damping.share)
        damping = adapted(damping, np.array([1e-3]), 0.1, TICK, planned)
        if tick >= 20:  # nothing is gained before
            held -= damping.share * gain
        shares.append(damping.share)
    assert shares[20] < 1e-3
    assert shares[-1] >= 0.1


def test_what_relaxing_adds_to_the_objective_does_not_shorten_ways() -> None:
    """An arm with ribs in contact relaxed for two seconds: ways became zero 1.6 mm beside its target."""
    damping, held, gain = undamped(), 1e-4, 1e-6
    for _ in range(40):
        relaxed = held + 2.0 * gain
        planned = Objective(held, relaxed, held, held - gain, damping.share)
        damping = adapted(damping, np.array([1e-3]), 0.1, TICK, planned)
        held = relaxed - damping.share * gain
    assert damping.share == 1.0
    for _ in range(40):  # the same without relaxing
        planned = Objective(held, held, held, held - gain, damping.share)
        damping = adapted(damping, np.array([1e-3]), 0.1, TICK, planned)
        held += (2.0 - damping.share) * gain
    assert damping.share < 1e-3


def test_a_robot_that_goes_to_and_fro_by_itself_gains_nothing() -> None:
    """Holding leads back and forth, as each tick predicts: two fingers of a gripper trembled by 0.1 µm."""
    damping, gain = undamped(), 1e-6
    for tick in range(60):
        held, other = (1e-4, 1e-4 + gain) if tick % 2 else (1e-4 + gain, 1e-4)
        planned = Objective(held, other, held, held - gain, damping.share)
        damping = adapted(damping, np.array([1e-3]), 0.1, TICK, planned)
    assert damping.share < 1e-2


@pytest.mark.long
def test_a_bar_that_swings_is_pulled_on_at_1_khz() -> None:
    """Without damping it swings for seconds; its cable stopped for good 0.3 mm before its place."""
    size = (0.08, 0.01, 0.01)
    cable = {
        "name": "cable", "pull_point": [-0.01, 0.005, 0.009],
        "points": [[0.078, 0.005, 0.009], [0.04, 0.005, 0.009]],
        "max_pull": 0.01, "max_tension": 5.0, "max_rate": 0.05,
    }  # fmt: skip
    bar = beam_robot(
        box_mesh(size, (8, 2, 2)), size, cables=[cable], gravity=[0.0, 0.0, -9.81],
        material={"young_modulus": 1e5, "poisson_ratio": 0.45, "density": 1100.0},
        controller={"rate": 1000.0},
    )  # fmt: skip
    simulator, controller = Simulator(bar), Controller(bar)
    assert controller.settle_start().converged
    simulator.settle_start()
    assert simulator.settle(position=[5e-3]).converged
    pulls = [controller.step(simulator.effector).position[0] for _ in range(400)]
    assert np.mean(pulls[250:]) == pytest.approx(5e-3, abs=1.5e-4)
    assert np.ptp(pulls[250:]) > 1e-5


def test_ways_fade_where_plans_change_nothing_that_counts() -> None:
    """Redundant cables would share their forces anew for minutes after the effectors have stopped."""
    damping, held, small = undamped(), 1e-10, np.array([2e-7])
    for _ in range(100):
        planned = Objective(held, held, held, held - 1e-15, damping.share)
        damping = adapted(damping.fading(small, 0.1, TICK), small, 0.1, TICK, planned)
        held -= damping.share * damping.faded * 1e-15
    assert damping.faded < 1e-4
    assert damping.share == 1.0
    assert damping.fading(10.0 * small, 0.1, TICK).faded == 1.0, (
        "more is to be changed again, at once"
    )


@pytest.mark.parametrize("factor", [2.2, 3.0, 8.0])
def test_ways_do_not_grow_again_to_where_nothing_was_gained(factor: float) -> None:
    """One way moves by a multiple of what plans predict, the other one converges slowly as predicted."""
    size, change = 0.1, np.array([1e-3])
    factors, left = np.array([factor, 0.03]), np.array([1e-3, 1e-3])
    damping, found = undamped(), list[float]()
    for _ in range(400):
        held, planned = float(left @ left), (0.97 * left[1]) ** 2
        predicted = Objective(held, held, held, planned, damping.share)
        damping = adapted(damping, change, size, TICK, predicted)
        left = left - damping.share * factors * left
        found.append(abs(left[0]))
    assert max(found[200:]) < 1e-10  # m; it was excited again and again
    assert left[1] < 2e-4
    assert 0.1 <= damping.most < 2.0 / factor
    assert damping.starting().most == 1.0, "another target"


@pytest.mark.long
def test_plans_that_jump_between_taut_and_slack_cables_end_in_between() -> None:
    """Commands went to and fro by 1.2 mm and tensions by 9.6 N in every tick, for ever."""
    robot = shipped_setup("trunk").robot
    controller = Controller(robot, "none")
    assert controller.settle_start().converged
    goal = np.array([-0.03258, 0.096324, -0.116247])  # m, out of reach
    left = [controller.step(goal) for _ in range(200)][-40:]
    assert all(one.status is Status.OK for one in left)
    moved = np.ptp([one.position for one in left], axis=0)
    assert (moved < 1e-4 * (robot.limits.position_max - robot.limits.position_min)).all()
    assert (np.ptp([one.effort for one in left], axis=0) < 0.05).all()  # N


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["quasi-static", "implicit-euler"])
def test_a_cable_that_plans_let_go_in_turn_is_let_go_by_a_share_of_the_way(scheme: str) -> None:
    """Of two plans one pulls it and one lets it go: pulled by a share and let go at once it was never taut.

    The robot then stayed where the rows were 2.9 mm from their targets, 2.4 mm with dynamics.
    """
    limits = {"max_tension": 6.0, "min_pull": -0.05, "max_pull": 0.02, "max_rate": 10.0}
    places = {
        "low": (0.01, 0.002),
        "springy": (0.019, 0.018),
        "rod": (0.002, 0.018),
        "right": (0.019, 0.005),
    }
    own = {
        "springy": {"spring": {"stiffness": 300.0, "pretension": 0.5}},
        "rod": {"min_tension": -4.0},
    }
    cables = [
        {"name": name, "points": [[0.01, y, z], [0.1, y, z]], **limits, **own.get(name, {})}
        for name, (y, z) in places.items()
    ]
    upper = [[x, 0.01, 0.02] for x in (0.0, 0.05, 0.1)]
    effectors = [
        {"name": "upper", "kind": "length", "points": upper},
        {"name": "lower", "kind": "distance", "point": [0.0, 0.01, 0.0], "other": [0.1, 0.01, 0.0]},
    ]
    motion = {"scheme": scheme} | ({} if scheme == "quasi-static" else {"rayleigh_stiffness": 0.02})
    robot = pneumatic_robot(
        hollow_beam((8, 4, 4)), cables=cables, chambers=[], effectors=effectors, integration=motion
    )
    goal = np.array([0.09768881, 0.09954459])
    known = Simulator(robot, "none")  # a place within the limits that SciPy has found
    given = [0.002, np.nan, np.nan, np.nan], [np.nan, 1.133662, 1.062818, 0.0]
    assert known.settle(*given).converged
    controller = Controller(robot)
    controller.lock("low", position=0.002)
    for _ in range(100):
        assert controller.step(goal).status is Status.OK
    best = np.linalg.norm(known.effector_values - goal)
    assert np.linalg.norm(controller.effector_values - goal) < 1.02 * best


def test_ways_become_short_where_a_robot_swings_for_ever() -> None:
    """Each plan was better than to hold, since it resisted the swing that the ones before had begun."""
    damping, swing = undamped(), [5e-3 * (1.0 + 0.3 * np.sin(0.15 * k)) for k in range(1001)]
    for k in range(1000):
        relaxed = swing[k + 1] + 5e-4  # a hold for the tick would have led to more
        planned = Objective(swing[k], relaxed, swing[k], swing[k] - 5e-4, damping.share)
        damping = adapted(damping, np.array([1e-3]), 0.1, TICK, planned)
    assert damping.share == pytest.approx(0.03)


def test_the_longest_way_becomes_shorter_each_time_that_it_is_too_long() -> None:
    """Ways of a tenth that were too long for the trunk at its limits made it tremble for ever by 4 um."""
    damping, held, most = undamped(), 1e-4, list[float]()
    for _ in range(400):
        change = (0.5e-6 if damping.share > 0.02 else -1e-6) * damping.share
        planned = Objective(held, held, held, held - 1e-6, damping.share)
        damping = adapted(damping, np.array([1e-3]), 0.1, TICK, planned)
        held += change
        most.append(damping.most)
    assert most[40] > 0.05
    assert damping.most < 0.02


@pytest.mark.slow
@pytest.mark.parametrize(("number", "contact", "ticks"), [(8, True, 1000), (10, False, 600)])
def test_the_manipulator_comes_to_rest_out_of_reach(number: int, contact: bool, ticks: int) -> None:
    """It swung by 60 mm for ever where ribs press on vertebrae, and by 1.5 mm at its limits."""
    setup = load_setup("manipulator", model="reduced")
    goals = random_goals(setup.robot, np.random.default_rng(0), number + 1)
    *_, goal = goals
    space = setup.contact if contact else "none"
    controller = Controller(setup.robot, space, settings=setup.controller)
    controller.settle_start()
    tips = []
    for _ in range(ticks):
        assert controller.step(goal).status.usable
        tips.append(controller.effector_values)
    assert (np.ptp(tips[-100:], axis=0) < 1e-3 * setup.robot.size).all()
