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
from support.nodes import PERIOD, check_limits, last_health, ordered, point_at, recorded, send
from support.processes import Served, start

from tauten.model import Robot
from tauten.service.log import LogReader
from tauten.service.wire import CDR, JSON, Mode, Point, encode_point


def test_it_follows_holds_and_releases(served: Served, beam: Robot) -> None:
    last_health(served)  # it has begun
    send(served, beam, 0.008, 1.2)
    send(served, beam, 0.005, 0.8, json=True)
    time.sleep(0.6)  # longer than the timeout
    assert served.process.end() == 0
    ticks, joints, tips = recorded(served.log, beam)
    reader = LogReader(served.log)
    list(reader.messages())
    assert reader.complete
    assert reader.metadata["robot_digest"] == beam.digest
    assert reader.metadata["robot_file"].startswith('name = "beam"')
    assert len(ticks) == len(joints)
    assert [tick.index for tick in ticks] == list(range(len(ticks)))
    modes = [tick.mode for tick in ticks]
    assert ordered(modes) == [Mode.IDLE, Mode.RUN, Mode.HOLD, Mode.STOP]
    assert {tick.status for tick in ticks if tick.mode is Mode.RUN} == {"OK"}
    assert modes.count(Mode.STOP) == 20  # the 0.4 s of the robot file
    # the model's tip got as high as the last target, and the hold kept it there
    held = tips[modes.index(Mode.STOP) - 1]
    assert held.xyz[2] == pytest.approx(point_at(beam, 0.005).xyz[2], abs=1e-3)
    check_limits(joints, beam)
    assert max(joint.pull[1] for joint in joints) > 5e-4
    assert joints[-1].pull == (0.0, 0.0)
    assert joints[-1].tension == (0.0, 0.0)
    # ticks are a period apart but for what the scheduler did to them
    gaps = np.diff([1e-9 * tick.stamp for tick in ticks])
    assert np.median(gaps) == pytest.approx(PERIOD, abs=2e-3)


def test_rubbish_is_counted_and_moves_nothing(served: Served, beam: Robot) -> None:
    key = served.keys.targets(("tip",))[0]
    good = encode_point(point_at(beam, 0.01))
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
    for payload, encoding in rubbish:
        served.session.put(key, payload, encoding=encoding)
        time.sleep(0.01)
    served.session.delete(key)
    time.sleep(0.1)
    targets = last_health(served)["targets"].values
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
    assert served.process.end(signal.SIGTERM) == 0
    ticks, joints, _ = recorded(served.log, beam)
    assert {tick.mode for tick in ticks} == {Mode.IDLE, Mode.STOP}
    assert {joint.pull for joint in joints} == {(0.0, 0.0)}


def test_a_flood_and_jumps_leave_no_actuation_out_of_limits(served: Served, beam: Robot) -> None:
    publisher = served.session.declare_publisher(
        served.keys.targets(("tip",))[0],
        encoding=CDR,
        congestion_control=zenoh.CongestionControl.BLOCK,
    )
    rng = np.random.default_rng(1)
    payloads = [encode_point(point_at(beam, z)) for z in rng.uniform(-0.1, 0.1, 1000)]
    end, sent = time.monotonic() + 2.0, 0
    while time.monotonic() < end:
        for payload in payloads[:100]:
            publisher.put(payload)
        rng.shuffle(payloads)
        sent += 100
        time.sleep(0.005)
    assert served.process.end() == 0
    ticks, joints, _ = recorded(served.log, beam)
    assert sent > 5000
    assert sum(tick.mode is Mode.RUN for tick in ticks) > 50
    check_limits(joints, beam)
    # the flood does not cost the loop its ticks
    lateness = [tick.lateness for tick in ticks]
    assert float(np.median(lateness)) < 2e-3


def test_a_killed_node_leaves_a_readable_log(served: Served, beam: Robot) -> None:
    send(served, beam, 0.005, 1.5)
    assert served.process.end(signal.SIGKILL) == -signal.SIGKILL
    reader = LogReader(served.log)
    ticks = [m for m in reader.messages() if m.key.endswith("/tick")]
    assert not reader.complete
    # at 50 Hz a chunk is less than a second
    assert len(ticks) > 0.4 * 1.5 / PERIOD


def test_a_second_node_is_refused(served: Served, beam_file: Path, tmp_path: Path) -> None:
    second = start(tmp_path / "second.txt", "serve", beam_file, "--port", served.port)
    assert second.process.wait(60.0) == 2
    last = second.output.read_text().strip().splitlines()[-1]
    assert last.startswith("tauten: port")
    assert "is another node of 'beam' running?" in last
    assert served.process.process.poll() is None


def test_the_description_answers(served: Served, beam: Robot) -> None:
    replies = list(served.session.get(served.keys.description, timeout=5.0))
    assert len(replies) == 1
    sample = replies[0].ok
    assert sample is not None
    found = json.loads(bytes(sample.payload))
    assert found["robot"] == "beam"
    assert found["frame"] == "beam_base"
    assert [cable["name"] for cable in found["cables"]] == ["lower", "upper"]
    assert found["cables"][0]["pull"] == [0.0, 0.02]
    assert [e["target"] for e in found["effectors"]] == [
        "tauten/beam/target",
        "tauten/beam/target/middle",
    ]
    assert found["effectors"][0]["rest"] == pytest.approx(beam.effector(beam.rest())[0].tolist())
    assert found["model"]["digest"] == beam.digest
