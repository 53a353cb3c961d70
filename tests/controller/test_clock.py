"""The controller's model keeps time: its motion does not depend on the length of its steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.processes import ROBOT, write_robot
from support.robots.bodies import CABLE, pneumatic_config, pneumatic_robot
from support.robots.examples import shipped_setup
from support.robots.joined import joined

from tauten.controller import Controller, ControllerSettings, substeps_of
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array

FINE = 4  # steps of a simulator in a period
TOOL = """\
[[effectors]]
name = "tool"
kind = "frame"
region = { lower = [0.099, -1.0, -1.0], upper = [1.0, 1.0, 1.0] }
"""


def swing(robot: Robot, settings: ControllerSettings, far: float) -> tuple[Array, Array]:
    """Tips (ticks, 3) of controller and simulator while the first actuator goes there and back in 2 s."""
    controller, simulator = Controller(robot, settings=settings), Simulator(robot, "none")
    controller.settle_start()
    simulator.settle_start()
    found, position = [], np.zeros(robot.n_a)
    for share in 0.5 - 0.5 * np.cos(np.pi * robot.h * np.arange(1, round(2.0 / robot.h) + 1)):
        position[0] = far * share
        for name, at in zip(robot.actuators.names, position, strict=True):
            controller.lock(name, position=at)
        controller.step(controller.effector_values)
        np.testing.assert_allclose(controller.position, position, atol=1e-2 * far)
        simulator.move(position=position, steps=FINE)
        found.append((controller.effector[0], simulator.effector[0]))
    mine, fine = np.moveaxis(np.array(found), 1, 0)
    return mine, fine


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "far"),
    [
        ("finger", 0.015),
        pytest.param("pneumatic_finger", 1.0e-6, marks=pytest.mark.slow),
        pytest.param("trunk", 0.015, marks=pytest.mark.slow),
    ],
)
def test_a_swing_of_two_seconds_does_not_depend_on_the_period_of_control(
    name: str, far: float
) -> None:
    """With one step of implicit Euler a period the finger is off by a third of its way."""
    setup = shipped_setup(name)
    mine, fine = swing(setup.robot, setup.controller, far)
    way = np.linalg.norm(fine - fine[0], axis=1).max()
    assert np.linalg.norm(mine - fine, axis=1).max() < 0.03 * way


@pytest.mark.long
def test_rounding_of_the_targets_does_not_choose_the_scheme_of_a_step(tmp_path: Path) -> None:
    """Cables at rest have tensions of rounding; taken for pushes, they changed tensions by 4e-4 N."""
    text = ROBOT.split("[[effectors]]", maxsplit=1)[0] + TOOL
    robot, noise = str(write_robot(tmp_path, text)), np.random.default_rng(1)

    def efforts(size: float) -> Array:
        controller, found = Controller.of(robot), list[Array]()
        place = controller.effector_values[:3].copy()
        for seconds in 0.02 * np.arange(50):
            turn = np.roll(Rotation.from_rotvec([0.0, -0.05 * seconds, 0.0]).as_quat(), 1)
            goal = np.concatenate([place, turn])
            goal[2] += 1e-3 * seconds
            controller.step(goal + size * noise.standard_normal(len(goal)))
            found.append(controller.effort.copy())
        return np.array(found)

    np.testing.assert_allclose(efforts(1e-13), efforts(0.0), atol=1e-8)


def test_rounding_of_small_changes_does_not_choose_the_damping(tmp_path: Path) -> None:
    """Targets 0.3 nm apart set a damping that rounding changed by 1e-6, and all later plans with it."""
    robot, noise = str(write_robot(tmp_path)), np.random.default_rng(1)

    def efforts(size: float) -> tuple[Array, float]:
        controller, found = Controller.of(robot), list[Array]()
        place = controller.effector_values
        for up in (0.0, 3e-10, 0.0, 3e-10, 1e-3, 1.2e-3, 1.3e-3):  # m
            goal = place.copy()
            goal[2] += up
            controller.step(goal + size * noise.standard_normal(len(goal)))
            found.append(controller.effort.copy())
        return np.array(found), controller._carried.dampings.each[0].gamma

    (exact, gamma), (rounded, _) = efforts(0.0), efforts(1e-15)
    assert gamma > 0.1, "what went to and fro is damped"
    np.testing.assert_allclose(rounded, exact, atol=1e-8)


@pytest.mark.long
def test_a_swing_beyond_the_winchs_rate_gains_no_energy() -> None:
    """A cable that becomes taut in the middle of a step stops the finger; it must not throw it back.

    Where the second stage extrapolated the impulse of the first, the model left the path of shorter steps by
    a fifth of its size and had a hundred times the energy of the finger at the farthest pull.
    """
    setup = shipped_setup("finger")
    robot, controller = setup.robot, Controller(setup.robot, settings=setup.controller)
    simulator = Simulator(robot, "none")
    controller.settle_start()
    simulator.settle_start()
    rest, way = controller.effector_values, 0.15 * robot.size * np.array([1.0, 0.6, 0.3])
    simulator.settle(position=np.array([8e-3]))  # farther than any pull below
    most = robot.energy(simulator.state)
    simulator.settle_start()
    for k in range(50):  # a period
        controller.step(rest + way * np.sin(2.0 * np.pi * robot.h * k))
        assert controller.position[0] < 8e-3
        simulator.move(position=controller.position, steps=16)
        distance = np.linalg.norm(controller.effector[0] - simulator.effector[0])
        assert distance < 0.005 * robot.size
        assert robot.energy(controller.state) < most


@pytest.mark.parametrize(
    ("integration", "expected"),
    [
        ({}, 0),
        ({"rayleigh_stiffness": 0.02}, 1),
        ({"rayleigh_stiffness": 1e-4}, 0),
        ({"rayleigh_mass": 100.0}, 1),
        ({"rayleigh_mass": 1.0}, 0),
        ({"scheme": "quasi-static"}, 0),
    ],
)
def test_robots_with_little_damping_take_the_steps_of_decisions(
    integration: dict[str, object], expected: int
) -> None:
    """Nothing else stops what rings; the steps of second order do not."""
    robot = pneumatic_robot(integration=integration)
    assert substeps_of(robot, ControllerSettings()) == expected
    static = integration.get("scheme") == "quasi-static"
    assert substeps_of(robot, ControllerSettings(substeps=2)) == (0 if static else 2)


def test_a_robot_without_damping_comes_to_rest() -> None:
    controller = Controller(pneumatic_robot())
    goal = controller.effector[0] + np.array([0.0, 0.0, -1e-3])
    fastest = 0.0
    for _ in range(40):
        controller.step(goal)
        fastest = max(fastest, float(np.abs(controller.state.v).max()))
    assert np.abs(controller.state.v).max() < 1e-3 * fastest


def swinging() -> Robot:
    """A soft bar, and a rigid link as heavy as the bar that hangs from its end on a hinge; no damping."""
    bar, down = (0.1, 0.02, 0.02), {"axis": [0.0, 1.0, 0.0], "angle_deg": 90.0}
    end = {"body": "soft", "lower": [0.082, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]}
    hinge = {
        "kind": "hinge", "region": {"kind": "all", "body": "link"}, "to": end,
        "axis": [0.0, 1.0, 0.0], "through": [0.1, 0.01, 0.0], "max_distance": 0.02,
    }  # fmt: skip
    tendons = [
        {**CABLE, "name": name, "points": [[0.01, 0.01, z], [0.095, 0.01, z]], "max_rate": 0.05}
        for name, z in (("lower", 0.002), ("upper", 0.018))
    ]
    return joined(
        [
            {"name": "soft", "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.02]}]},
            {"name": "link", "rigid": True, "position": [0.09, 0.0, 0.0], "rotation": down},
        ],
        {"soft": (bar, (6, 2, 2)), "link": (bar, (2, 1, 1))},
        gravity=[0.0, 0.0, -9.81],
        rigid=[{"name": "end", "region": end}],
        attachments=[hinge],
        cables=tendons,
        effectors=[{"name": "tip", "point": [0.1, 0.01, 0.01], "weight": [0.0, 0.0, 1.0]}],
        integration={"scheme": "implicit-euler"},
        controller={"rate": 50.0},
    )


@pytest.mark.long
def test_steps_of_decisions_give_no_energy_to_a_link_that_swings() -> None:
    """One linearisation a step stretched what keeps the hinge's axis: 0.6 J within 3 s, and then no number.

    The link moves by the little that the tip does: it is never as fast as it would be after a fall from the
    height of its hinge.
    """
    controller = Controller(swinging())
    assert controller.settings.substeps == 0
    assert controller.settle_start().converged
    start, fall = controller.effector[0], 1000.0 * 0.1 * 0.02**2 * 9.81 * 0.05  # J
    for tick in range(150):
        up = 0.006 if tick % 100 < 50 else -0.006
        assert controller.step(start + np.array([0.0, 0.0, up])).status.usable
        assert controller.robot.body.kinetic_energy(controller.state) < fall


def test_viscous_materials_count_as_damping() -> None:
    viscous = {**pneumatic_config()["material"], "viscosity": {"shear_viscosity": 300.0}}
    assert substeps_of(pneumatic_robot(material=viscous), ControllerSettings()) == 1
