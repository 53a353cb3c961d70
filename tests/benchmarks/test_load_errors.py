"""Errors under other loads: a row for each kind, in millimetres and shares of the size."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.steps import LoadBench, LoadRow, RobotLoads, bench_load_errors
from benchmarks.tables import load_errors_page
from tauten.service.process import host_info


def result() -> LoadBench:
    loads = (
        LoadRow("tilt", 16, 1, 0.5, 2.0, "gravity tilted +a, at rest"),
        LoadRow("motion", 0, 400, None, None, ""),
    )
    return LoadBench(host_info(), (RobotLoads("worm", 100.0, 7, 50, loads),))


def test_errors_are_shown_by_kind_and_what_was_lost_has_no_number() -> None:
    tilt, motion = load_errors_page(result()).tables[0].rows
    assert tilt[:3] == ("worm", "tilt", "7")
    assert tilt[4:8] == ("16", "1", "0.50 / 2.00", "2.00")  # 2 mm of 100 mm
    assert motion[5:8] == ("400", "–", "–")


def test_page_gets_the_table_between_its_marks(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- python -m benchmarks load-errors -->\nold\n<!-- end -->\nafter\n")
    load_errors_page(result()).put_into(page)
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text
    assert "| worm | tilt | 7 | 50 | 16 | 1 | 0.50 / 2.00 | 2.00 |" in text


@pytest.mark.slow
def test_the_reduced_diamond_is_near_the_full_one_under_every_kind_of_load() -> None:
    shares = list[float]()
    (robot,) = bench_load_errors(("diamond",), lambda share, what: shares.append(share)).robots
    assert sum(shares) == pytest.approx(1.0)
    assert [row.kind for row in robot.loads] == ["own weight", "tilt", "payload", "motion"]
    for row in robot.loads:
        assert row.lost == 0 and row.max_mm is not None
        assert 0.0 < row.max_mm < 0.003 * robot.size_mm
