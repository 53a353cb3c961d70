"""What an extension makes or gives that cannot be used: one sentence names it, at rest and while it moves."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from support.messages import tick_of
from support.robots.my_package import tables
from support.robots.small_bodies import small_body

from tauten.controller import Controller, Status
from tauten.controller.qpcc import Qp, QpAnswer
from tauten.controller.qpcc.qp import AddedBackend
from tauten.model import ExtensionError, Robot, RobotFileError
from tauten.model.load import made
from tauten.service.drive import Driver
from tauten.service.node import Clock, ControlLoop, Estimator, Signals
from tauten.service.node.estimator import make_estimator
from tauten.service.node.inputs import MeasuredLoop
from tauten.service.node.statistics import LoopStatistics
from tauten.service.settings import ServiceSettings
from tauten.service.wire import EffectorSubscriber, Level, OperatorCommand

KINDS = {"transmissions": "McKibben", "effectors": "Spread", "obstacles": "Ring"}
CALLS = {"McKibben": "at", "Spread": "at", "Ring": "closest"}
FOUND = {key: one for table in tables() for key, one in table.items()}
POINTS = {
    "transmissions": [[0.0, 0.01, 0.018], [0.1, 0.01, 0.018]],
    "effectors": [[0.02, 0.01, 0.01], [0.1, 0.01, 0.01], [0.06, 0.01, 0.018]],
}


def extended(kind: str) -> Robot:
    """A beam with one extension of the page."""
    table: dict[str, Any] = {**FOUND[kind][0]}
    if kind in POINTS:
        table["points"] = POINTS[kind]
    if kind == "obstacles":
        return small_body("linear", obstacles=[table], contacts=FOUND["contacts"])
    return small_body("linear", **{kind: [table]})


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "error", [TypeError("no text"), KeyError("x"), RuntimeError("no\nlicence")]
)
def test_a_constructor_that_fails_is_named(
    kind: str, error: Exception, package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All but errors of values were a traceback."""
    usual = getattr(package, KINDS[kind])

    class Failing(usual):  # type: ignore[misc]
        def __init__(self, *given: object, **named: object) -> None:
            raise error

    monkeypatch.setattr(package, KINDS[kind], Failing)
    with pytest.raises(RobotFileError, match=rf"has failed with {type(error).__name__}: .*line \d"):
        extended(kind)


@pytest.mark.parametrize("kind", KINDS)
def test_a_class_that_lacks_its_method_is_named(
    kind: str, package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was a traceback for actuators and effectors."""
    name = KINDS[kind]
    monkeypatch.delattr(getattr(package, name), CALLS[name])
    with pytest.raises(RobotFileError, match=f"makes a {name}, which lacks {CALLS[name]}$"):
        extended(kind)


def test_a_property_that_fails_is_named(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was a traceback."""

    def carrier(self: object) -> None:
        raise KeyError("x")

    monkeypatch.setattr(package.Spread, "carrier", property(carrier), raising=False)
    monkeypatch.setattr(package.Spread, "__init__", lambda self, *given, **named: None)
    with pytest.raises(RobotFileError, match=r"has failed with KeyError: 'x' .*line \d"):
        extended("effectors")


def test_functions_that_do_not_say_what_they_take_are_called() -> None:
    """As compiled ones: the search for their arguments raised."""
    assert made(dict, dict, "effectors.0", {"size": 2.0}) == {"size": 2.0}


WRONG = [
    ("transmissions", "value", "big", "gives the value as a str"),
    ("transmissions", "value", np.zeros(2), r"gives the value of the shape \(2,\)"),
    ("transmissions", "gradient", [[0.0] * 3] * 2, "gives the gradient as a list"),
    ("transmissions", "gradient", np.zeros((3, 2)), r"gives the gradient of the shape \(3, 2\)"),
    ("transmissions", "curvature", np.zeros((3, 6)), r"gives the curvature of the shape \(3, 6\)"),
    ("effectors", "values", 1.0, r"gives the values of the shape \(\)"),
    ("effectors", "delta", np.zeros(2), r"gives delta of the shape \(2,\)"),
    ("effectors", "position", np.zeros(2), r"gives the position of the shape \(2,\)"),
    ("effectors", "gradient", np.zeros((3, 3)), r"gives the gradient of the shape \(3, 3\)"),
    ("effectors", None, None, "gives a NoneType, expected is a Measurement"),
    ("transmissions", None, (1.0, np.zeros((2, 3))), "gives a tuple, expected is a Transmitted"),
    ("obstacles", None, np.zeros(9), "gives a ndarray, expected is a tuple of distances"),
    ("obstacles", None, (np.zeros(1), np.zeros((1, 3))), r"gives distances of the shape \(1,\)"),
]


@pytest.mark.parametrize(("kind", "part", "given", "said"), WRONG, ids=lambda one: str(one)[:40])
def test_wrong_answers_are_named_at_rest_and_later(
    kind: str,
    part: str | None,
    given: object,
    said: str,
    package: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Later most were a traceback from within numpy, and the node ended without a name."""
    name = KINDS[kind]
    own, usual = getattr(package, name), getattr(getattr(package, name), CALLS[name])

    def wrong(self: object, y: object) -> object:
        return given if part is None else replace(usual(self, y), **{part: given})

    robot = extended(kind)
    monkeypatch.setattr(own, CALLS[name], wrong)
    with pytest.raises(ExtensionError, match=f"^(actuator|effector|shape of obstacle) '.*' {said}"):
        robot.rows(robot.rest())
    with pytest.raises(RobotFileError, match=rf"{said}"):
        extended(kind)


def test_a_second_derivative_that_is_no_number_is_refused(
    package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first step was told to have diverged."""
    usual = package.McKibben.at

    def nowhere(self: object, y: object) -> object:
        return replace(usual(self, y), curvature=np.full((6, 6), np.nan))

    monkeypatch.setattr(package.McKibben, "at", nowhere)
    with pytest.raises(RobotFileError, match="'mckibben' is not finite at rest"):
        extended("transmissions")


UNKNOWN = {
    ("transmissions", "value", "muscle"),
    ("transmissions", "gradient", "muscle"),
    ("effectors", "delta", "grasp"),
    ("effectors", "gradient", "grasp"),
    ("effectors", "values", "grasp"),
    ("effectors", "position", "grasp"),
    ("obstacles", "distance", "skin on hoop"),
}


Answer = Callable[[object, object], Any]


def answers(kind: str, part: str, package: ModuleType) -> tuple[type, str, Answer, Answer]:
    """The class of a kind, its method, and what this gives: as usual, and with a part that is not finite."""
    own, call = getattr(package, KINDS[kind]), CALLS[KINDS[kind]]
    usual: Answer = getattr(own, call)

    def unknown(self: object, y: object) -> object:
        found = usual(self, y)
        if kind == "obstacles":
            return found[0] * np.nan, found[1]
        return replace(found, **{part: getattr(found, part) * np.nan})

    return own, call, usual, unknown


@pytest.mark.parametrize(("kind", "part", "name"), sorted(UNKNOWN))
def test_health_names_the_extension_whose_numbers_are_not_finite(
    kind: str, part: str, name: str, package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The status was NOT_FINITE, and nothing said of what."""
    robot = extended(kind)
    own, call, usual, unknown = answers(kind, part, package)
    loop = ControlLoop(Controller(robot))
    goal = loop.controller.effector_values
    statistics = LoopStatistics(robot.actuators, robot.effector_layout, robot.size)
    for answer, conflict in ((usual, ()), (unknown, (name,))):
        monkeypatch.setattr(own, call, answer)
        loop.rest()
        action = loop.tick(goal, Signals(target=True))
        assert action.wanted.conflict == conflict
        assert action.wanted.status is (Status.NOT_FINITE if conflict else Status.OK)
        statistics.add(tick_of(action), action, action.actuation.effector_values)
        said = statistics.diagnostics(Clock(0.02), [], None, {})[1]
        assert (said.level is Level.WARN) == bool(conflict)
        assert said.message.endswith(f"; last not finite: {name}" if conflict else "0 not OK")
        loop.rest()
        held = loop.tick(None, Signals(target=False)).wanted  # is published too
        assert held.conflict == conflict


@pytest.mark.parametrize(("kind", "part", "name"), sorted(UNKNOWN))
def test_numbers_that_are_finite_again_are_followed_again(
    kind: str, part: str, name: str, package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After one of an actuator that was not, the robot held until an operator stopped and reset it."""
    loop = ControlLoop(Controller(extended(kind)))
    own, call, usual, unknown = answers(kind, part, package)
    goal, found = loop.controller.effector_values, []
    for answer in (usual, unknown, unknown, usual, usual, usual):
        monkeypatch.setattr(own, call, answer)
        found.append(loop.tick(goal, Signals(target=True)))
        loop.prepare()
    assert any(one.wanted.conflict == (name,) for one in found)
    assert found[-1].status is Status.OK


CORNERS = np.array([[0.1, 0.03, 0.01], [0.1, -0.01, 0.01], [0.1, 0.01, 0.03]])
OUTLINES = {
    r"gives a NoneType, expected is a tuple of vertices": None,
    r"gives vertices of the shape \(3, 2\), expected is \(3, 3\)": (CORNERS[:, :2], np.array([[0, 1, 2]])),
    r"gives triangles that are not three numbers of its 3 ": (CORNERS, np.array([[1, 2, 3]])),
    r"gives triangles that are not three numbers of its": (CORNERS, np.array([[0.0, 1.0, 2.0]])),
    r"gives vertices that are not finite": (np.nan * CORNERS, np.array([[0, 1, 2]])),
}  # fmt: skip


@pytest.mark.parametrize("said", OUTLINES)
def test_an_outline_that_cannot_be_drawn_is_named(
    said: str, package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Robots with it could not be loaded, with a traceback."""
    monkeypatch.setattr(package.Ring, "outline", lambda *_: OUTLINES[said], raising=False)
    with pytest.raises(ExtensionError, match=rf"outline of the shape of obstacle 'hoop' {said}"):
        extended("obstacles")
    monkeypatch.setattr(package.Ring, "outline", lambda *_: 1 / 0)
    with pytest.raises(
        ExtensionError, match=r"outline .* 'hoop' has failed with ZeroDivisionError"
    ):
        extended("obstacles")
    monkeypatch.setattr(package.Ring, "outline", lambda *_: (CORNERS, np.array([[0, 1, 2]])))
    assert len(extended("obstacles").contacts.poses.obstacles) == 1


def test_a_qp_answer_of_another_size_is_named() -> None:
    """One without the last variable was used: decisions had the wrong efforts, with status OK."""
    problem = Qp(np.eye(2), np.ones(2), np.zeros((0, 2)), np.zeros(2), np.ones(2))
    for y, multipliers, said in (
        (np.zeros(1), np.zeros(2), r"gives y of the shape \(1,\), expected is \(2,\)"),
        (np.zeros(2), np.zeros(0), r"gives multipliers of the shape \(0,\), expected is \(2,\)"),
        ([0.0, 0.0], np.zeros(2), "gives y as a list, expected is an array"),
    ):
        backend = AddedBackend("wrong", lambda _, y=y, m=multipliers: QpAnswer(False, y, m))  # type: ignore[misc]
        with pytest.raises(ExtensionError, match=f"QP solver 'wrong' {said}"):
            backend(problem)


def test_an_estimator_that_cannot_be_made_or_reset_is_named(
    beam: Robot, package: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both were a traceback: the function takes other arguments, and `reset` fails after a command."""
    monkeypatch.setattr(package, "median_estimator", lambda robot: None)
    settings = ServiceSettings(estimator="median")
    with pytest.raises(RobotFileError, match=r"estimator 'median' has failed with TypeError"):
        make_estimator(beam, settings)

    class Unready(Estimator):
        def reset(self) -> None:
            raise ValueError("no camera")

    layout, rest = beam.effector_layout, beam.effector_values(beam.rest())
    subscriber = EffectorSubscriber([], beam.frame, layout, rest, 1.0, timeout=0.25)
    loop = MeasuredLoop(beam, settings, subscriber, Unready())
    with pytest.raises(ExtensionError, match=re.escape("'median' has failed with ValueError: no")):
        loop.after_command(OperatorCommand.RESET)


def test_a_driver_that_cannot_be_made_is_named() -> None:
    def broken() -> Driver:
        raise KeyError("usb")

    with pytest.raises(RobotFileError, match=r"driver plugs has failed with KeyError: 'usb' \("):
        made(broken, Driver, "driver plugs", {})
