"""A reduced model by switch: made by one command, refused where it errs, watched while it serves."""

from __future__ import annotations

import os
import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from support.messages import encode_point
from support.nodes import last_health, point_at
from support.processes import (
    START,
    Served,
    at_ordinary_priority,
    client_of,
    run_main,
    start,
    wait_alive,
)
from support.robots.thumb import write_thumb

from tauten.controller import Controller
from tauten.model import load_robot
from tauten.reduction.state import ReducedBody, StateBasis, StateBasisError
from tauten.service.codec.messages import POINT
from tauten.service.describing import describe
from tauten.service.link import close_session
from tauten.service.node import ControlLoop
from tauten.service.node.model_watch import make_fall_back
from tauten.service.plant import free_ports
from tauten.service.setup import load_setup
from tauten.service.wire import CDR, Keys, Level


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Robot file with contact and state basis beside it."""
    folder = tmp_path_factory.mktemp("thumb")
    file = write_thumb(folder)
    more = ("--design", "ramp", "--step", 4e-4, "--k", 3, "--states", "--state-modes", 8)
    places = ("--out", folder / "thumb.basis", "--snapshots", folder / "campaign")
    assert run_main("reduce", file, *more, *places) == 0
    return file


@pytest.fixture
def thumb_file(original: Path, tmp_path: Path) -> Path:
    """A copy that a test may spoil."""
    folder = tmp_path / "thumb"
    shutil.copytree(original.parent, folder)
    return folder / "thumb.toml"


def configure(file: Path, **settings: object) -> None:
    """Add a [model] table to a robot file."""
    lines = [f"{key} = {str(value).lower()}" for key, value in settings.items()]
    file.write_text(file.read_text() + "\n".join(["[model]", 'states = "thumb.states"', *lines]))


def test_one_campaign_makes_both_bases(original: Path) -> None:
    states = StateBasis.load(original.parent / "thumb.states")
    setup = load_setup(original, basis="thumb.basis")
    assert not isinstance(setup.contact, str)
    assert states.origin.snapshots_digest == setup.contact.provenance.snapshots_digest
    assert states.origin.campaign == setup.contact.provenance.campaign
    assert states.origin.robot_digest == setup.robot.digest
    assert states.origin.r - states.origin.responses == 8


def test_inspect_prints_where_a_state_basis_comes_from(
    original: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    states = original.parent / "thumb.states"
    capsys.readouterr()
    assert run_main("inspect", states) == 0
    said = capsys.readouterr().out
    assert "ramp: each cable" in said
    origin = StateBasis.load(states).origin
    assert re.search(rf"tip max *│ {1e3 * origin.tip_max:.3g} mm ", said)
    assert "None" not in said  # nothing was pressed
    digest = re.search(r"robot digest *│ (\w+) *│\n│ *│ (\w+)", said)
    assert digest is not None
    assert "".join(digest.groups()) == origin.robot_digest


def test_switch_is_in_file_and_arguments(thumb_file: Path) -> None:
    configure(thumb_file, order='"reduced"')
    setup = load_setup(thumb_file, basis="thumb.basis")
    assert isinstance(setup.robot.body, ReducedBody)
    model = describe(setup).model
    assert model.order == "reduced"
    assert len(model.states) == 64
    full = load_setup(thumb_file, basis="thumb.basis", model="full")
    assert not isinstance(full.robot.body, ReducedBody)
    assert describe(full).model.states == ""


def test_model_that_errs_too_much_is_refused_unless_accepted(thumb_file: Path) -> None:
    configure(thumb_file, max_tip_error=1e-9)
    with pytest.raises(StateBasisError, match="allowed are 1e-06 mm"):
        load_setup(thumb_file, model="reduced")
    accepted = load_setup(thumb_file, model="reduced", accept_error=True)
    assert isinstance(accepted.robot.body, ReducedBody)


@pytest.mark.long
def test_reduce_keeps_no_model_that_errs_too_much(
    thumb_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    configure(thumb_file, max_tip_error=1e-9)
    folder = thumb_file.parent
    (folder / "thumb.states").unlink()
    more = ("--design", "ramp", "--step", 4e-4, "--k", 3, "--states", "--state-modes", 8)
    places = ("--out", folder / "thumb.basis", "--snapshots", folder / "campaign")
    assert run_main("reduce", thumb_file, *more, *places) == 2
    said = capsys.readouterr().err
    assert "held-out loads, where 1e-06 mm are allowed" in said
    assert not (folder / "thumb.states").exists()


def test_missing_state_basis_is_one_sentence(
    thumb_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (thumb_file.parent / "thumb.states").unlink()
    assert run_main("serve", thumb_file, "--model", "reduced") == 2
    assert "tauten: no state basis 'thumb'" in capsys.readouterr().err


def test_damaged_state_basis_is_refused(thumb_file: Path) -> None:
    file = thumb_file.parent / "thumb.states"
    file.write_bytes(file.read_bytes()[:-200])
    configure(thumb_file)
    with pytest.raises(StateBasisError, match="no readable tauten state basis"):
        load_setup(thumb_file, model="reduced")


@pytest.mark.long
def test_full_model_watches_and_takes_over(thumb_file: Path) -> None:
    """With a bound that nothing keeps the full model takes over, from where the reduced one was."""
    configure(
        thumb_file, max_tip_error=1e-9, check_period=0.01, fall_back=True, fall_back_rate=25.0
    )
    setup = load_setup(thumb_file, basis="thumb.basis", model="reduced", accept_error=True)
    loop = ControlLoop(Controller(setup.robot, setup.contact))
    fall_back = make_fall_back(setup)
    assert fall_back is not None
    goal = loop.controller.effector + np.array([[0.004, 0.0, 0.001]])
    try:
        for _ in range(10):
            loop.act(goal)
            loop.prepare()
        end = time.monotonic() + START
        while not fall_back.wanted and time.monotonic() < end:
            at_ordinary_priority(os.getpid())
            fall_back.watch.look(loop.controller)
            time.sleep(0.1)
        assert fall_back.wanted
        found = fall_back.watch.diagnostic()
        assert found.level is Level.WARN
        assert "outside of the states it was trained with" in found.message
        before, tip = loop.act(goal), loop.controller.effector
        assert fall_back.switch(loop) == pytest.approx(1.0 / 25.0)
        assert not isinstance(loop.controller.robot.body, ReducedBody)
        np.testing.assert_allclose(loop.controller.effector, tip, atol=1e-12)
        after = loop.act(goal)
        limits = setup.robot.limits
        assert (
            np.abs(after.actuation.position - before.actuation.position)
            <= limits.rate / 25.0 + 1e-12
        ).all()
        assert not fall_back.wanted
        assert "taken over" in fall_back.watch.diagnostic().message
        loop.rest()  # as after a stop: it started undeformed and fell
        sagging = loop.controller.effector
        for _ in range(3):
            loop.act(None)
            loop.prepare()
        np.testing.assert_allclose(loop.controller.effector, sagging, atol=1e-7)
    finally:
        fall_back.watch.close()


@pytest.mark.long
def test_model_where_it_was_trained_is_well(thumb_file: Path) -> None:
    configure(thumb_file, check_period=0.01)
    setup = load_setup(thumb_file, basis="thumb.basis", model="reduced")
    controller, fall_back = Controller(setup.robot, setup.contact), make_fall_back(setup)
    assert fall_back is not None
    try:
        end = time.monotonic() + START
        while fall_back.watch.error is None and time.monotonic() < end:
            at_ordinary_priority(os.getpid())
            fall_back.watch.look(controller)
            time.sleep(0.1)
        assert fall_back.watch.diagnostic().level is Level.OK
        assert (
            fall_back.watch.diagnostic().message == "reduced, within the states it was trained with"
        )
        assert not fall_back.wanted
    finally:
        fall_back.watch.close()
    fall_back.watch.look(controller)  # gone: health says so, the loop goes on
    assert fall_back.watch.diagnostic().level is Level.WARN


@pytest.mark.long
def test_run_of_the_reduced_model_replays(thumb_file: Path, tmp_path: Path) -> None:
    """Served as a process: health has the error of the model, and the replay decides the same."""
    configure(thumb_file, order='"reduced"', check_period=0.05)
    port, log = free_ports(), tmp_path / "log.mcap"
    serving = ("serve", thumb_file, "--basis", "thumb.basis", "--port", port, "--record", log)
    process = start(tmp_path / "serve.txt", *serving)
    session = client_of(process, port, "thumb")
    keys, robot = Keys("thumb"), load_robot(thumb_file)
    try:
        wait_alive(session, keys.token, process)
        targets = session.declare_publisher(
            keys.targets(robot.effector_names)[0], encoding=f"{CDR};{POINT}"
        )
        served = Served(process, session, keys, port, log)
        end, found = time.monotonic() + START, last_health(served)["model"]
        while "error_mm" not in found.values and time.monotonic() < end:
            at_ordinary_priority(process.process.pid)
            for _ in range(25):
                targets.put(encode_point(point_at(robot, 0.001, robot.frame)))
                time.sleep(0.02)
            found = last_health(served)["model"]
        assert int(last_health(served)["decisions"].values["status_OK"]) > 20
        assert found.level is Level.OK
        assert 0.0 <= float(found.values["error_mm"]) < 1.0
        assert process.end() == 0
    finally:
        close_session(session)
        if process.process.poll() is None:
            process.process.kill()
        process.process.wait()
    # of the range; kernels compiled by this run may round otherwise than when they come from disk
    assert run_main("replay", log, "--tolerance", 1e-9, "--recorded-paths") == 0
