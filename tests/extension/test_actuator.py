"""The actuator of docs/extend.md: a muscle that another package has, on every kind of body."""

from __future__ import annotations

import copy
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from support.processes import ROBOT, run_main, write_robot
from support.robots.combinations import add, robot_with, write_networks
from support.robots.my_package import tables
from support.robots.small_bodies import small_body
from support.state_bases import basis_of, turned_space

from tauten.controller import Controller
from tauten.model import (
    ActuatorKind,
    ExtensionError,
    Robot,
    RobotFileError,
    Simulator,
    State,
    skin_of,
)
from tauten.model.actuators import Transmitted, second_derivative
from tauten.model.numerics import Array
from tauten.reduction.state import reduced_robot, reducible
from tauten.service.describing import describe
from tauten.service.frames import RobotLook
from tauten.service.plant import own_steps
from tauten.service.plant.drives import ALLOWED
from tauten.service.setup import load_setup
from tauten.service.view import open_server
from tauten.service.view.picture.actuators import TIGHT, drawings_of
from tauten.service.view.picture.legend import legend_html
from tauten.service.wire import RobotDescription

MUSCLE: dict[str, Any] = next(
    found["transmissions"][0] for found in tables() if "transmissions" in found
)
LENGTH, FIBRE, TURNS = 0.1, 0.12, 1.5
LINE = [[0.0, 0.01, 0.018], [LENGTH, 0.01, 0.018]]
RIGHT = {**MUSCLE, "points": LINE, "max_position": 2e-5}
BODIES = [
    [], [("element", "smoothed")], [("element", "quadratic"), ("law", "neo-hookean")],
    [("map", "rigid region")], [("map", "rotating drive")], [("map", "pin")], [("map", "glue")],
    [("body", "rigid body"), ("map", "pin")], [("body", "beam body")], [("map", "pin of a beam")],
    [("body", "network of beams")], [("body", "network with a loop")],
    [("reduction", "state basis")],
    [("map", "rigid region"), ("reduction", "state basis")],
    [("map", "rotating drive"), ("reduction", "state basis")],
    [("body", "network of beams"), ("reduction", "state basis")],
]  # fmt: skip


def muscle(**changes: object) -> dict[str, Any]:
    """The table of a muscle along the upper side of a beam."""
    return {**copy.deepcopy(RIGHT), **changes}


def test_the_derivatives_of_the_muscle_are_those_of_its_volume(package: ModuleType) -> None:
    rng, one = np.random.default_rng(0), package.McKibben(np.array(LINE), FIBRE, TURNS)
    y, d = np.array(LINE) + 5e-3 * rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
    at = one.at(y)
    up, down = (one.at(y + by * d) for by in (1e-6, -1e-6))
    assert np.vdot(at.gradient, d) == pytest.approx((up.value - down.value) / 2e-6, rel=1e-7)
    bent = (up.gradient - down.gradient).ravel() / 2e-6
    np.testing.assert_allclose(at.curvature @ d.ravel(), bent, rtol=1e-6)


@pytest.mark.parametrize("options", BODIES, ids=lambda found: ", ".join(name for _, name in found))
def test_rows_and_tangent_are_derivatives_on_every_body(
    package: ModuleType, tmp_path: Path, options: list[tuple[str, str]]
) -> None:
    """Along random directions, away from rest: of δ, and of the force of the muscle."""
    write_networks(tmp_path)
    table = muscle(max_outside=0.05)
    robot = robot_with([*options, ("row", "cable")], tmp_path, add("transmissions", **table))
    rng, rest = np.random.default_rng(1), robot.rest()

    def moved(state: State, dq: Array) -> State:
        return robot.advance(state, dq, 1.0)

    def direction(state: State) -> Array:
        dq = rng.normal(size=robot.n)
        found: Array = dq * 2e-3 / robot.displacement(state, dq)
        return found

    state = moved(rest, direction(rest))
    lam, motor = np.zeros(robot.n_a), robot.actuators.names.index("muscle")
    lam[motor] = 2e5
    assert robot.actuators.kinds[motor] is ActuatorKind.FLUID_TRANSMISSION
    matrix = robot.body.matrix
    K = matrix(robot.forces(state, lam, exact=True)[1]) - matrix(
        robot.forces(state, 0.0 * lam, exact=True)[1]
    )
    H = robot.rows(state, contacts=False).actuators.dense()
    assert robot.rows(rest, contacts=False).actuators.delta[motor] == pytest.approx(0.0, abs=1e-15)
    for _ in range(3):
        d, step = direction(state), 1e-3
        ends = [robot.rows(moved(state, by * d), contacts=False).actuators for by in (step, -step)]
        slope = (ends[0].delta[motor] - ends[1].delta[motor]) / (2.0 * step)
        assert H[motor] @ d == pytest.approx(slope, rel=1e-4)
        change = d @ (ends[0].dense()[motor] - ends[1].dense()[motor]) / (2.0 * step)
        assert d @ (K @ d) == pytest.approx(-lam[motor] * change, rel=1e-4)


def test_the_muscle_pulls_as_a_cable_with_its_force_does(package: ModuleType) -> None:
    """Chou and Hannaford: a pressure p pulls with p (3 L² − b²) / 4 π n²; a cable with this tension does
    the same to the robot, and the muscle's work is p dV."""
    pressure = 5e4
    cable = {"name": "cable", "points": LINE, "max_tension": 1e3, "max_pull": 0.05, "max_rate": 1.0}
    muscled = Simulator(small_body("linear", cables=[], transmissions=[muscle()]), "none")
    assert muscled.settle(effort=[pressure], tolerance=1e-12).converged
    length = np.linalg.norm(tip_of(muscled) - LINE[0])
    assert 0.05 < 1.0 - length / LENGTH < 0.3, "it contracts, and bends the beam"
    tension = pressure * (3.0 * length**2 - FIBRE**2) / (4.0 * np.pi * TURNS**2)
    pulled = Simulator(small_body("linear", cables=[cable]), "none")
    assert pulled.settle(effort=[tension], tolerance=1e-12).converged
    np.testing.assert_allclose(pulled.effector, muscled.effector, atol=1e-9)
    volume = [x * (FIBRE**2 - x**2) / (4.0 * np.pi * TURNS**2) for x in (length, LENGTH)]
    delta = muscled.robot.rows(muscled.state, contacts=False).actuators.delta[0]
    assert delta == pytest.approx(volume[0] - volume[1], rel=1e-9)


@pytest.mark.long
def test_the_trial_of_a_plant_ends_where_it_can_pull_no_further(package: ModuleType) -> None:
    """Its volume is largest at a length of b / √3; half of `max_position` is beyond that."""
    beyond = muscle(max_position=2e-5, max_rate=2e-4)
    simulator = Simulator(small_body("linear", cables=[], transmissions=[beyond]), "none")
    assert own_steps(simulator).error < ALLOWED


def test_its_work_is_the_energy_that_is_stored(package: ModuleType) -> None:
    """Of slow filling: the integral of the pressure over the volume, and what the beam has then."""
    simulator = Simulator(small_body("linear", cables=[], transmissions=[muscle()]), "none")
    pressures, volumes = np.linspace(0.0, 4e4, 21), []
    for pressure in pressures:
        assert simulator.settle(effort=[pressure], tolerance=1e-12).converged
        volumes.append(simulator.robot.rows(simulator.state, contacts=False).actuators.delta[0])
    work = float(np.trapezoid(pressures, volumes))
    assert simulator.robot.potential(simulator.state) == pytest.approx(work, rel=2e-3)


def tip_of(simulator: Simulator) -> Array:
    """Where the muscle ends on the body (3,) [m]."""
    found: Array = simulator.robot.actuator_segments(simulator.state)[-1, 1]
    return found


def test_reduced_and_full_agree_and_a_given_volume_is_met(package: ModuleType) -> None:
    """In a basis of all of space, and the volume that a pressure gives takes this pressure."""
    robot = small_body("linear", cables=[], transmissions=[muscle()])
    Phi, every = turned_space(robot), np.arange(reducible(robot).n_elements)
    reduced = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    full, small = Simulator(robot, "none"), Simulator(reduced, "none")
    for one in (full, small):
        assert one.settle(effort=[4e4], tolerance=1e-12).converged
    np.testing.assert_allclose(small.effector, full.effector, atol=1e-9)
    volume = robot.rows(full.state, contacts=False).actuators.delta
    for one in (Simulator(robot, "none"), Simulator(reduced, "none")):
        assert one.settle(position=volume, tolerance=1e-12).converged
        assert one.effort[0] == pytest.approx(4e4, rel=1e-6)


def test_without_its_curvature_equilibria_are_the_same_and_take_longer(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = Simulator(small_body("linear", cables=[], transmissions=[muscle()]), "none")
    exact = usual.settle(effort=[5e3], tolerance=1e-12)
    at = package.McKibben.at

    def without(self: Any, y: Array) -> Transmitted:
        found = at(self, y)
        return Transmitted(found.value, found.gradient)

    monkeypatch.setattr(package.McKibben, "at", without)
    rough = Simulator(small_body("linear", cables=[], transmissions=[muscle()]), "none")
    report = rough.settle(effort=[5e3], tolerance=1e-12)
    assert exact.converged and report.converged
    assert exact.iterations < report.iterations
    np.testing.assert_allclose(rough.effector, usual.effector, atol=1e-9)


def test_its_curvature_may_be_that_of_differences(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They have six digits at least, and equilibria are found in as many iterations."""
    usual = Simulator(small_body("linear", cables=[], transmissions=[muscle()]), "none")
    exact = usual.settle(effort=[4e4], tolerance=1e-12)
    at = package.McKibben.at

    def differences(self: Any, y: Array) -> Transmitted:
        found = at(self, y)
        bend = second_derivative(lambda moved: at(self, moved).gradient, y)
        np.testing.assert_allclose(bend, found.curvature, atol=1e-6 * abs(found.curvature).max())
        return Transmitted(found.value, found.gradient, bend)

    monkeypatch.setattr(package.McKibben, "at", differences)
    other = Simulator(small_body("linear", cables=[], transmissions=[muscle()]), "none")
    report = other.settle(effort=[4e4], tolerance=1e-12)
    assert report.converged
    assert report.iterations == exact.iterations
    np.testing.assert_allclose(other.effector, usual.effector, atol=1e-12)


@pytest.mark.long
def test_muscles_follow_targets_through_one_valve(package: ModuleType) -> None:
    """Two against each other with a common pressure at rest: the beam bends both ways, within its limits."""
    low = [[x, y, 0.002] for x, y, _ in LINE]
    pair = [muscle(name="upper"), muscle(name="lower", points=low)]
    valve = {
        "name": "valve", "members": ["upper", "lower"], "gains": [1.0, -1.0],
        "pretensions": [1e4, 1e4], "max_position": 1e-4, "max_effort": 1e4, "max_rate": 1e-2,
    }  # fmt: skip
    robot = small_body("linear", cables=[], transmissions=pair, couplings=[valve])
    assert robot.n_a == 1
    controller = Controller(robot)
    for _ in range(40):  # what the pretensions bend
        controller.step(controller.effector_values)
    rest = controller.effector_values
    for up in (3e-3, -3e-3):
        goal = rest + np.array([0.0, 0.0, up])
        for _ in range(80):
            assert controller.step(goal).status.usable
        assert abs(controller.effector_values - goal)[2] < 0.1 * abs(up)
        assert np.sign(controller.effort[0]) == np.sign(up)
        assert abs(controller.effort[0]) <= 1e4


def test_its_region_is_its_points(package: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of another function of the package: how far a face moves along x on average, a push of its nodes."""

    class Mean:
        def __init__(self, rest: Array) -> None:
            self.shares = np.full((len(rest), 1), 1.0 / len(rest)) * [1.0, 0.0, 0.0]

        def at(self, y: Array) -> Transmitted:
            return Transmitted(float(y[:, 0].mean()), self.shares)

    monkeypatch.setattr(package, "McKibben", Mean)
    face = {"lower": [0.1, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]}
    table = muscle(points=None, region=face, parameters={}, unit="m")
    robot = small_body("linear", cables=[], transmissions=[table])
    assert robot.actuators.kinds == (ActuatorKind.TRANSMISSION,)
    H = robot.rows(robot.rest(), contacts=False).actuators.dense()
    pushed = H.reshape(-1, 3)
    assert pushed.sum(axis=0) == pytest.approx([1.0, 0.0, 0.0])
    assert (pushed[:, 0] > 0.0).sum() == 9, "the nodes of the face"


REFUSED = {
    r"function: no installed package has an entry point 'none' in tauten.actuators": {"function": "none"},
    r"parameters: 'braid' is not one of them": {
        "parameters": {**MUSCLE["parameters"], "braid": 1.0}
    },
    r"parameters: 'turns' is missing; allowed are:": {"parameters": {"fibre": 0.12}},
    r"muscle.parameters: a muscle of length 0.1 m between two points": {
        "parameters": {"fibre": 0.09, "turns": 1.0}
    },
    r"points: point 1 .* outside the mesh": {"points": [LINE[0], [0.5, 0.0, 0.0]]},
    r"give either points or region": {"region": {"kind": "all"}},
    r"min_effort 1 and max_effort 300000 must have zero": {"min_effort": 1.0},
    r"unit": {"unit": "km"},
}  # fmt: skip


@pytest.mark.parametrize("sentence", REFUSED)
def test_what_cannot_be_is_refused(package: ModuleType, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        small_body("linear", transmissions=[muscle(**REFUSED[sentence])])


def test_answers_of_a_wrong_shape_are_refused(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(package.McKibben, "at", lambda self, y: Transmitted(0.0, y[0]))
    with pytest.raises(
        RobotFileError, match=r"gives the gradient of the shape \(3,\), expected is"
    ):
        small_body("linear", transmissions=[muscle()])


def test_a_derivative_that_changes_its_shape_is_named(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kernels read beyond its end, and the process ended with a violation of its memory."""
    robot, usual = small_body("linear", transmissions=[muscle()]), package.McKibben.at
    monkeypatch.setattr(
        package.McKibben, "at", lambda self, y: Transmitted(0.0, usual(self, y).gradient[:1])
    )
    with pytest.raises(
        ExtensionError, match=r"gradient of the shape \(1, 3\), expected is \(2, 3\)"
    ):
        robot.rows(robot.rest(), contacts=False)


def test_what_a_basis_is_made_for_depends_on_it(package: ModuleType) -> None:
    def digest(**changes: Any) -> str:
        return small_body("linear", transmissions=[muscle(**changes)]).digest

    plain: Robot = small_body("linear", transmissions=[])
    assert digest() != plain.digest
    assert digest() == digest(max_effort=2e5)
    assert digest() != digest(parameters={"fibre": 0.13, "turns": 1.5})


def test_messages_and_schema_know_it(
    package: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The description that a node answers with, from a robot file; `tauten schema` has the table."""
    lines = "".join(f"{key} = {_toml(value)}\n" for key, value in muscle().items())
    file = write_robot(tmp_path, f"{ROBOT}\n[[transmissions]]\n{lines}")
    said = RobotDescription.model_validate_json(describe(load_setup(file)).as_json())
    found = said.actuators[-1]
    assert (found.name, found.kind) == ("muscle", ActuatorKind.FLUID_TRANSMISSION)
    assert (found.position, found.effort) == ((-2e-5, 2e-5), (0.0, 3e5))
    assert (said.surface.segments == 2).sum() == 2, "from the middle to both ends"
    assert run_main("schema") == 0
    assert '"TransmissionSettings"' in capsys.readouterr().out


def test_it_is_drawn_as_a_line(
    package: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the middle of its points to both, in the colour of its pressure."""
    lines = "".join(f"{key} = {_toml(value)}\n" for key, value in muscle().items())
    setup = load_setup(write_robot(tmp_path, f"{ROBOT}\n[[transmissions]]\n{lines}"))
    robot = setup.robot
    shown = skin_of(robot).geometry(robot, robot.rest(), None)
    look = RobotLook(describe(setup), shown.vertices)
    assert "transmission" in legend_html(look)
    handles: dict[str, Any] = {}
    with open_server(0, "test") as (server, _):
        add = server.scene.add_line_segments

        def added(name: str, *others: Any, **more: Any) -> Any:
            handles[name] = add(name, *others, **more)
            return handles[name]

        monkeypatch.setattr(server.scene, "add_line_segments", added)
        drawings = dict(drawings_of(server.scene, look))
        own = shown.segments[look.robot.surface.segments == 2]
        drawings[2](shown.vertices, own, 0.0, 3e5)
        handle = handles["/actuators/muscle"]
        np.testing.assert_allclose(handle.points[:, 1], LINE, atol=1e-7)
        np.testing.assert_allclose(handle.points[:, 0], np.mean([LINE, LINE], axis=1), atol=1e-7)
        assert handle.colors[0, 0].tolist() == list(TIGHT)


def _toml(value: object) -> str:
    """A value of a robot file."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    return repr(value).replace("'", '"')
