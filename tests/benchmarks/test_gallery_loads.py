"""The table of errors under other loads: a row for each kind, in millimetres and shares of the size."""

from __future__ import annotations

from pathlib import Path

from benchmarks.steps import GalleryBench, GalleryRow, LoadRow
from benchmarks.tables import gallery_page
from tauten.service.process import host_info
from tauten.service.replay import Spread


def result() -> GalleryBench:
    times = Spread(1.0, 2.0, 3.0)
    loads = (
        LoadRow("tilt", 16, 1, 0.5, 2.0, "gravity tilted +a, at rest"),
        LoadRow("motion", 0, 400, None, None, ""),
    )
    row = GalleryRow(
        robot="worm",
        size_mm=100.0,
        nodes=9,
        actuators=1,
        candidates=0,
        modes=0,
        state_modes=7,
        sampled=50,
        full_ms=times,
        reduced_ms=times,
        tip_mean_mm=0.1,
        tip_max_mm=0.2,
        loads=loads,
        campaign_equilibria=10,
        campaign_s=1.0,
    )
    return GalleryBench(host_info(), (row,))


def test_errors_are_shown_by_kind_and_what_was_lost_has_no_number() -> None:
    tilt, motion = gallery_page(result()).tables[1].rows
    assert tilt[:3] == ("worm", "tilt", "7")
    assert tilt[4:8] == ("16", "1", "0.50 / 2.00", "2.00")  # 2 mm of 100 mm
    assert motion[5:8] == ("400", "–", "–")


def test_page_gets_the_table_between_its_marks(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- python -m benchmarks gallery -->\nold\n<!-- end -->\nafter\n")
    gallery_page(result()).put_into(page)
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text
    assert "| worm | tilt | 7 | 50 | 16 | 1 | 0.50 / 2.00 | 2.00 |" in text
