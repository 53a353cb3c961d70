"""Logs: what is written is read back, also when the file was cut or damaged."""

import errno
import resource
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from support.messages import Point, decoded_by_mcap, encode_point

from tauten.service.codec.messages import POINT
from tauten.service.log import Entry, LogError, LogReader, LogRecorder
from tauten.service.wire import (
    CLOUD,
    FLOAT,
    JOINTS,
    LARGEST_CLOUD,
    Joints,
    encode_float,
    encode_joints,
)

METADATA = {"robot": "finger", "robot_file": 'name = "finger"\n'}


def write_log(path: Path, count: int, close: bool = True) -> LogRecorder:
    recorder = LogRecorder(path, METADATA)
    for tick in range(count):
        joints = Joints(tick, "base", ("a", "b"), (0.001 * tick, 0.0), (1.0, 2.0))
        point = Point(tick, "base", (0.1, 0.2, tick))
        for key, kind, payload in (
            ("tauten/finger/measurement", POINT, encode_point(point)),
            ("tauten/finger/target", POINT, encode_point(point)),
            ("tauten/finger/actuation", JOINTS, encode_joints(joints)),
            ("tauten/finger/plant/gap", FLOAT, encode_float(-0.5 * tick)),
        ):
            recorder.write(Entry(key, kind, payload, 10**9 + tick, 10**9 + tick, tick))
    if close:
        recorder.close()
    return recorder


def test_a_log_comes_back_in_order(tmp_path: Path) -> None:
    write_log(tmp_path / "sub" / "log.mcap", 100)
    reader = LogReader(tmp_path / "sub" / "log.mcap")
    messages = list(reader.messages())
    assert reader.metadata == METADATA
    assert reader.complete
    assert [message.sequence for message in messages] == np.repeat(np.arange(100), 4).tolist()
    assert {message.encoding for message in messages} == {"cdr"}
    assert messages[1].payload == encode_point(Point(0, "base", (0.1, 0.2, 0.0)))


def test_a_file_that_another_recorder_writes_is_refused_and_stays_whole(tmp_path: Path) -> None:
    """Two nodes that recorded to one file wrote over each other, and nothing of it could be read."""
    path = tmp_path / "log.mcap"
    first = write_log(path, 3, close=False)
    with pytest.raises(OSError, match="another process writes to it"):
        LogRecorder(path, {"robot": "other"})
    first.close()
    reader = LogReader(path)
    assert len(list(reader.messages())) == 12 and reader.metadata == METADATA
    write_log(path, 1)
    assert len(list(LogReader(path).messages())) == 4, "a later one replaces it"


def test_the_mcap_libraries_own_ros_2_reader_decodes_it(tmp_path: Path) -> None:
    write_log(tmp_path / "log.mcap", 3)
    found = decoded_by_mcap(tmp_path / "log.mcap")
    assert [kind for _, kind, _ in found] == [POINT, POINT, JOINTS, FLOAT] * 3
    topic, _, message = found[-2]
    assert (topic, message.name) == ("/tauten/finger/actuation", ["a", "b"])
    assert message.position == pytest.approx([0.002, 0.0])


def test_the_largest_cloud_is_read(tmp_path: Path) -> None:
    """Its chunk was larger than what the reader took for a damaged one."""
    path = tmp_path / "log.mcap"
    cloud = np.random.default_rng(0).bytes(LARGEST_CLOUD)  # which no compression makes smaller
    recorder = LogRecorder(path, METADATA)
    for key, payload in (("contacts", cloud), ("open_contacts", b"cloud")):
        recorder.write(Entry(f"tauten/finger/{key}", CLOUD, payload, 1, 1, 0))
    recorder.close()
    assert [message.payload for message in LogReader(path).messages()] == [cloud, b"cloud"]


def test_json_of_an_older_log_is_told_from_cdr(tmp_path: Path) -> None:
    """Logs had commands and targets as they had come."""
    path = tmp_path / "log.mcap"
    with path.open("wb") as file:
        writer = Writer(file, enable_data_crcs=True)
        writer.start(profile="ros2", library="tauten")
        writer.add_metadata("tauten", METADATA)
        channel = writer.register_channel("/tauten/finger/command", "json", schema_id=0)
        writer.add_message(channel, 1, b'{"data": "hold"}', 1)
        writer.finish()  # type: ignore[no-untyped-call]
    (message,) = LogReader(path).messages()
    assert (message.key, message.encoding) == ("tauten/finger/command", "json")


@pytest.mark.long
@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.999])
def test_a_log_that_was_cut_is_read_up_to_the_cut(tmp_path: Path, share: float) -> None:
    path = tmp_path / "log.mcap"
    write_log(path, 2000)
    whole = list(LogReader(path).messages())
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    reader = LogReader(path)
    messages = list(reader.messages())
    assert not reader.complete
    assert reader.metadata == METADATA
    assert messages == whole[: len(messages)]
    assert len(messages) > 0.7 * share * len(whole) - 500


def test_damage_in_the_middle_is_an_error_after_what_comes_before(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    write_log(path, 2000)
    whole = list(LogReader(path).messages())
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 64] = bytes(64)
    path.write_bytes(data)
    reader, messages = LogReader(path), []
    with pytest.raises(LogError, match=r"log\.mcap: damaged near byte"):
        for message in reader.messages():
            messages.append(message)
    assert not reader.complete
    assert 0 < len(messages) < len(whole)
    assert messages == whole[: len(messages)]


@pytest.mark.parametrize("content", [b"", b"hello", b"\x89MCAP0\r\n", bytes(1000)])
def test_what_is_no_log_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(content)
    with pytest.raises(LogError, match="not the log of a run"):
        list(LogReader(path).messages())
    with pytest.raises(LogError, match="cannot be read"):
        list(LogReader(tmp_path / "none.mcap").messages())


def test_a_full_disk_stops_the_log_and_nothing_else(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(OSError) as caught:  # said at once when nothing at all can be written
        LogRecorder(Path("/dev/full"), METADATA)
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, "/dev/full")
    path = tmp_path / "log.mcap"
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, hard))  # files cannot grow beyond this
    try:
        recorder = write_log(path, 5000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert recorder.fault == f"recording stopped: {path}: File too large"
    assert recorder.dropped > 0
    assert "recording stopped" in caplog.text
    assert len(list(LogReader(path).messages())) > 100
