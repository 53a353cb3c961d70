"""Ticks that wait for targets are never closer than a period, however late one is: no winch turns faster."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest

from tauten.controller import warm_controller
from tauten.service.node import Clock, ControlLoop, Node
from tauten.service.node import node as node_module
from tauten.service.plant import free_ports
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup
from tauten.service.wire import Cause, Mode, Network, Role, session_of


@pytest.mark.parametrize("arrive", [True, False])
def test_ticks_with_their_targets_are_never_closer_than_a_period(
    arrive: bool, beam_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one after a late tick came on the old grid, 0.4 of a period after it."""
    setup, hand, stop = load_setup(beam_file), SimpleNamespace(time=100.0), StopFlag()
    period, work, begun = setup.robot.h, [0.1, 1.6, 0.1, 0.1, 3.2, 0.1, 0.1], list[float]()

    def now() -> float:
        return float(hand.time)

    def sleep(seconds: float) -> None:
        hand.time += seconds

    def tick(*_: object, **__: object) -> None:
        begun.append(hand.time)
        hand.time += work[len(begun) - 1] * period
        stop.requested = len(begun) == len(work)

    loop = ControlLoop(warm_controller(setup), settings=setup.service)
    monkeypatch.setattr(node_module, "punctual_clock", lambda period: Clock(period, now, sleep))
    with session_of(Network(free_ports()), Role.NODE, "beam", connected=False) as session:
        node = Node(setup, loop, session, None, closed_loop=False)
        loop.set_mode(Mode.RUN, Cause.NONE)
        monkeypatch.setattr(node_module, "time", SimpleNamespace(monotonic=now, sleep=sleep))
        monkeypatch.setattr(node._inputs, "read_targets", lambda *_: arrive)
        monkeypatch.setattr(node, "tick", tick)
        monkeypatch.setattr(node, "_release", lambda *_: None)
        node.run(stop, event=True)
    apart = [after - before for before, after in pairwise(begun)]
    assert min(apart) > (1.0 - 1e-9) * period
    assert max(apart) < 3.2 * period + 0.5 * period + 1e-3  # no longer than work and waiting take
