"""Where a run started, and what actuated it: named in its log, or as it was before logs named it."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.recorded_run import doctored

from tauten.service.log import LogError
from tauten.service.replay import make_report, read_run, replay, table_rows


def test_a_log_that_does_not_name_its_start_is_replayed_from_rest(
    log: Path, tmp_path: Path
) -> None:
    old = doctored(log, tmp_path / "old.mcap", {"start": None, "actuator_kinds": None})
    result = replay(old, tolerance=1e-4, recorded_paths=True)
    assert not result.same  # the run started settled: from rest its first decisions are others
    assert result.worst_tick < 20
    assert [peak.kind for peak in make_report(read_run(old)).peaks] == ["cable", "cable"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"start": "above"}, "start is 'above', allowed are settled and rest"),
        ({"actuator_kinds": "cable rope"}, "actuator_kinds has 'rope', allowed are cable, chamber"),
        ({"actuator_kinds": "cable"}, "actuator_kinds has 1 kinds, its actuations have 2"),
    ],
)
def test_wrong_metadata_are_refused(
    log: Path, tmp_path: Path, changes: dict[str, str | None], message: str
) -> None:
    with pytest.raises(LogError, match=message):
        read_run(doctored(log, tmp_path / "log.mcap", changes))


def test_each_kind_of_actuator_is_reported_in_its_units(log: Path, tmp_path: Path) -> None:
    other = doctored(log, tmp_path / "log.mcap", {"actuator_kinds": "chamber drive"})
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
