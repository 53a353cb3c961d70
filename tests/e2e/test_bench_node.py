"""A served robot seen tick by tick."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from support.processes import forked, run_main

from tauten.service.bench import Deadlines, NodeBenchSettings, bench_node
from tauten.service.bench.node import deadlines, idle_loop
from tauten.service.plant import DemoError
from tauten.service.process import ORDINARY, StopFlag
from tauten.service.replay import Spread
from tauten.service.setup import load_setup
from tauten.service.tables import milliseconds
from tauten.service.wire import Cause, Mode, Tick

TICK = Tick(
    stamp=0, frame="base", index=0, mode=Mode.RUN, cause=Cause.NONE, status="OK", goal=(),
    correction=(), target_stamp=0, lateness=0.0, latency=0.001, decide=0.0002, step=0.0006,
    slack=0.0002, skipped=0, deepest_gap=0.0, complementarity=0.0, stationarity=0.0,
    extra_columns=0, clamped=False,
)  # fmt: skip


def test_missed_and_skipped_are_counted_separately() -> None:
    ticks = [
        replace(TICK, slack=-1.0, skipped=9),  # of the ticks before
        TICK,
        replace(TICK, slack=-0.001, skipped=2),
        replace(TICK, slack=-0.0001),
        TICK,
    ]
    found = deadlines(ticks)
    assert found == Deadlines(ticks=4, missed=2, skipped=2)
    assert found.share == 0.5


def test_a_loop_that_cannot_be_in_time_misses() -> None:
    late = idle_loop(0.002, 0.003, 0.1, ORDINARY, StopFlag())
    assert late.missed == late.ticks - 1  # the first had nothing before it
    easy = idle_loop(0.02, 0.001, 0.2, ORDINARY, StopFlag())
    assert easy.missed < easy.ticks
    stop = StopFlag()
    stop.requested = True
    assert idle_loop(0.02, 0.001, 60.0, ORDINARY, stop).ticks == 0


def test_what_was_not_measured_is_a_dash() -> None:
    assert milliseconds(Spread(None, None, None)) == "-"


def test_a_stop_before_there_is_anything_is_no_error(beam_file: Path) -> None:
    stop = StopFlag()
    stop.requested = True
    settings = NodeBenchSettings(seconds=2.0, target_rate=50.0)
    setup = load_setup(str(beam_file))
    assert bench_node(setup, str(beam_file), settings, stop, lambda text: None) is None


def test_a_stop_before_there_is_anything_is_said_by_the_exit_code(
    beam_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was 0, without a word."""
    monkeypatch.setattr("tauten.service.bench.bench_node", lambda *_: None)
    assert run_main("bench", "node", beam_file) == 130


@pytest.mark.long
def test_a_node_that_ends_is_an_error_with_its_last_words(
    beam_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tauten.service.plant.processes._start", forked)
    settings = NodeBenchSettings(seconds=2.0, target_rate=50.0, options=("--rate", "1e4"))
    setup = load_setup(str(beam_file))
    with pytest.raises(DemoError, match="cannot be held") as error:
        bench_node(setup, str(beam_file), settings, StopFlag(), lambda text: None)
    kept = Path(str(error.value).split("(see ")[1].removesuffix(")"))
    assert "cannot be held" in kept.read_text(encoding="utf-8")
    shutil.rmtree(kept.parent)


@pytest.mark.slow
def test_a_served_robot_is_measured(beam_file: Path, tmp_path: Path) -> None:
    page, file = tmp_path / "page.md", tmp_path / "node.json"
    page.write_text(
        "before\n<!-- tauten bench node -->\nold\n<!-- end -->\nafter\n", encoding="utf-8"
    )
    slow = ["--rate", "10", "--targets", "10", "--seconds", "4"]  # followed on a busy machine too
    found = bench(str(beam_file), [*slow, "--json", str(file), "--markdown", str(page)], file)
    assert (found["model"], found["rate_hz"], found["target_rate_hz"]) == ("full", 10.0, 10.0)
    assert found["deadlines"]["ticks"] > 10
    assert 0.0 < found["decide_ms"]["p50"] < found["step_ms"]["p50"]
    assert found["decide_ms"]["p50"] < found["latency_ms"]["p50"]
    assert found["overhead_ms"]["p50"] > 0.0
    text = page.read_text(encoding="utf-8")
    assert "old" not in text
    assert text.startswith("before\n")
    assert "| node, 10 Hz |" in text
    assert "| busy with nothing |" in text


@pytest.mark.realtime
def test_a_served_finger_is_in_time(tmp_path: Path) -> None:
    file = tmp_path / "node.json"
    options = ["--model", "reduced", "--rate", "50", "--seconds", "4", "--targets", "25"]
    found = bench("finger", [*options, "--json", str(file)], file)
    assert (found["model"], found["rate_hz"], found["target_rate_hz"]) == ("reduced", 50.0, 25.0)
    assert 100 <= found["deadlines"]["ticks"] + found["deadlines"]["skipped"] <= 300
    assert found["unseen"] == 0
    # half a period in the mean from a target to its tick, and the decision
    assert found["step_ms"]["p50"] < 20.0
    assert found["latency_ms"]["p50"] < 40.0
    assert found["overhead_ms"]["p50"] < 10.0


def bench(robot: str, options: list[str], file: Path) -> Any:
    """What `tauten bench node` writes about one rate."""
    assert run_main("bench", "node", robot, *options) == 0
    (found,) = json.loads(file.read_text(encoding="utf-8"))
    return found
