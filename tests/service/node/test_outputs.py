"""Ticks are published in time that is left, later where there is none, complete and in order."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
import zenoh

from tauten.controller import warm_controller
from tauten.service.node import Clock, ControlLoop, Node
from tauten.service.node.clock import Beat
from tauten.service.plant import free_ports
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup
from tauten.service.wire import Keys, Network, Role, Tick, decode_tick, open_session

KEYS, WAITING = Keys("beam"), 10


@dataclass
class Listener:
    """A node without a log, a hand on its clock, and what is heard of it."""

    node: Node
    source: zenoh.Subscriber[object]
    health: zenoh.Subscriber[object]
    time: float = 0.0
    heard: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.clock = Clock(0.02, lambda: self.time)

    def tick(self, count: int, late: bool) -> None:
        """So many ticks, with all of their period left or none."""
        self.time = 1.0 if late else 0.0
        for _ in range(count):
            self.node.tick(self.clock, Beat(0, 0.0, 0.01, 0), shutdown=False)

    def listen(self, expected: int = 0) -> list[int]:
        """Numbers of the ticks received so far: when as many as expected are there and no more come."""
        end = time.monotonic() + 10.0
        quiet = time.monotonic() + 0.3
        while time.monotonic() < quiet or (len(self.heard) < expected and time.monotonic() < end):
            sample = self.source.try_recv()
            if sample is None:
                time.sleep(0.01)
                continue
            tick = decode_tick(sample.payload.to_bytes())
            assert isinstance(tick, Tick)
            self.heard.append(tick.index)
            quiet = time.monotonic() + 0.3
        return self.heard


@pytest.fixture
def listener(beam_file: Path) -> Iterator[Listener]:
    setup, port = load_setup(beam_file), free_ports()
    inside = open_session(Network(port), Role.NODE, "beam", connected=False)
    outside = open_session(Network(port), Role.OTHER, "beam", connected=False)
    node = Node(
        setup,
        ControlLoop(warm_controller(setup), settings=setup.service),
        inside,
        None,
        closed_loop=False,
    )
    channel = zenoh.handlers.RingChannel(1000)
    found = Listener(
        node,
        outside.declare_subscriber(KEYS.tick, channel),
        outside.declare_subscriber(KEYS.health, channel),
    )
    end = time.monotonic() + 10.0
    while not found.listen():  # until the two have met
        assert time.monotonic() < end
        found.tick(1, late=False)
    yield found
    outside.close()  # type: ignore[no-untyped-call]
    inside.close()  # type: ignore[no-untyped-call]


@pytest.mark.long
def test_ticks_without_time_are_published_later_and_in_order(listener: Listener) -> None:
    known = len(listener.listen())
    listener.tick(WAITING, late=True)
    assert len(listener.listen()) == known
    listener.tick(3, late=True)  # no more than ten wait
    assert len(listener.listen(known + 3)) == known + 3
    listener.tick(1, late=False)
    heard = listener.listen(known + WAITING + 4)
    assert len(heard) == known + WAITING + 4
    assert heard == list(range(heard[0], heard[0] + len(heard)))


def test_ticks_that_wait_are_published_before_the_node_ends(listener: Listener) -> None:
    known = len(listener.listen())
    listener.tick(5, late=True)
    stop = StopFlag()
    stop.requested = True
    listener.node.run(stop)
    heard = listener.listen(known + 6)
    assert len(heard) > known + 5
    assert heard == list(range(heard[0], heard[0] + len(heard)))


@pytest.mark.long
def test_health_is_published_by_a_node_without_time_left(listener: Listener) -> None:
    listener.tick(5, late=False)
    time.sleep(0.1)
    while listener.health.try_recv() is not None:
        pass
    end, reports = time.monotonic() + 3.5, 0
    while reports < 2:
        assert time.monotonic() < end
        listener.tick(1, late=True)
        time.sleep(0.4)  # a step of the full model of a fine mesh
        while listener.health.try_recv() is not None:
            reports += 1
