"""A served robot seen tick by tick."""

import json
from dataclasses import replace
from pathlib import Path

from typer.testing import CliRunner

from tauten.service.bench_node import Deadlines, deadlines, idle_loop
from tauten.service.cli import app
from tauten.service.node_tables import BEGIN, END
from tauten.service.state_machine import Cause, Mode
from tauten.service.tick import Tick

TICK = Tick(
    stamp=0, frame="base", index=0, mode=Mode.RUN, cause=Cause.NONE, status="OK", goal=(),
    correction=(), target_stamp=0, lateness=0.0, latency=0.001, decide=0.0002, step=0.0006,
    slack=0.0002, skipped=0, deepest_gap=0.0, complementarity=0.0, stationarity=0.0,
    extra_columns=0, clamped=False,
)  # fmt: skip


def test_missed_and_skipped_are_told_apart() -> None:
    ticks = [
        replace(TICK, slack=-1.0, skipped=9),  # speaks of what came before
        TICK,
        replace(TICK, slack=-0.001, skipped=2),
        replace(TICK, slack=-0.0001),
        TICK,
    ]
    found = deadlines(ticks)
    assert found == Deadlines(ticks=4, missed=2, skipped=2)
    assert found.share == 0.5


def test_a_loop_that_cannot_be_in_time_misses() -> None:
    late = idle_loop(period=0.002, work=0.003, seconds=0.1)
    assert late.missed == late.ticks - 1  # the first had nothing before it
    easy = idle_loop(period=0.02, work=0.001, seconds=0.2)
    assert easy.missed < easy.ticks


def test_a_served_finger_is_seen(tmp_path: Path) -> None:
    page, file = tmp_path / "page.md", tmp_path / "node.json"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n", encoding="utf-8")
    options = ["--model", "reduced", "--rate", "50", "--seconds", "4", "--targets", "25"]
    result = CliRunner().invoke(
        app,
        ["bench", "node", "finger", *options, "--json", str(file), "--markdown", str(page)],
    )
    assert result.exit_code == 0, result.output
    (found,) = json.loads(file.read_text(encoding="utf-8"))
    assert (found["model"], found["rate_hz"], found["target_rate_hz"]) == ("reduced", 50.0, 25.0)
    assert 100 <= found["deadlines"]["ticks"] + found["deadlines"]["skipped"] <= 300
    assert found["unseen"] == 0
    # half a period in the mean from a target to its tick, and the decision
    assert 0.0 < found["decide_ms"]["p50"] < found["step_ms"]["p50"] < 20.0
    assert found["decide_ms"]["p50"] < found["latency_ms"]["p50"] < 40.0
    assert 0.0 < found["overhead_ms"]["p50"] < 10.0
    text = page.read_text(encoding="utf-8")
    assert "old" not in text
    assert text.startswith("before\n")
    assert "| node, 50 Hz |" in text
    assert "| busy with nothing |" in text
