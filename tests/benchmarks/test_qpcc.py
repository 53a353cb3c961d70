"""The QPCC benchmark on a few problems: what it counts, and where its tables go."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.qpcc_checks import recorded
from typer.testing import CliRunner

from benchmarks.commands import app
from benchmarks.qpcc import (
    QpccBench,
    QpccCase,
    Size,
    generated,
    known_global,
    make_problems,
    measure,
    robot_like,
    time_solves,
)
from benchmarks.tables import qpcc_page
from tauten.controller.qpcc import available_backends
from tauten.service.process import host_info


def nothing() -> None:
    """A progress bar that nobody sees."""


def test_times_of_the_same_problems_by_library_and_start() -> None:
    asked = make_problems(Size(1, 5, robots=1))
    assert len(asked) == 20
    default, other = available_backends()[0], "osqp"
    cold = time_solves(asked, default, "cold", fastest_of=1)
    warm = time_solves(asked, default, "warm", fastest_of=1)
    slow = time_solves(asked, other, "warm", fastest_of=1)
    assert (cold.n_a, cold.k, cold.problems, cold.start) == (1, 5, 20, "cold")
    assert warm.statuses == {"OK": 20}
    assert sum(slow.statuses.values()) == 20
    assert warm.pivots.p50 == 1.0
    assert warm.ms.p50 is not None
    assert slow.ms.p50 is not None


@pytest.mark.realtime
def test_the_default_library_is_faster_than_a_splitting_one() -> None:
    asked = make_problems(Size(1, 5, robots=1))
    default, other = (
        time_solves(asked, library, "warm", fastest_of=3).ms.p50
        for library in (available_backends()[0], "osqp")
    )
    assert default is not None and other is not None
    assert default < other


def test_a_thousand_problems_are_generated() -> None:
    assert sum(len(cases) for _, cases in generated()) >= 1000


def test_gaps_are_counted_against_the_optimum() -> None:
    known = known_global(np.random.default_rng(1), 3, 8)
    value = known.problem.objective(known.lam_a, known.beta)
    right = QpccCase(known.problem, None, value)
    wrong = QpccCase(known.problem, None, value - 0.005 * abs(value))
    far = QpccCase(known.problem, None, value - 0.5 * abs(value))
    quality = measure("three", [right, wrong, far], nothing)
    second = quality.gaps[-1]
    assert second.start == "cold"
    assert (second.exact, second.percent) == (1 / 3, 2 / 3)
    assert second.worst == pytest.approx(0.5 * abs(value) / abs(value - 0.5 * abs(value)))
    assert quality.residual <= 1e-8


def test_empty_problems_are_left_out_and_recorded_ones_compared_with_staying() -> None:
    problem = robot_like(np.random.default_rng(2), 2, 4).problem()
    empty = replace(problem, g_lo=problem.g_hi + 1.0, g_hi=problem.g_hi + 2.0)
    quality = measure("empty", [QpccCase(empty), QpccCase(problem)], nothing)
    assert (quality.problems, quality.empty) == (2, 1)
    assert quality.gaps[0].statuses["INFEASIBLE"] == 1
    steps = recorded("finger_5")[:5]
    warm = measure("finger", [QpccCase(step.problem(), step.start) for step in steps], nothing)
    assert [gaps.start for gaps in warm.gaps] == ["descent", "cold", "warm"]
    assert warm.stay > 0
    assert warm.worse_than_staying == 0


def test_tables_go_between_the_marks_of_a_page(tmp_path: Path) -> None:
    asked = make_problems(Size(1, 5, robots=1))
    times = tuple(
        time_solves(asked, "daqp", kind, fastest_of=1) for kind in ("descent", "cold", "warm")
    )
    quality = measure("few", [QpccCase(asked[0].problem)], nothing)
    result = QpccBench(host_info(), times, (quality,))
    assert all(
        len(row) == len(table.columns) for table in qpcc_page(result).tables for row in table.rows
    )
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- python -m benchmarks qpcc -->\nyesterday\n<!-- end -->\nafter\n")
    for _ in range(2):  # twice is as good as once
        qpcc_page(result).put_into(page)
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("<!-- end -->\nafter\n")
    assert "yesterday" not in text
    assert text.count("| 1 x 5 |") == 1
    page.write_text("no marks")
    with pytest.raises(ValueError, match=r"page\.md: has no marks"):
        qpcc_page(result).put_into(page)


def test_the_command_finds_the_recorded_problems_or_says_that_it_does_not(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[Path] = []

    def bench(folder: Path, *_: object) -> None:
        asked.append(folder)
        raise KeyboardInterrupt

    monkeypatch.setattr("benchmarks.qpcc.bench_qpcc", bench)
    CliRunner().invoke(app, ["qpcc"])
    assert len(list(asked[0].glob("*.npz"))) >= 4
    refused = CliRunner().invoke(app, ["qpcc", "--recorded", str(tmp_path)])
    assert refused.exit_code == 2
    assert len(asked) == 1
    assert "has no recorded problems" in re.sub(r"[│\s]+", " ", refused.output)
