"""What another package adds fails: at rest the robot file is refused, in the loop the robot is released."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from support.messages import encode_point
from support.nodes import point_at
from support.processes import ROBOT, write_robot
from support.robots.my_package import MUSCLE, SPREAD, write_package

from tauten.controller import warm_controller
from tauten.controller.qpcc import Qp, qp_backend
from tauten.model import ExtensionError, Robot, RobotFileError, load_robot
from tauten.model.numerics import Array
from tauten.service.cli import run
from tauten.service.codec.messages import POINT
from tauten.service.describing import log_metadata
from tauten.service.log import LogReader, LogRecorder
from tauten.service.node import ControlLoop
from tauten.service.node.clock import Beat, Clock
from tauten.service.node.estimator import make_estimator
from tauten.service.node.node import Node
from tauten.service.plant import free_ports
from tauten.service.process import StopFlag
from tauten.service.replay import replay
from tauten.service.settings import ServiceSettings
from tauten.service.setup import load_setup
from tauten.service.wire import (
    CDR,
    Joints,
    Keys,
    Network,
    Role,
    decode_joints,
    open_session,
)

RING = """
[[obstacles]]
name = "hoop"
shape = "ring"
parameters = { centre = [0.05, 0.01, 0.01], axis = [1.0, 0.0, 0.0], radius = 0.03, thickness = 0.005 }

[[contacts]]
against = "hoop"
points = "vertices"
"""


class Failing:
    """A method of the package's class that fails from a time on."""

    def __init__(self, patch: pytest.MonkeyPatch, kind: type[object], method: str) -> None:
        self.on, usual = False, getattr(kind, method)

        def either(one: object, *given: object) -> object:
            if self.on:
                raise ZeroDivisionError("they coincide")
            return usual(one, *given)

        patch.setattr(kind, method, either)


@pytest.mark.long
@pytest.mark.parametrize(
    ("table", "kind", "method", "named"),
    [
        (SPREAD, "Spread", "at", "effector 'grasp'"),
        (MUSCLE, "McKibben", "at", "actuator 'muscle'"),
        (RING, "Ring", "closest", "shape of obstacle 'hoop'"),
    ],
)
def test_a_node_whose_extension_fails_releases_the_robot_and_says_which(
    table: str,
    kind: str,
    method: str,
    named: str,
    package: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The release failed too, so that cables kept what they had: it asked where the effectors are."""
    failing = Failing(monkeypatch, getattr(package, kind), method)
    file = write_robot(tmp_path, ROBOT + table)
    setup, port = load_setup(file, basis="full"), free_ports()
    keys, log = Keys("beam"), tmp_path / "run.mcap"
    inside = open_session(Network(port), Role.NODE, "beam", connected=False)
    outside = open_session(Network(port), Role.OTHER, "beam", connected=False)
    controller = warm_controller(setup)
    recorder = LogRecorder(log, log_metadata(setup, controller.effector_values))
    node = Node(
        setup, ControlLoop(controller, settings=setup.service), inside, recorder, closed_loop=False
    )
    clock, end = Clock(0.02, lambda: 0.0), time.monotonic() + 60.0
    while controller.position.max() < 1e-3:  # wound up, towards a target
        assert time.monotonic() < end
        target = encode_point(point_at(setup.robot, 0.01))
        outside.put(keys.targets(("tip",))[0], target, encoding=f"{CDR};{POINT}")
        time.sleep(0.005)
        node.tick(clock, Beat(0, 0.0, 0.01, 0), shutdown=False)
    failing.on = True
    with pytest.raises(ExtensionError, match=f"^{named} has failed with ZeroDivisionError: they "):
        node.run(StopFlag())
    inside.close()  # type: ignore[no-untyped-call]
    outside.close()  # type: ignore[no-untyped-call]
    recorder.close()
    left = []
    for message in LogReader(log).messages():
        if message.key == keys.actuation:
            joints = decode_joints(message.payload, CDR, setup.robot.actuators.names)
            assert isinstance(joints, Joints)
            left.append(joints.position)
    moves = np.diff(np.array(left), axis=0)  # (m, n_a)
    assert (abs(moves) <= setup.robot.limits.rate * setup.robot.h * (1.0 + 1e-9)).all()
    assert not np.any(left[-1])
    failing.on = False
    assert replay(log, 1e-4, against=str(file)).same


@pytest.mark.parametrize(
    ("table", "kind", "method", "given", "said"),
    [
        (
            SPREAD,
            "Spread",
            "at",
            3.0,
            r"effectors\.2\.measure: 'spread' gives a float, expected is a Measurement",
        ),
        (
            MUSCLE,
            "McKibben",
            "at",
            None,
            r"transmissions\.muscle\.function: 'mckibben' gives a NoneType, expected ",
        ),
        (
            RING,
            "Ring",
            "closest",
            None,
            r"contacts\.0\.against: the shape gives a NoneType, expected is a tuple",
        ),
        (
            SPREAD,
            "Spread",
            "at",
            ZeroDivisionError("no"),
            r"measure has failed with ZeroDivisionError: no ",
        ),
        (
            SPREAD,
            "Spread",
            "carrier",
            None,
            r"effectors\.2 makes a Lacking, which lacks carrier",
        ),
    ],
)
def test_what_an_extension_gives_at_rest_is_checked(
    table: str,
    kind: str,
    method: str,
    given: object,
    said: str,
    package: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without this each is an error of an attribute, with a traceback."""

    def wrong(*_: object) -> object:
        if isinstance(given, Exception):
            raise given
        return given

    file = write_robot(tmp_path, ROBOT + table)
    if method == "carrier":

        class Lacking:
            at = getattr(package, kind).at

            def __init__(self, rest: Array) -> None:
                pass

        monkeypatch.setattr(package, kind, Lacking)
    else:
        monkeypatch.setattr(getattr(package, kind), method, wrong)
    with pytest.raises(RobotFileError, match=f"^{file}: .*{said}"):
        load_robot(file)


def test_a_qp_library_that_fails_or_gives_no_answer_is_named(
    package: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was an error of an attribute in the solver."""
    write_package(
        tmp_path, "wrong", "def none(qp): pass\ndef bad(qp): return 1 / 0\n",
        {"tauten.qp_solvers": {"none": "wrong:none", "bad": "wrong:bad"}},
    )  # fmt: skip
    monkeypatch.syspath_prepend(tmp_path)
    problem = Qp(np.eye(1), np.ones(1), np.zeros((0, 1)), np.zeros(1), np.ones(1))
    for name, said in (
        ("none", "QP solver 'none' gives a NoneType, expected is a QpAnswer"),
        ("bad", r"QP solver 'bad' has failed with ZeroDivisionError: .*wrong\.py, line 2\)"),
    ):
        with pytest.raises(ExtensionError, match=said):
            qp_backend(name)(problem)


def test_an_estimator_that_cannot_be_used_is_named(
    beam: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = """
class Half:
    def reset(self): pass
def nothing(robot, settings): return None
def half(robot, settings): return Half()
def refusing(robot, settings): raise ValueError("it needs three effectors")
"""
    names = {name: f"wrong:{name}" for name in ("nothing", "half", "refusing")}
    write_package(tmp_path, "wrong", code, {"tauten.estimators": names})
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "wrong", raising=False)
    for name, said in (
        ("nothing", "'nothing' makes a NoneType, which lacks update, reset"),
        ("half", "'half' makes a Half, which lacks update"),
        ("refusing", "'refusing': it needs three effectors"),
    ):
        with pytest.raises(RobotFileError, match=f"robot beam: service.estimator {said}"):
            make_estimator(beam, ServiceSettings(estimator=name))


def test_an_error_of_an_extension_is_one_sentence_of_a_command(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def command() -> None:
        raise ExtensionError("effector 'grasp' has failed")

    with pytest.raises(SystemExit) as ended:
        run(command)
    assert ended.value.code == 2
    assert capsys.readouterr().err == "tauten: effector 'grasp' has failed\n"
