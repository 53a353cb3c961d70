"""Damaged and doctored logs: a result or a `LogError`, never part of a run without a word."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from support.messages import Point, encode_point
from support.recorded_run import with_entry

from tauten.service.codec.messages import POINT
from tauten.service.describing import log_metadata
from tauten.service.frames import RecordedRobot
from tauten.service.log import Entry, LogError, Logged, LogReader, LogRecorder
from tauten.service.replay import make_report, read_run, replay, table_rows
from tauten.service.setup import load_setup
from tauten.service.view.words import frame_in_words
from tauten.service.wire import (
    JOINTS,
    TICK,
    Cause,
    Joints,
    Keys,
    Mode,
    Tick,
    decode_tick,
    encode_joints,
    encode_tick,
)

KEYS = Keys("beam")
CABLES = ("lower", "upper")
ODD = (0.0, -1.0, 1e300, -1e300, np.nan, np.inf, -np.inf, 5e-324)
TEXTS = (
    "",
    "0",
    "-1",
    "nan",
    "1e400",
    "beam",
    "finger",
    "../beam",
    "/etc/passwd",
    "\0",
    "x" * 9999,
)


def entries(ticks: int, change: random.Random | None = None) -> list[Entry]:
    """Messages of a run; with random numbers some of their values are wrong."""

    def number(value: float) -> float:
        return value if change is None or change.random() > 0.03 else change.choice(ODD)

    def count(value: int) -> int:
        return value if change is None or change.random() > 0.03 else change.randrange(4)

    def positions() -> tuple[tuple[float, float, float], ...]:
        return tuple((number(0.1), number(0.01), number(0.01)) for _ in range(count(2)))

    found = []
    for index in range(ticks):
        stamp = 10**18 + 20_000_000 * index
        follows = index % 7 != 0
        goal = positions() if follows else ()
        correction = positions() if change and change.random() < 0.1 else ()
        tick = Tick(
            stamp, "beam_base", count(index) if change else index, Mode.RUN if follows else Mode.HOLD,
            Cause.NONE, "OK" if follows else "", goal, correction, stamp, number(1e-4), number(2e-3),
            number(1e-3), number(5e-3), number(1e-2), 0, number(1e-3), number(0.0), number(0.0), 0, False,
            tuple(chain(*goal)), tuple(chain(*correction)),
        )  # fmt: skip
        position = tuple(number(1e-4 * index) for _ in range(count(2)))
        joints = Joints(stamp, "beam_base", CABLES[: count(2)], position, (1.0,) * count(2))
        effector = Point(stamp, "beam_base", (number(0.1), 0.01, 0.01))
        for key, kind, payload in (
            (KEYS.actuation, JOINTS, encode_joints(joints)),
            (KEYS.effectors(("",))[0], POINT, encode_point(effector)),
            (KEYS.tick, TICK, encode_tick(tick)),
        ):
            if change is not None and change.random() < 0.01:
                payload = change.randbytes(change.randrange(60))
            found.append(Entry(key, kind, payload, stamp, stamp, index))
    return found


def write(path: Path, metadata: dict[str, str], messages: list[Entry]) -> None:
    recorder = LogRecorder(path, metadata)
    for message in messages:
        recorder.write(message)
    recorder.close()


def read(path: Path) -> tuple[list[Logged], dict[str, str]]:
    reader = LogReader(path)
    messages = list(reader.messages())
    return messages, reader.metadata


@pytest.fixture(scope="module")
def metadata(beam_file: Path) -> dict[str, str]:
    """Of a log of the small robot, which lies beside its file."""
    return {**log_metadata(load_setup(beam_file)), "robot_path": "beam.toml"}


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory, metadata: dict[str, str]) -> Path:
    path = tmp_path_factory.mktemp("fuzz") / "log.mcap"
    write(path, metadata, entries(150))
    return path


def check_flips(original: Path, places: list[int], bits: random.Random) -> None:
    data, path = original.read_bytes(), original.with_name("flipped.mcap")
    whole = read(original)
    for place in places:
        damaged = bytearray(data)
        damaged[place] ^= 1 << bits.randrange(8)
        path.write_bytes(damaged)
        try:
            found = read(path)
        except LogError as error:
            assert str(path) in str(error)
        else:  # a byte that carries nothing of the run
            assert found == whole, place


def test_a_flipped_bit_is_found_or_changes_nothing(original: Path) -> None:
    size, chosen = original.stat().st_size, random.Random(1)
    check_flips(original, sorted(chosen.sample(range(size), 200)), chosen)


@pytest.mark.slow
def test_every_flipped_byte_is_found_or_changes_nothing(original: Path) -> None:
    check_flips(original, list(range(original.stat().st_size)), random.Random(2))


def check_cuts(original: Path, sizes: list[int]) -> None:
    data, path = original.read_bytes(), original.with_name("cut.mcap")
    whole, metadata = read(original)
    for size in sizes:
        path.write_bytes(data[:size])
        try:
            found, facts = read(path)
        except LogError as error:
            assert "not the log of a run" in str(error), size  # cut within the metadata
            assert size < 400 + sum(map(len, metadata.values()))
        else:
            assert facts == metadata
            assert found == whole[: len(found)], size
            assert not LogReader(path).complete


def test_a_cut_log_is_a_beginning_of_the_run(original: Path) -> None:
    size = original.stat().st_size
    check_cuts(original, random.Random(3).sample(range(size), 200))


@pytest.mark.slow
def test_a_log_cut_anywhere_is_a_beginning_of_the_run(original: Path) -> None:
    check_cuts(original, list(range(original.stat().st_size)))


def check_doctored(folder: Path, sound: dict[str, str], seeds: range) -> int:
    """Reports of logs whose checksums are right and whose content is wrong; counts the results."""
    reported = 0
    for seed in seeds:
        change, path = random.Random(seed), folder / "doctored.mcap"
        metadata = dict(sound)
        if change.random() < 0.3:
            place = change.choice(("robot", "rate", "start", "basis.name", "actuators.1.kind"))
            description = with_entry(metadata["description"], place, change.choice(TEXTS))
            metadata["description"] = description
        write(path, metadata, entries(change.randrange(12), change))
        try:
            run = read_run(path)
        except LogError:
            continue
        with np.errstate(all="ignore"):  # positions of 1e300 m overflow
            report = make_report(run)
            json.dumps(report.as_dict(), allow_nan=False)
            assert table_rows(report)
        reported += 1
    return reported


@pytest.mark.long
def test_a_doctored_log_is_reported_or_refused(tmp_path: Path, metadata: dict[str, str]) -> None:
    assert check_doctored(tmp_path, metadata, range(100)) > 10


@pytest.mark.slow
def test_many_doctored_logs_are_reported_or_refused(
    tmp_path: Path, metadata: dict[str, str]
) -> None:
    assert check_doctored(tmp_path, metadata, range(1000, 4000)) > 300


def check_replays(beam_file: Path, folder: Path, metadata: dict[str, str], seeds: range) -> int:
    """Replays of doctored logs beside their robot; counts the results."""
    replayed = 0
    for name in ("beam.toml", "beam.vtu"):
        (folder / name).write_bytes((beam_file.parent / name).read_bytes())
    for seed in seeds:
        change, path = random.Random(seed), folder / "doctored.mcap"
        write(path, metadata, entries(1 + change.randrange(4), change))
        try:
            with np.errstate(all="ignore"):
                result = replay(path, 1e-4)
        except LogError:
            continue
        assert result.ticks > 0
        replayed += 1
    return replayed


@pytest.mark.long
def test_a_doctored_log_is_replayed_or_refused(
    beam_file: Path, tmp_path: Path, metadata: dict[str, str]
) -> None:
    assert check_replays(beam_file, tmp_path, metadata, range(12)) > 0


@pytest.mark.slow
def test_many_doctored_logs_are_replayed_or_refused(
    beam_file: Path, tmp_path: Path, metadata: dict[str, str]
) -> None:
    assert check_replays(beam_file, tmp_path, metadata, range(100, 500)) > 20


MARKUP = "<img src=x onerror=stop()>"


def marked(messages: list[Entry], change: random.Random) -> list[Entry]:
    """Messages of a run of which one tick has markup as its status."""
    place = change.choice([i for i, one in enumerate(messages) if one.kind == TICK])
    tick = decode_tick(messages[place].payload)
    assert isinstance(tick, Tick)
    payload = encode_tick(replace(tick, status=MARKUP))
    return [replace(one, payload=payload) if i == place else one for i, one in enumerate(messages)]


def test_a_doctored_log_shows_no_markup(
    beam_file: Path, tmp_path: Path, metadata: dict[str, str]
) -> None:
    """What the viewer would show of a log: of one in which markup is a status, nothing."""
    for name in ("beam.toml", "beam.vtu"):
        (tmp_path / name).write_bytes((beam_file.parent / name).read_bytes())
    path, refused, texts = tmp_path / "doctored.mcap", 0, []
    for seed in range(4):
        change = random.Random(seed)
        said = with_entry(metadata["description"], "model.digest", MARKUP)
        said = with_entry(said, "versions", {MARKUP: MARKUP})
        messages = entries(4)
        facts = {**metadata, "description": said}
        write(path, facts, messages if seed % 2 else marked(messages, change))
        try:
            recorded = RecordedRobot(path)
            for frame in recorded.frames():
                if frame is not None:
                    words = frame_in_words(recorded.look, frame, recorded.notes, advice=False)
                    texts.append(words.html)
        except LogError as error:
            assert "no status" in str(error)
            refused += 1
    assert refused == 2
    assert texts
    assert not any("<img" in text for text in texts)
