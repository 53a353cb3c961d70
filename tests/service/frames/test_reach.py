"""The process that computes the reach of an effector."""

from __future__ import annotations

from support.processes import blocks_interrupts

from tauten.service.frames import ReachSearch


def test_ctrl_c_does_not_reach_the_process_while_it_starts() -> None:
    search = ReachSearch("finger")
    try:
        search.of(0)
        assert search._process is not None
        assert blocks_interrupts(search._process.pid)
    finally:
        search.close()
