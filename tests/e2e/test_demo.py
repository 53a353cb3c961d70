"""The demo: three processes, and a folder with what they did."""

from __future__ import annotations

import json
import os
import shutil
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.processes import START, forked, run_main, start
from support.robots.hanging import hanging_beam

from tauten.service.frames import RecordedRobot, ViewFrame
from tauten.service.plant import DemoError, DemoSettings, child, run_demo
from tauten.service.plant.demo import FIGURE, LOG, REPORT, TARGETS, slow_plant
from tauten.service.process import StopFlag, alone_in
from tauten.service.replay import Series, read_run, replay
from tauten.service.view import export_log


@pytest.fixture(scope="module")
def folder(beam_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of the command, whose node and plant are copies of it."""
    out = tmp_path_factory.mktemp("demo") / "out"
    targets = ("--seconds", 2, "--period", 2, "--fraction", 0.3)
    demo = start(out.with_name("said.txt"), "demo", beam_file, "--out", out, *targets)
    assert demo.process.wait(START) == 0, demo.output.read_text()
    assert "beam, " in demo.output.read_text()
    return out


def test_it_leaves_log_report_and_targets(folder: Path) -> None:
    for name in (LOG, REPORT, FIGURE, TARGETS):
        assert (folder / name).stat().st_size > 1000
    report = json.loads((folder / REPORT).read_text())
    assert report["robot"] == "beam"
    assert (
        report["following"] > report["rate_hz"]
    )  # for a second; 20 Hz unless the computer is too busy
    assert report["complete"]
    targets = report["health"]["targets"]  # on a busy machine a target can be too old on arrival
    assert targets["refused"] == targets.get("refused_too_old", "0")
    assert set(report["statuses"]) == {"OK"}
    assert 0.0 < max(peak["position"] for peak in report["peaks"]) < 1.1 * 0.3 * 0.02


@pytest.mark.realtime
def test_it_follows_the_whole_path(folder: Path) -> None:
    report = json.loads((folder / REPORT).read_text())
    # targets are where the cables can take the tip, so model and plant get there
    assert report["model_error"]["rms_mm"] < 0.5
    assert report["plant_error"]["rms_mm"] < 1.0
    assert max(peak["position"] for peak in report["peaks"]) == pytest.approx(0.3 * 0.02, rel=0.1)


def test_its_log_replays_exactly(folder: Path) -> None:
    result = replay(folder / LOG, tolerance=1e-9, recorded_paths=True)
    assert result.same, result
    report = json.loads((folder / REPORT).read_text())
    assert result.ticks >= report["following"] > report["rate_hz"]


def test_a_simulated_robot_that_does_not_keep_up_is_noted(folder: Path) -> None:
    run = read_run(folder / LOG)
    time = run.time[0] + np.arange(40) / run.description.rate
    values = run.plant.value[:1].repeat(40, axis=0)
    assert slow_plant(replace(run, plant=Series(time, values))) == []
    (said,) = slow_plant(replace(run, plant=Series(time[::3], values[::3])))
    assert "33 % of its periods" in said


@pytest.mark.long
def test_its_folder_opens_at_a_colleague_s(folder: Path, tmp_path: Path) -> None:
    """Robot file and mesh lay elsewhere: replay and view refused the log."""
    there = shutil.copytree(folder, tmp_path / "there")
    assert (there / "beam.toml").is_file()
    assert (there / "beam.vtu").is_file()
    log = there / LOG
    assert replay(log, tolerance=1e-9).same
    shares = list[float]()
    count = export_log(
        log, tmp_path / "run.html", StopFlag(), lambda share, _: shares.append(share)
    )
    assert count > 10
    assert 0.9 < sum(shares) < 1.0  # the rest is the time in which the file is written
    assert len(shares) >= count, "a log was exported without a progress bar"


@pytest.mark.long
def test_an_export_of_its_log_ends_with_ctrl_c(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The whole log was replayed first, as long as it took; the page has what there is."""
    stop, usual = StopFlag(), RecordedRobot.frames

    def frames(recorded: RecordedRobot) -> Iterator[ViewFrame | None]:
        for number, frame in enumerate(usual(recorded)):
            if number == 5:
                stop.request()
            assert number < 6, "after the request"
            yield frame

    monkeypatch.setattr(RecordedRobot, "frames", frames)
    html = tmp_path / "run.html"
    silent = stop, lambda _share, _what: None
    assert 0 < export_log(folder / LOG, html, *silent, recorded_paths=True) <= 5
    assert html.stat().st_size > 1000


@pytest.mark.long
def test_a_demo_without_one_good_decision_fails_and_names_the_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("tauten.service.cli.runs.sys", SimpleNamespace(platform="other"))
    monkeypatch.setattr(
        "tauten.service.plant.processes._start", forked
    )  # this process has sessions
    robot = hanging_beam(tmp_path, tension=1e-4, young=3e3)
    out = tmp_path / "demo"
    assert run_main("demo", robot, "--path", "line", "--seconds", 1, "--out", out) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "no decision was OK" in said
    assert "tendon" in said
    assert (out / REPORT).is_file()


def test_a_folder_that_another_demo_writes_into_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two demos that began in the same second had one folder, and a log that could not be read."""
    robot, out = hanging_beam(tmp_path), tmp_path / "demo"
    out.mkdir()
    with alone_in(out):
        assert run_main("demo", robot, "--seconds", 1, "--out", out) == 2
    assert f"{out}: another process writes to it" in capsys.readouterr().err
    assert not list(out.iterdir())
    with alone_in(out):
        pass  # free again


@pytest.mark.long
def test_targets_are_slowed_where_the_period_cannot_be_held(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The period of 10 ms is held well, but a node that takes 20 ms for a step would say so."""
    monkeypatch.setattr("tauten.service.plant.processes._start", forked)
    monkeypatch.setattr("tauten.service.plant.demo.step_at_start", lambda *_: 0.02)
    robot = hanging_beam(tmp_path, rate=100.0)
    settings = DemoSettings(str(robot), tmp_path / "demo", 1.0, path="line", period=1.5)
    done = run_demo(settings, StopFlag(), lambda _said: None)
    note = [said for said in done.notes if "times slower; tauten reduce" in said][-1]
    slower = float(note.split(" times slower")[0].split()[-1])
    assert done.report.rate_hz <= 25.0
    assert done.report.following > 5
    times = np.loadtxt(tmp_path / "demo" / TARGETS, delimiter=",", skiprows=1)[:, 0]
    assert times[-1] == pytest.approx(1.5 * slower, rel=0.05)


@pytest.mark.long
def test_a_time_of_a_step_that_is_unknown_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tauten.service.plant.processes._start", forked)
    monkeypatch.setattr("tauten.service.plant.demo.step_at_start", lambda *_: float("nan"))
    monkeypatch.setattr("tauten.service.plant.demo._ANSWER", 0.0)
    settings = DemoSettings(str(hanging_beam(tmp_path)), tmp_path / "demo", 1.0, path="line")
    said: list[str] = []
    done = run_demo(settings, StopFlag(), said.append)
    assert "whether it holds 20 Hz is unknown" in done.notes[0]
    assert done.notes[0] in said


def test_it_stops_while_the_targets_that_can_be_reached_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That takes minutes where kernels are compiled first; it was ended only then."""
    stop = StopFlag()

    def found(*_: object) -> None:
        stop.request()
        raise AssertionError("a request to stop ends the search")

    monkeypatch.setattr("tauten.service.plant.processes._start", forked)
    monkeypatch.setattr("tauten.service.plant.demo.make_path", found)
    settings = DemoSettings(str(hanging_beam(tmp_path)), tmp_path / "demo", 1.0)
    with pytest.raises(DemoError, match="stopped before the node and the plant were ready"):
        run_demo(settings, stop, lambda _said: None)


def test_a_process_that_fails_is_named_with_its_last_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tauten.service.plant.processes._start", forked)
    with (
        pytest.raises(DemoError, match=r"tauten plant ended with 2: no robot 'nobody'"),
        child("plant", ["nobody"], tmp_path) as process,
    ):
        process.process.wait(START)
        process.check()


def test_a_process_gives_way_with_all_of_its_threads(tmp_path: Path) -> None:
    """Zenoh's threads were as urgent as the node's where only the first one had the lower priority."""
    with child("metrics", ["nobody_here"], tmp_path) as process:
        tasks = Path(f"/proc/{process.process.pid}/task")
        end = time.monotonic() + START
        while len(list(tasks.iterdir())) < 2:
            process.check()
            assert time.monotonic() < end
            time.sleep(0.05)
        process.give_way()
        own = os.getpriority(os.PRIO_PROCESS, 0)
        for task in tasks.iterdir():
            assert os.getpriority(os.PRIO_PROCESS, int(task.name)) > own
