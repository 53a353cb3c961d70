"""What docs/extend.md adds from outside works in tauten: through robot files, commands and arguments."""

from __future__ import annotations

import ast
import re
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from support.messages import Point, encode_point
from support.processes import ROBOT, run_main, write_robot
from support.qpcc_checks import assert_solves, recorded
from support.robots.my_package import blocks, write_package
from support.robots.small_bodies import small_body
from support.state_bases import basis_of, projected, turned_space

from tauten.controller import Controller, Status, warm_controller
from tauten.controller.qpcc import (
    Qp,
    QpAnswer,
    QpccSettings,
    available_backends,
    qp,
    qp_backend,
    solve_qpcc,
)
from tauten.model import Robot, RobotFileError, Simulator, State
from tauten.model.effectors import Measurement
from tauten.model.load import extension
from tauten.model.numerics import Array
from tauten.reduction.state import reduced_robot, reducible
from tauten.service.node import LARGEST, Estimator
from tauten.service.node.estimator import make_estimator
from tauten.service.node.inputs import MeasuredLoop
from tauten.service.plant import free_ports
from tauten.service.settings import ServiceSettings
from tauten.service.setup import load_setup
from tauten.service.wire import CDR, Cause, EffectorSubscriber, Level, OperatorCommand

LINES = 40


def test_each_example_is_short() -> None:
    for block in blocks("python"):
        assert len(block.splitlines()) <= LINES
        assert ast.parse(block).body


def test_names_are_those_of_installed_packages(package: ModuleType) -> None:
    assert extension("tauten.qp_solvers", "none_such") is None
    with pytest.raises(
        ValueError, match="QP solver 'none_such' is not installed, found are daqp, "
    ):
        qp_backend("none_such")
    assert "admm" in available_backends()


def test_a_robot_file_with_an_unknown_qp_library_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the node, in one sentence; it was a traceback."""
    file = write_robot(
        tmp_path, ROBOT.replace("rate = 50.0 }", 'rate = 50.0, qp_solver = "nope" }')
    )
    assert run_main("serve", str(file), "--port", str(free_ports())) == 2
    said = f"{file.name}: controller.qp_solver: QP solver 'nope' is not installed, found are daqp"
    assert said in capsys.readouterr().err


@pytest.mark.long
def test_a_qp_library_decides_alike(package: ModuleType, tmp_path: Path) -> None:
    """By name from a robot file, and as an argument: the certificate proves its decisions as any others."""
    file = write_robot(
        tmp_path, ROBOT.replace("rate = 50.0 }", 'rate = 50.0, qp_solver = "admm" }')
    )
    setup = load_setup(file)
    named, given = warm_controller(setup), Controller(setup.robot, qp=package.admm)
    assert named.settings.qpcc.solver == "admm"
    usual = Controller(setup.robot)
    target = usual.shifted(0.05 * setup.robot.size)
    for _ in range(2):
        found = [one.step(target) for one in (named, given, usual)]
        for one in found:
            assert one.status is Status.OK
            assert one.certificate.stationarity < 1e-6
            np.testing.assert_allclose(one.effort, found[2].effort, rtol=1e-6, atol=1e-6)


@pytest.mark.long
def test_a_qp_library_solves_what_the_default_solves(package: ModuleType) -> None:
    calls, problems = 0, [step.problem() for step in recorded("three_cables_5")[:40:16]]

    def counted(qp: Qp) -> QpAnswer:
        nonlocal calls
        calls += 1
        answer: QpAnswer = package.admm(qp)
        return answer

    for problem in problems:
        usual = solve_qpcc(problem)
        found = solve_qpcc(problem, settings=QpccSettings(counted))
        assert found.status is Status.OK
        assert_solves(problem, found)
        np.testing.assert_allclose(found.lam_a, usual.lam_a, atol=1e-5)
    assert calls > 0


class Ring:
    """Measurements of one effector."""

    def __init__(self) -> None:
        self.samples: list[Sample] = []

    def try_recv(self) -> Sample | None:
        return self.samples.pop(0) if self.samples else None


@dataclass(frozen=True)
class Sample:
    """A measurement as Zenoh gives it."""

    payload: bytes
    encoding: str = CDR
    timestamp: None = None


def test_an_estimator_corrects_a_closed_loop(package: ModuleType, beam: Robot) -> None:
    """A robot a millimetre beside its model, of which one measurement in five is far off."""
    settings = ServiceSettings(estimator="median", measurement_timeout=5.0)
    layout, rest = beam.effector_layout, beam.effector_values(beam.rest())
    rings = [Ring() for _ in beam.effector_names]
    subscriber = EffectorSubscriber(rings, beam.frame, layout, rest, 1.0, timeout=0.25)
    loop = MeasuredLoop(beam, settings, subscriber)
    off = np.array([0.0, 1e-3, 0.0])
    for tick in range(60):
        wrong = 3e-3 if tick % 5 == 4 else 0.0
        for ring, xyz in zip(rings, rest.reshape(-1, 3) - off - wrong, strict=True):
            ring.samples.append(Sample(encode_point(Point(0, "", tuple(xyz.tolist())))))
        now = 10.0 + 0.02 * tick
        subscriber.read(now, 1.8e9)
        assert loop.correct(now, rest) is Cause.NONE
    np.testing.assert_allclose(loop.correction.reshape(-1, 3), np.tile(off, (2, 1)), atol=1e-9)
    assert loop.diagnostic().values["estimator"] == "median"
    loop.after_command(OperatorCommand.RESET)
    assert not loop.correction.any()


def test_what_an_estimator_gives_is_bounded(beam: Robot) -> None:
    """By argument: one that is not finite or of another shape is not used, a long one is shortened.

    Nothing was said of one that is not used.
    """

    class Wild(Estimator):
        found = np.full(beam.effector_layout.n_rows, np.nan)

        def update(self, predicted: Array, measured: Array, seconds: float) -> Array:
            return self.found

        def reset(self) -> None:
            pass

    layout, rest, wild = beam.effector_layout, beam.effector_values(beam.rest()), Wild()
    rings = [Ring() for _ in beam.effector_names]
    subscriber = EffectorSubscriber(rings, beam.frame, layout, rest, 1.0, timeout=0.25)
    loop = MeasuredLoop(beam, ServiceSettings(), subscriber, wild)
    for tick in range(3):
        for ring, xyz in zip(rings, rest.reshape(-1, 3).tolist(), strict=True):
            ring.samples.append(Sample(encode_point(Point(0, "", tuple(xyz)))))
        subscriber.read(10.0 + 0.02 * tick, 1.8e9)
        loop.correct(10.0 + 0.02 * tick, rest)
        if tick < 2:
            assert not loop.correction.any()
            said = ("not finite", r"of the shape \(7,\), expected is \(6,\)")[tick]
            assert re.search(
                f"estimator gives a correction .*{said}: it is", loop.diagnostic().message
            )
            assert loop.diagnostic().level is Level.WARN
            wild.found = np.full(layout.n_rows + 1 - tick, 1e3)
    assert layout.lengths(loop.correction).max() == pytest.approx(LARGEST * beam.size)


def test_an_estimator_that_nobody_has_is_refused(beam: Robot) -> None:
    with pytest.raises(RobotFileError, match="estimator is 'kalman', found are feedback"):
        make_estimator(beam, ServiceSettings(estimator="kalman"))


SPREAD = {
    "name": "grasp", "kind": "function", "measure": "spread",
    "points": [[0.1, 0.0, 0.01], [0.1, 0.02, 0.01], [0.08, 0.01, 0.015]],
}  # fmt: skip

POINT = {"name": "tip", "point": [0.1, 0.01, 0.01], "parameters": {"power": 2.0}}


def test_parameters_of_the_file_are_those_of_the_function(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numbers, and lists as arrays."""
    given: dict[str, object] = {}

    class Weighted(package.Spread):  # type: ignore[misc, name-defined]
        def __init__(self, rest: Array, power: float, weights: Array) -> None:
            super().__init__(rest)
            given.update(rest=rest, power=power, weights=weights)

    monkeypatch.setattr(package, "Spread", Weighted)
    parameters = {"power": 2.0, "weights": [[1.0, 2.0], [3.0, 4.0]]}
    small_body("linear", effectors=[{**SPREAD, "parameters": parameters}])
    assert given["power"] == 2.0
    np.testing.assert_array_equal(given["weights"], parameters["weights"])
    np.testing.assert_array_equal(given["rest"], SPREAD["points"])


def test_a_function_of_points_is_an_effector_of_full_and_reduced_robots(
    package: ModuleType,
) -> None:
    """Its rows are the derivative of its value, in modes too, and it is drawn at its points' mean."""
    robot = small_body("linear", effectors=[SPREAD])
    rng = np.random.default_rng(0)
    q, d = robot.rest().q + 1e-3 * rng.normal(size=robot.n), rng.normal(size=robot.n)
    state = State(q, np.zeros(robot.n))
    values = [robot.effector_values(State(state.q + by * d, d)) for by in (1e-6, -1e-6)]
    rows = robot.rows(state, contacts=False).effectors
    np.testing.assert_allclose(rows.H @ d, (values[0] - values[1]) / 2e-6, rtol=1e-6)
    y = np.array(SPREAD["points"])
    assert robot.effector_values(robot.rest())[0] == pytest.approx(np.sqrt(y.var(axis=0).sum()))
    assert robot.effector(robot.rest())[0] == pytest.approx(y.mean(axis=0))
    Phi, every = turned_space(robot), np.arange(reducible(robot).n_elements)
    reduced = reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))
    found = reduced.rows(projected(reduced, state), contacts=False).effectors
    np.testing.assert_allclose(found.values, rows.values, rtol=1e-9)
    np.testing.assert_allclose(found.dense(), rows.dense() @ Phi, atol=1e-9)


def test_targets_of_a_function_are_followed(package: ModuleType) -> None:
    """To a value that a pull of the cable is known to give."""
    points = [[0.0, 0.01, 0.0], [0.1, 0.01, 0.02], [0.08, 0.01, 0.015]]
    robot = small_body("linear", effectors=[{**SPREAD, "points": points}])
    simulator = Simulator(robot, "none")
    assert simulator.settle(position=[2e-3]).converged
    goal, start = robot.effector_values(simulator.state), robot.effector_values(robot.rest())
    controller = Controller(robot)
    for _ in range(100):
        assert controller.step(goal).status.usable
    assert abs(controller.effector_values - goal)[0] < 0.05 * abs(goal - start)[0]


def test_a_function_that_nobody_has_or_of_a_wrong_shape_is_refused(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = package.Spread.at
    with pytest.raises(RobotFileError, match="no installed package has an entry point 'none' in"):
        small_body("linear", effectors=[{**SPREAD, "measure": "none"}])
    with pytest.raises(RobotFileError, match=r"effectors\.0\.parameters: 'power' is not one"):
        small_body("linear", effectors=[{**SPREAD, "parameters": {"power": 2.0}}])
    with pytest.raises(ValueError, match="not a field of an effector of kind 'point'"):
        small_body("linear", effectors=[POINT])
    monkeypatch.setattr(package.Spread, "at", lambda self, y: Measurement(y, y, y, y))
    with pytest.raises(
        RobotFileError, match=r"gives the values of the shape \(3, 3\), expected is \(1,\)"
    ):
        small_body("linear", effectors=[SPREAD])
    monkeypatch.setattr(package.Spread, "at", lambda self, y: nowhere(usual(self, y)))
    with pytest.raises(RobotFileError, match="'spread' is not finite at rest"):
        small_body("linear", effectors=[SPREAD])


def nowhere(found: Measurement) -> Measurement:
    """A measurement that is not known."""
    return Measurement(found.values * np.nan, found.delta, found.position, found.gradient)


def test_a_package_that_fails_when_it_is_imported_is_named(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Whatever it raises: a licence that is missing, a typing error."""
    for text, sentence in (
        ("raise RuntimeError('no licence')", "RuntimeError: no licence"),
        ("x = = 1", "SyntaxError: "),
    ):
        monkeypatch.delitem(sys.modules, package.__name__, raising=False)
        (tmp_path / f"{package.__name__}.py").write_text(text)
        monkeypatch.syspath_prepend(tmp_path)
        with pytest.raises(RobotFileError, match=f"my_package:Spread cannot be .*{sentence}"):
            extension("tauten.effectors", "spread")
        shutil.rmtree(tmp_path / "__pycache__", ignore_errors=True)


def found_anew(name: str) -> object:
    """A QP library, whose name has not been asked for yet."""
    qp._named.cache_clear()
    return qp_backend(name)


BALL = {"name": "hoop", "shape": "sphere", "parameters": {"centre": [0.0, 0.0, 1.0], "radius": 0.1}}


@pytest.mark.parametrize(
    ("group", "name", "use"),
    [
        ("contact_shapes", "sphere", lambda beam: small_body("linear", obstacles=[BALL])),
        ("estimators", "feedback", lambda beam: make_estimator(beam, ServiceSettings())),
        ("qp_solvers", "daqp", lambda beam: found_anew("daqp")),
    ],
)
def test_a_package_cannot_take_a_name_of_tautens_own(
    group: str,
    name: str,
    use: Callable[[Robot], object],
    beam: Robot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It was not used, and nothing was said. Without the package the name is tauten's."""
    use(beam)
    write_package(tmp_path, "taker", "take = print", {f"tauten.{group}": {name: "taker:take"}})
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(RobotFileError, match=f"^{name} .* by taker:take and by tauten: all but"):
        use(beam)


def test_two_packages_cannot_have_the_same_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One of them was used, depending on the order of folders."""
    for one in ("a", "b"):
        write_package(tmp_path, one, "take = print", {"tauten.drivers": {"arm": f"{one}:take"}})
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(RobotFileError, match=r"registered by [ab]:take and by [ab]:take: all but"):
        extension("tauten.drivers", "arm")
