"""`tauten serve` as a process over real Zenoh: what it accepts, refuses, publishes and leaves."""

from __future__ import annotations

import json
import math
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import zenoh
from support.messages import Point, encode_point
from support.nodes import (
    PERIOD,
    check_limits,
    ordered,
    point_at,
    reached,
    recorded,
    send,
    send_until_followed,
    streaming,
    wait_health,
    wait_mode,
    wait_tip,
    whole,
)
from support.processes import START, Served, start

from tauten.model import Robot
from tauten.service.log import LogReader, logged_description
from tauten.service.wire import CDR, JSON, Cause, Mode, Tick, decode_tick

TIP = "tauten/beam/effector"


def test_it_follows_holds_and_releases(served: Served, beam: Robot) -> None:
    high, low = (reached(beam, position) for position in (0.004, 0.002))
    wait_mode(served, Mode.IDLE)
    with streaming(served, high):
        wait_tip(served, TIP, high, 1e-3)
    with streaming(served, low, json=True):
        wait_tip(served, TIP, low, 5e-4)
    wait_mode(served, Mode.HOLD, Cause.NO_TARGET)
    assert served.process.end() == 0
    ticks, joints, tips = recorded(served.log, beam)
    reader = LogReader(served.log)
    list(reader.messages())
    assert reader.complete
    assert logged_description(served.log, reader.metadata).model.digest == beam.digest
    assert reader.metadata["robot_file"].startswith('name = "beam"')
    assert len(ticks) == len(joints)
    assert whole(ticks)
    modes = [tick.mode for tick in ticks]
    assert ordered(modes)[:2] == [Mode.IDLE, Mode.RUN]
    assert ordered(modes)[-2:] == [Mode.HOLD, Mode.STOP]
    assert {tick.status for tick in ticks if tick.mode is Mode.RUN} == {"OK"}
    assert modes.count(Mode.STOP) == 20  # the 0.4 s of the robot file
    # the model's tip got as high as the last target, and the hold kept it there
    held = tips[modes.index(Mode.STOP) - 1]
    assert held.xyz[2] == pytest.approx(low[2], abs=1e-3)
    check_limits(joints, beam)
    assert max(joint.position[1] for joint in joints) > 5e-4
    assert joints[-1].position == (0.0, 0.0)
    assert joints[-1].effort == (0.0, 0.0)


@pytest.mark.realtime
def test_ticks_are_a_period_apart_also_in_a_flood(served: Served, beam: Robot) -> None:
    send(served, beam, 0.008, 2.0)
    flood(served, beam, 5000)
    assert served.process.end() == 0
    ticks, _, _ = recorded(served.log, beam)
    gaps = np.diff([1e-9 * tick.stamp for tick in ticks])
    assert np.median(gaps) == pytest.approx(PERIOD, abs=2e-3)
    assert np.median([tick.lateness for tick in ticks]) < 2e-3


def test_a_flood_and_jumps_leave_no_actuation_out_of_limits(served: Served, beam: Robot) -> None:
    heard = served.session.declare_subscriber(served.keys.tick, zenoh.handlers.FifoChannel(10_000))
    followed, end = 0, time.monotonic() + 120.0
    while followed <= 10 and time.monotonic() < end:
        flood(served, beam, 1000)
        while (sample := heard.try_recv()) is not None:
            tick = decode_tick(bytes(sample.payload))
            followed += isinstance(tick, Tick) and tick.mode is Mode.RUN
    heard.undeclare()
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    assert sum(tick.mode is Mode.RUN for tick in ticks) > 10
    assert max(joint.position[1] for joint in joints) > 5e-4
    check_limits(joints, beam)
    assert whole(ticks)


def flood(served: Served, beam: Robot, count: int) -> None:
    """Send targets that jump, as fast as a network would carry them."""
    publisher = served.session.declare_publisher(
        served.keys.targets(("tip",))[0],
        encoding=CDR,
        congestion_control=zenoh.CongestionControl.BLOCK,
    )
    rng = np.random.default_rng(1)
    payloads = [encode_point(point_at(beam, z, stamp=0)) for z in rng.uniform(-0.1, 0.1, 1000)]
    for _ in range(count // 100):
        for payload in payloads[:100]:
            publisher.put(payload)
        rng.shuffle(payloads)
        time.sleep(0.005)


@pytest.mark.long
def test_a_killed_node_leaves_a_readable_log(served: Served, beam: Robot) -> None:
    send_until_followed(served, beam, 0.005, ticks=100)  # two seconds
    assert served.process.end(signal.SIGKILL) == -signal.SIGKILL
    reader = LogReader(served.log)
    ticks = [m for m in reader.messages() if m.key.endswith("/tick")]
    assert not reader.complete
    assert len(ticks) > 10  # at 50 Hz a chunk is less than a second


def test_a_second_node_is_refused(shared: Served, beam_file: Path, tmp_path: Path) -> None:
    second = start(tmp_path / "second.txt", "serve", beam_file, "--port", shared.port)
    assert second.process.wait(START) == 2
    last = second.output.read_text().strip().splitlines()[-1]
    assert last.startswith("tauten: port")
    assert "is another node of 'beam' running?" in last
    assert shared.process.process.poll() is None


def test_the_description_answers(shared: Served, beam: Robot) -> None:
    replies = list(shared.session.get(shared.keys.description, timeout=5.0))
    assert len(replies) == 1
    sample = replies[0].ok
    assert sample is not None
    found = json.loads(bytes(sample.payload))
    assert found["robot"] == "beam"
    assert found["frame"] == "beam_base"
    assert [cable["name"] for cable in found["actuators"]] == ["lower", "upper"]
    assert found["actuators"][0]["position"] == [0.0, 0.02]
    assert [e["target"] for e in found["effectors"]] == [
        "tauten/beam/target",
        "tauten/beam/target/middle",
    ]
    assert found["effectors"][0]["rest"] == pytest.approx(beam.effector(beam.rest())[0].tolist())
    assert found["model"]["digest"] == beam.digest


def test_rubbish_is_counted_and_moves_nothing(shared: Served, beam: Robot) -> None:
    """The last test of the shared node: it ends the node and judges its whole log."""
    key = shared.keys.targets(("tip",))[0]
    good = encode_point(point_at(beam, 0.01, stamp=0))
    x, y, z = point_at(beam, 0.0).xyz
    rubbish = [
        (good[:-5], CDR),
        (os.urandom(40), CDR),
        (bytes(100_000), CDR),
        (good, f"{CDR};sensor_msgs/msg/JointState"),
        (good, "image/png"),
        (encode_point(point_at(beam, 0.01, frame="map")), CDR),
        (encode_point(Point(0, "", (math.nan, y, z))), CDR),
        (encode_point(Point(0, "", (x, y, 1e300))), CDR),
        (encode_point(Point(0, "", (1e3 * x, 1e3 * y, 1e3 * z))), CDR),  # millimetres
        (b"{" * 100, JSON),
        (b"", CDR),
    ]
    kept = (
        zenoh.CongestionControl.BLOCK
    )  # by default Zenoh drops messages of a process that gets no time
    for payload, encoding in rubbish:
        shared.session.put(key, payload, encoding=encoding, congestion_control=kept)
        time.sleep(0.01)
    shared.session.delete(key, congestion_control=kept)
    count = str(len(rubbish) + 1)
    found = wait_health(shared, lambda health: health["targets"].values["refused"] == count)
    targets = found["targets"].values
    refused = {name: int(count) for name, count in targets.items() if name.startswith("refused_")}
    assert targets["accepted"] == "0"
    assert refused.pop("refused_malformed") == 5  # the deletion has no payload
    assert refused == {
        "refused_too_large": 1,
        "refused_wrong_type": 1,
        "refused_unknown_encoding": 1,
        "refused_wrong_frame": 1,
        "refused_not_finite": 1,
        "refused_out_of_reach": 2,
    }
    assert shared.process.end(signal.SIGTERM) == 0
    ticks, joints, _ = recorded(shared.log, beam)
    assert {tick.mode for tick in ticks} == {Mode.IDLE, Mode.STOP}
    assert {joint.position for joint in joints} == {(0.0, 0.0)}
