"""Where a run started, and what actuated it, as its log says.

And what a replay starts with: nothing that draws, where nothing is drawn.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from support.processes import run_main
from support.recorded_run import doctored, with_entry

from tauten.service.log import LogError, LogReader
from tauten.service.replay import make_report, read_run, table_rows


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ("start", "above", "start: Input should be 'settled' or 'rest'"),
        ("actuators.1.kind", "rope", "actuators.1.kind: Input should be 'cable', 'chamber'"),
        ("actuators.1", None, "have 1 actuators, its actuations have 2"),
    ],
)
def test_wrong_metadata_are_refused(
    log: Path, tmp_path: Path, place: str, value: object, message: str
) -> None:
    metadata = LogReader(log).read_metadata()
    metadata["description"] = with_entry(metadata["description"], place, value)
    with pytest.raises(LogError, match=message):
        read_run(doctored(log, tmp_path / "log.mcap", metadata))


def test_each_kind_of_actuator_is_reported_in_its_units(log: Path, tmp_path: Path) -> None:
    metadata = LogReader(log).read_metadata()
    for place, kind in (("actuators.0.kind", "chamber"), ("actuators.1.kind", "drive")):
        metadata["description"] = with_entry(metadata["description"], place, kind)
    other = doctored(log, tmp_path / "log.mcap", metadata)
    report = make_report(read_run(other))
    air, servo = report.peaks
    assert (air.position_unit, air.effort_unit) == ("m³", "Pa")
    assert (servo.position_unit, servo.effort_unit) == ("rad", "N m")
    rows = dict(table_rows(report))
    for row, value, unit in (
        ("largest volume change", 1e6 * air.position, "mL"),
        ("largest pressure", 1e-3 * air.effort, "kPa"),
    ):
        number, shown = rows[row].split()
        assert float(number) == pytest.approx(value, rel=5e-3)
        assert shown == unit
    assert rows["largest angle"].endswith(" deg")
    assert rows["largest torque"].endswith(" N mm")
    assert "largest pull" not in rows


def test_a_replay_without_a_report_draws_nothing(
    log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It waited for matplotlib, which in a home folder that cannot be written also warns."""
    monkeypatch.setitem(sys.modules, "tauten.service.plots", None)
    assert run_main("replay", log) == 0
