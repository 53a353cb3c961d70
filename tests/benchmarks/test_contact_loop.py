"""`python -m benchmarks contact-loop`: the wall, the lift, and what must come out of them."""

from __future__ import annotations

import pytest

from benchmarks.control import ContactBench, LiftBench, WallBench
from benchmarks.tables import contact_loop_page
from tauten.service.process import host_info

DEPTH = 0.02  # m


def test_who_does_not_know_the_wall_misses_more() -> None:
    bench = WallBench(DEPTH, steps=1)
    blind, knowing = (bench.run(name, False, seconds=0.06) for name in ("no wall", "wall"))
    assert blind.unusable == knowing.unusable == 0
    assert 0.5 < blind.force_n < 1.5
    assert blind.along_rms_mm > 2.0 * knowing.along_rms_mm
    page = contact_loop_page(ContactBench(host_info(), 20.0, 1, 1, (blind, knowing), (), True))
    assert [row[0] for row in page.tables[0].rows] == ["no wall", "wall"]


@pytest.mark.slow
@pytest.mark.parametrize("closed", [False, True])
def test_a_cube_that_is_heavier_and_more_slippery_than_believed_is_lifted(closed: bool) -> None:
    bench = LiftBench(steps=1)
    assert not bench.run(1.2, 0.8, closed, seconds=0.04).held
    run = bench.run(1.2, 0.8, closed)
    assert run.held and run.unusable == 0
    assert run.end_mm < 2.5
