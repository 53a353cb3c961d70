"""A run as a log: replayed exactly, reported right, drawn; and changes are found."""

from __future__ import annotations

import csv
import dataclasses
import json
import re
import shutil
import sys
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from support.processes import write_robot
from support.recorded_run import HEAVY, LAG, TICKS, doctored, with_entry

from tauten.controller import Status
from tauten.controller.qpcc import read_qpcc, solve_qpcc
from tauten.model import ActuatorKind, Robot, load_robot
from tauten.service.cli import main
from tauten.service.codec.messages import POINT
from tauten.service.log import Entry, LogError, LogReader, LogRecorder, logged_description
from tauten.service.plots import draw_replay, draw_run
from tauten.service.replay import (
    make_report,
    read_run,
    replay,
    table_rows,
    write_problem,
    write_report,
)
from tauten.service.replay.replay_report import TICKS as TABLE
from tauten.service.replay.replay_report import VERDICT
from tauten.service.wire import (
    CDR,
    JOINTS,
    TICK,
    Joints,
    Positions,
    Tick,
    decode_joints,
    decode_tick,
    encode_tick,
)


def test_a_replay_on_the_same_robot_is_exact(log: Path) -> None:
    result = replay(log, tolerance=0.0)
    assert result.same
    assert result.ticks == TICKS + 20
    np.testing.assert_array_equal(result.position, 0.0)
    np.testing.assert_array_equal(result.effort, 0.0)
    assert result.statuses == 0
    assert result.notes == ()


def test_a_stiffer_robot_is_found_out(log: Path, tmp_path: Path) -> None:
    text = HEAVY.replace("young_modulus = 1e6", "young_modulus = 1.1e6")
    result = replay(log, tolerance=1e-4, against=str(write_robot(tmp_path, text)))
    assert not result.same
    assert result.effort.max() > 0.01
    assert "robot digest has changed" in result.notes
    # and a tolerance that wide accepts it
    assert replay(log, 1.0, str(tmp_path / "beam.toml")).same


def test_a_replay_says_before_it_begins_that_the_robot_has_changed(
    log: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Of other effectors it said, after a minute, how many goals a tick has."""
    shutil.copy(log, tmp_path)
    write_robot(tmp_path, HEAVY[: HEAVY.rindex("[[effectors]]")])
    with pytest.raises(LogError, match="goals for 2 effectors, the robot has 1"):
        replay(tmp_path / log.name, tolerance=0.0)
    assert "the robot has changed since the log was made" in caplog.text


def test_a_log_that_was_cut_is_replayed_as_far_as_it_goes(log: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    data = log.read_bytes()
    cut.write_bytes(data[: int(0.6 * len(data))])
    result = replay(cut, tolerance=0.0, recorded_paths=True)
    assert result.same
    assert 0 < result.ticks < TICKS + 20
    assert result.notes == ("the log was cut short",)


def test_a_log_of_another_robot_does_not_fit(log: Path, tmp_path: Path) -> None:
    other = write_robot(tmp_path, HEAVY.replace('name = "upper"', 'name = "top"'))
    with pytest.raises(LogError, match="does not fit the robot: found cables"):
        replay(log, 1e-4, str(other))


@pytest.mark.parametrize(
    ("missing", "sentence"),
    [
        (range(17, 18), "ticks 17 to 17 are missing$"),
        (range(5), "ticks 0 to 4 are missing$"),
    ],
)
def test_missing_ticks_are_noticed(
    missing: range, sentence: str, log: Path, beam_file: Path, tmp_path: Path
) -> None:
    holed = tmp_path / "holed.mcap"
    reader = LogReader(log)
    messages = list(reader.messages())
    recorder = LogRecorder(holed, reader.metadata)
    kinds = {"actuation": JOINTS, "tick": TICK}
    for message in messages:
        kind = kinds.get(message.key.rsplit("/", 1)[1])
        if kind is not None and message.sequence not in missing:
            recorder.write(Entry(message.key, kind, message.payload, 1, 1, message.sequence))
    recorder.close()
    with pytest.raises(LogError, match=sentence):
        replay(holed, 1e-4, recorded_paths=True)


def test_a_log_of_a_recorder_beside_the_node_is_not_replayed(
    log: Path, beam_file: Path, tmp_path: Path
) -> None:
    """It has ticks and actuations in the order in which they arrived: not that in which they left."""
    described = {"description": LogReader(log).read_metadata()["description"]}
    beside = doctored(log, tmp_path / "beside.mcap", described)
    for against in (None, str(beam_file)):
        with pytest.raises(LogError, match=r"a log of tauten record.* cannot be replayed"):
            replay(beside, 1e-4, against)


def test_a_robot_whose_file_is_gone_is_looked_up_by_name(log: Path, tmp_path: Path) -> None:
    """Where no shipped robot has the name, the file is what is missing."""
    reader = LogReader(log)
    metadata = {**reader.read_metadata(), "robot_path": str(tmp_path / "gone.toml")}
    recorder = LogRecorder(tmp_path / "log.mcap", metadata)
    recorder.close()
    with pytest.raises(ValueError, match=r"gone.toml, which is neither beside the log nor where"):
        replay(tmp_path / "log.mcap", 1e-4)


def test_the_report_has_the_numbers_of_the_run(log: Path) -> None:
    run = read_run(log)
    report = make_report(run)
    following = TICKS - 10 - 5
    assert report.ticks == report.following == following
    assert report.achieved_hz == pytest.approx(50.0)
    assert (report.missed, report.skipped) == (1, 2)
    decided = 5e-3 + 1e-4 * np.arange(5, TICKS - 10)
    assert report.step_ms.p50 == pytest.approx(1e3 * float(np.percentile(decided, 50)))
    assert report.step_ms.p99 == pytest.approx(1e3 * float(np.percentile(decided, 99)))
    assert report.step_ms.max == pytest.approx(1e3 * decided[-1])
    assert report.latency_ms.max == pytest.approx(2.0)
    # the errors, from the log's own arrays
    goal, model = run.goal[5 : TICKS - 10], run.model.value[5 : TICKS - 10]
    distance = np.linalg.norm(model - goal, axis=1)
    assert report.model_error.max_mm == pytest.approx(1e3 * distance.max())
    assert report.model_error.rms_mm == pytest.approx(1e3 * np.sqrt(np.mean(distance**2)))
    below = np.linalg.norm(model - [0.0, 0.0, LAG] - goal, axis=1)
    assert report.plant_error.max_mm == pytest.approx(1e3 * below.max())
    assert report.model_plant_error.rms_mm == pytest.approx(1e3 * LAG)
    assert report.plant_penetration_mm == pytest.approx(1e-1 * (TICKS + 19) - 2.0)
    assert report.modes == {"idle": 5, "run": following, "hold": 10, "stop": 20}
    upper = report.peaks[1]
    assert (upper.name, upper.kind, upper.position_unit) == ("upper", "cable", "m")
    assert upper.position == pytest.approx(run.position.value[:, 1].max())
    assert upper.effort == pytest.approx(run.effort.value[:, 1].max())
    assert report.complete


def test_the_report_is_saved_and_shown(log: Path, beam: Robot, tmp_path: Path) -> None:
    report = make_report(read_run(log))
    report.save(tmp_path / "report.json")
    found = json.loads((tmp_path / "report.json").read_text())
    assert found == json.loads(json.dumps(report.as_dict()))
    assert found["description"]["model"]["digest"] == beam.digest
    rows = dict(table_rows(report))
    assert rows["deadlines missed / ticks"] == f"1 / {TICKS - 15}"
    assert rows["plant against model, RMS / max"] == "1.00 / 1.00 mm"


@pytest.mark.long
def test_the_figure_is_drawn(log: Path, beam: Robot, tmp_path: Path) -> None:
    draw_run(read_run(log), beam.actuators, tmp_path / "figure.png")
    data = (tmp_path / "figure.png").read_bytes()
    assert data.startswith(b"\x89PNG")
    draw_run(read_run(log), beam.actuators, tmp_path / "figure.svg")
    text = (tmp_path / "figure.svg").read_text()
    assert "<svg" in text


@pytest.mark.long
def test_actuators_of_other_units_have_other_axes(log: Path, beam: Robot, tmp_path: Path) -> None:
    """One axis for millimetres and degrees hid the smaller numbers, and its label named no unit."""
    kinds = (ActuatorKind.CABLE, ActuatorKind.DRIVE)
    draw_run(
        read_run(log), dataclasses.replace(beam.actuators, kinds=kinds), tmp_path / "mixed.svg"
    )
    draw_run(read_run(log), beam.actuators, tmp_path / "cables.svg")
    labels = [
        [part.split(" -->")[0] for part in (tmp_path / name).read_text().split("<!-- ")[1:]]
        for name in ("mixed.svg", "cables.svg")
    ]
    for label in ("pull [mm]", "angle [deg]", "tension [N]", "torque [N mm]"):
        assert labels[0].count(label) == 1
    for label in ("pull [mm]", "tension [N]", "upper", "lower"):
        assert labels[1].count(label) == 1


@pytest.mark.long
def test_a_run_without_plant_is_reported_too(log: Path, beam: Robot, tmp_path: Path) -> None:
    reader = LogReader(log)
    messages = list(reader.messages())
    recorder = LogRecorder(tmp_path / "log.mcap", reader.metadata)
    kinds = {"actuation": JOINTS, "tick": TICK, "effector": POINT}
    for m in messages:
        if "plant" not in m.key:
            kind = kinds[m.key.rsplit("/", 1)[1]]
            recorder.write(Entry(m.key, kind, m.payload, m.logged, m.logged, m.sequence))
    recorder.close()
    run = read_run(tmp_path / "log.mcap")
    report = make_report(run)
    assert report.plant_error.rms_mm is None
    assert report.plant_penetration_mm is None
    assert f"{report.model_penetration_mm:g}" == "0"  # it was -0
    draw_run(run, beam.actuators, tmp_path / "figure.png")


def test_the_robot_file_is_in_the_log(log: Path, beam_file: Path, tmp_path: Path) -> None:
    metadata = LogReader(log).read_metadata()
    shutil.copy(beam_file.parent / "beam.vtu", tmp_path)
    (tmp_path / "again.toml").write_text(metadata["robot_file"])
    recorded = logged_description(log, metadata)
    assert load_robot(tmp_path / "again.toml").digest == recorded.model.digest


@pytest.mark.long
def test_a_report_shows_every_tick_and_the_difference(log: Path, tmp_path: Path) -> None:
    text = HEAVY.replace("young_modulus = 1e6", "young_modulus = 1.1e6")
    result = replay(log, tolerance=1e-4, against=str(write_robot(tmp_path, text)))
    write_report(result, "log.mcap", tmp_path / "out")
    verdict = json.loads((tmp_path / "out" / VERDICT).read_text())
    assert verdict["same"] is False
    assert verdict["actuators"]["upper"]["tension"] == pytest.approx(result.effort[1])
    assert verdict["notes"] == list(result.notes)
    rows = list(csv.DictReader((tmp_path / "out" / TABLE).read_text().splitlines()))
    assert len(rows) == result.ticks
    worst = rows[result.worst_tick]
    off = float(worst["tension upper replayed"]) - float(worst["tension upper recorded"])
    assert abs(off) == pytest.approx(result.effort[1], rel=1e-6)
    draw_replay(result, "log.mcap", tmp_path / "out" / "replay.png")
    assert (tmp_path / "out" / "replay.png").read_bytes().startswith(b"\x89PNG")
    assert result.speed > 0.0


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ("robot", None, "robot: Field required"),
        ("rate", None, "rate: Field required"),
        ("basis", None, "basis: Field required"),
        ("rate", 0, "rate: Input should be greater than 0"),
        ("rate", 1e5, "rate: Input should be less than or equal to 10000"),
        ("rate", "fast", "rate: Input should be a valid number"),
        ("robot", "../beam.toml", "robot: String should match pattern"),
        ("effectors.0.kind", "hand", "effectors.0.kind: Input should be 'point'"),
        ("effectors.0.weight", [1, 1], "Value error, a point has 3 weights, found 2"),
        ("model.order", "other", "model.order: Input should be 'full' or 'reduced'"),
        ("basis.name", "/elsewhere/x.basis", "/elsewhere/x.basis, which is not beside the log"),
        ("basis.name", "a\0b.basis", "a path has a zero byte"),
    ],
)
def test_a_doctored_description_is_refused_with_a_sentence(
    log: Path,
    place: str,
    value: object,
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    metadata = LogReader(log).read_metadata()
    metadata["description"] = with_entry(metadata["description"], place, value)
    path = doctored(log, log.parent / "doctored.mcap", metadata)
    with pytest.raises(LogError, match=re.escape(message)):
        replay(path, 1e-4)
    monkeypatch.setattr(sys, "argv", ["tauten", "replay", str(path)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("tauten: ")
    assert message in said.replace("\n", " ")


def test_a_log_without_a_description_is_refused_with_a_sentence(log: Path) -> None:
    metadata = LogReader(log).read_metadata()
    del metadata["description"]
    with pytest.raises(LogError, match="its metadata have no 'description'"):
        replay(doctored(log, log.parent / "doctored.mcap", metadata), 1e-4)


@pytest.mark.parametrize(
    ("goal", "correction", "message"),
    [
        ("keep", ((0.0, 0.0, 0.0),), "tick 10: corrections for 1 effectors, the robot has 2"),
        ("keep", ((0.0, 0.0, 0.0),) * 3, "tick 10: corrections for 3 effectors, the robot has 2"),
        ("keep", ((0.0, 0.0, np.inf),) * 2, "tick 10: corrections that are not finite"),
        ((), ((0.0, 0.0, 0.0),) * 2, "tick 10: a correction without a goal"),
        (((np.nan, 0.0, 0.0),) * 2, (), "tick 10: goals that are not finite"),
        (((0.0, 0.0, 0.0),), (), "tick 10: goals for 1 effectors, the robot has 2"),
    ],
)
def test_a_doctored_tick_is_refused_with_a_sentence(
    log: Path, goal: Positions | str, correction: Positions, message: str
) -> None:
    reader, path = LogReader(log), log.parent / "doctored.mcap"
    messages = list(reader.messages())
    recorder = LogRecorder(path, reader.metadata)
    for m in messages:
        kind = {"actuation": JOINTS, "tick": TICK}.get(m.key.rsplit("/", 1)[1])
        if kind is None:
            continue
        payload, tick = m.payload, decode_tick(m.payload) if kind == TICK else None
        if isinstance(tick, Tick) and tick.index == 10:
            kept = tick.goal if isinstance(goal, str) else goal
            doctored = dataclasses.replace(
                tick,
                goal=kept,
                correction=correction,
                goal_values=tuple(chain(*kept)),
                correction_values=tuple(chain(*correction)),
            )
            payload = encode_tick(doctored)
        recorder.write(Entry(m.key, kind, payload, m.logged, m.logged, m.sequence))
    recorder.close()
    with pytest.raises(LogError, match=re.escape(message)):
        replay(path, 1e-4)


def test_files_that_are_not_beside_the_log_are_opened_on_request_only(
    log: Path, tmp_path: Path
) -> None:
    path = doctored(log, tmp_path / "log.mcap", LogReader(log).read_metadata())
    with pytest.raises(LogError, match="which is not beside the log"):
        replay(path, 1e-4)
    assert replay(path, 0.0, recorded_paths=True).same
    shutil.copy(log.parent / "beam.toml", tmp_path)
    shutil.copy(log.parent / "beam.vtu", tmp_path)
    assert replay(path, 0.0).same


def test_one_flipped_byte_is_not_a_shorter_run(log: Path) -> None:
    data, path = bytearray(log.read_bytes()), log.parent / "flipped.mcap"
    data[len(data) // 3] ^= 0x10
    path.write_bytes(data)
    with pytest.raises(LogError, match="damaged near byte"):
        replay(path, 1e-4)
    with pytest.raises(LogError, match="damaged near byte"):
        read_run(path)


def test_the_problem_of_a_tick_is_written_and_solved_alike(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "tick.npz"
    write_problem(log, 30, file)
    problem, start = read_qpcc(file)
    solution = solve_qpcc(problem, start)
    assert solution.status is Status.OK
    messages = LogReader(log).messages()
    joints = [
        decode_joints(m.payload, CDR, ("lower", "upper"))
        for m in messages
        if m.key.endswith("actuation")
    ]
    recorded = joints[30]
    assert isinstance(recorded, Joints)
    # the tick is on the way to what the problem decides over the horizon
    np.testing.assert_allclose(solution.lam_a, recorded.effort, rtol=0.05, atol=1e-9)
    monkeypatch.setattr(sys, "argv", ["tauten", "solve", str(file)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    assert "status           OK" in capsys.readouterr().out
    with pytest.raises(LogError, match="tick 1000 is not in the log"):
        write_problem(log, 1000, tmp_path / "none.npz")
