"""`tauten bench node`: ticks of a served robot, and deadlines that an idle loop misses on this machine."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import zenoh

from tauten.service.node import punctual_clock
from tauten.service.plant import (
    Child,
    DemoError,
    PathSettings,
    StartLimit,
    TargetPath,
    child,
    free_ports,
    make_path,
    save_path,
)
from tauten.service.process import (
    ORDINARY,
    HostInfo,
    RealtimeSettings,
    StopFlag,
    apply_realtime,
    host_info,
)
from tauten.service.replay import Spread, overheads, spread
from tauten.service.setup import Setup
from tauten.service.wire import (
    Keys,
    Mode,
    Network,
    Role,
    Tick,
    decode_health,
    decode_tick,
    is_alive,
    session_of,
)

_SETTLE = 1.0  # s of ticks that are left out at the start
_IDLE = 10.0  # s of the loop that does nothing
_PATIENCE = 60.0  # s longer than it should take
_RING = 100_000  # ticks


@dataclass(frozen=True, slots=True)
class NodeBenchSettings:
    """What is served.

    Attributes:
        seconds: of targets.
        target_rate: targets a second.
        options: further options of `tauten serve`.
        realtime: priority and processors among them, for the loop that does nothing.
        viewer: whether `tauten view` listens to the node meanwhile.
    """

    seconds: float
    target_rate: float
    options: tuple[str, ...] = ()
    realtime: RealtimeSettings = ORDINARY
    viewer: bool = False


@dataclass(frozen=True, slots=True)
class Deadlines:
    """Deadlines of a loop.

    Attributes:
        ticks: number of ticks.
        missed: ticks that were not finished when the next one was due.
        skipped: ticks that were not started, because the one before took too long.
    """

    ticks: int
    missed: int
    skipped: int

    @property
    def share(self) -> float:
        """Missed deadlines over ticks."""
        return self.missed / max(self.ticks, 1)


@dataclass(frozen=True, slots=True)
class NodeBench:
    """Measured numbers of a served robot that follows targets.

    Attributes:
        machine: where.
        robot: name.
        model: "full" or "reduced".
        rate_hz: of the node.
        seconds: of targets.
        target_rate_hz: targets a second.
        unseen: ticks whose messages were lost in the network.
        deadlines: of the node.
        idle: of a loop at this rate in which every tick takes the node's median time and does nothing:
            deadlines that it misses are due to the machine.
        decide_ms: time of `decide`.
        step_ms: time of `decide`, `advance` and `prepare`.
        overhead_ms: work of a tick outside the control step.
        lateness_ms: of the beginning of a tick.
        latency_ms: from a target's header to its actuation.
        surfaces_hz: surfaces a second that were published for a viewer; 0 without one.
        processor_share: processor time of the node over time, while it follows targets.
        viewer_share: the same of the viewer; 0 without one.
    """

    machine: HostInfo
    robot: str
    model: str
    rate_hz: float
    seconds: float
    target_rate_hz: float
    unseen: int
    deadlines: Deadlines
    idle: Deadlines
    decide_ms: Spread
    step_ms: Spread
    overhead_ms: Spread
    lateness_ms: Spread
    latency_ms: Spread
    surfaces_hz: float
    processor_share: float
    viewer_share: float


@dataclass(frozen=True, slots=True)
class _Run:
    """What was seen of a node.

    Attributes:
        ticks: while it followed targets, and before.
        surfaces_hz: surfaces a second that were published for a viewer.
        node_share: processor time of the node over time.
        viewer_share: the same of the viewer.
    """

    ticks: tuple[Tick, ...]
    surfaces_hz: float
    node_share: float
    viewer_share: float


def bench_node(
    setup: Setup,
    robot: str,
    settings: NodeBenchSettings,
    stop: StopFlag,
    notify: Callable[[str], None],
) -> NodeBench | None:
    """Serve a robot as a process, stream targets to it, and look at its ticks; None: stopped before any.

    Raises:
        DemoError: a process failed, or no target was followed.
    """
    rate = setup.robot.integration.rate
    notify("finding a path that the robot can follow")
    path = _path(setup, stop)
    if path is None:
        return None
    notify(f"{rate:g} Hz: starting the node, kernels are compiled the first time")
    run = _served(setup, robot, path, settings, stop, notify)
    first = next((i for i, tick in enumerate(run.ticks) if tick.mode is Mode.RUN), len(run.ticks))
    ticks = run.ticks[first + int(_SETTLE * rate) :]
    if not any(tick.status for tick in ticks) or len(ticks) < 2:
        if stop.requested:
            return None
        raise DemoError(
            f"{robot}: no target was followed after the first {_SETTLE:g} s, of {settings.seconds:g} s at "
            f"{settings.target_rate:g} targets a second"
        )
    notify(f"{rate:g} Hz: the machine alone")
    return _numbers(setup, settings, replace(run, ticks=ticks), stop)


def _path(setup: Setup, stop: StopFlag) -> TargetPath | None:
    """A path that the model which decides can follow; None where a stop has been requested before."""
    if stop.requested:
        return None
    with stop.interruptible():
        return make_path("reach", setup.robot, PathSettings())


def _numbers(setup: Setup, settings: NodeBenchSettings, run: _Run, stop: StopFlag) -> NodeBench:
    rate, ticks = setup.robot.integration.rate, run.ticks
    followed = [tick for tick in ticks if tick.status]
    pairs = [pair for pair in pairwise(ticks) if pair[1].index == pair[0].index + 1]
    overhead = [value for pair in pairs for value in overheads(pair, 1.0 / rate)]
    work = float(np.median([tick.step for tick in followed])) + 1e-3 * float(np.median(overhead))
    return NodeBench(
        machine=host_info(),
        robot=setup.robot.name,
        model=setup.order,
        rate_hz=rate,
        seconds=settings.seconds,
        target_rate_hz=settings.target_rate,
        unseen=ticks[-1].index - ticks[0].index + 1 - len(ticks),
        deadlines=deadlines(ticks),
        idle=idle_loop(1.0 / rate, work, min(_IDLE, settings.seconds), settings.realtime, stop),
        decide_ms=spread([1e3 * tick.decide for tick in followed]),
        step_ms=spread([1e3 * tick.step for tick in followed]),
        overhead_ms=spread(overhead),
        lateness_ms=spread([1e3 * tick.lateness for tick in ticks]),
        latency_ms=spread([1e3 * tick.latency for tick in ticks]),
        surfaces_hz=run.surfaces_hz,
        processor_share=run.node_share,
        viewer_share=run.viewer_share,
    )


def deadlines(ticks: Sequence[Tick]) -> Deadlines:
    """Missed deadlines that ticks report; the first one reports about a tick before them."""
    later = ticks[1:]
    return Deadlines(
        len(later), sum(tick.slack < 0.0 for tick in later), sum(tick.skipped for tick in later)
    )


def idle_loop(
    period: float, work: float, seconds: float, realtime: RealtimeSettings, stop: StopFlag
) -> Deadlines:
    """Deadlines of a loop that computes nothing useful for some time of every period.

    It runs in its own thread, because priority and processors belong to a thread.

    Args:
        period: of the loop [s].
        work: time of each tick [s].
        seconds: duration.
        realtime: priority and processors.
        stop: raised to end early.
    """

    def loop() -> Deadlines:
        apply_realtime(realtime)
        clock, ticks = punctual_clock(period), 0
        end = time.monotonic() + seconds
        while time.monotonic() < end and not stop.requested:
            clock.wait()
            ticks += 1
            done = time.monotonic() + work
            while time.monotonic() < done:
                pass
        return Deadlines(ticks, clock.missed, clock.skipped)

    with ThreadPoolExecutor(1) as thread:
        return thread.submit(loop).result()


class _Observer:
    """Receives what a node says while it follows targets.

    Attributes:
        ticks: that were read.
    """

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self.ticks: list[Tick] = []
        self._published: list[tuple[float, int]] = []  # time of arrival [s], surfaces so far
        self._source = session.declare_subscriber(keys.tick, zenoh.handlers.RingChannel(_RING))
        self._health = session.declare_subscriber(keys.health, self._heard)

    @property
    def follows(self) -> bool:
        """Whether the node follows targets now."""
        self.read()
        return bool(self.ticks) and self.ticks[-1].mode is Mode.RUN

    @property
    def is_watched(self) -> bool:
        """Whether the node has published surfaces."""
        return bool(self._published) and self._published[-1][1] > 0

    def read(self) -> None:
        """Read the ticks that have arrived."""
        while (sample := self._source.try_recv()) is not None:
            tick = decode_tick(bytes(sample.payload))
            if isinstance(tick, Tick):
                self.ticks.append(tick)

    def surfaces_hz(self, begin: float) -> float:
        """Surfaces a second since a time [s]."""
        found = [one for one in self._published if one[0] >= begin]
        if len(found) < 2:
            return 0.0
        (first, before), (last, after) = found[0], found[-1]
        return (after - before) / (last - first)

    def _heard(self, sample: zenoh.Sample) -> None:
        health = decode_health(bytes(sample.payload))
        if isinstance(health, dict):
            self._published.append((time.monotonic(), int(health["surface"].values["published"])))


def _served(
    setup: Setup,
    robot: str,
    path: TargetPath,
    settings: NodeBenchSettings,
    stop: StopFlag,
    notify: Callable[[str], None],
) -> _Run:
    """What a node does that follows a path, without and with a viewer."""
    port, name, rate = free_ports(), setup.robot.name, setup.robot.integration.rate
    keys, common = Keys(name), ["--port", str(port)]
    with ExitStack() as stack:
        folder = Path(mkdtemp(prefix="tauten-bench-"))
        # an error message names the files of output: they are kept then
        stack.push(lambda error, *_: None if error else shutil.rmtree(folder))
        save_path(path, folder / "path.csv")
        node = stack.enter_context(child("serve", [robot, *settings.options, *common], folder))
        session = stack.enter_context(session_of(Network(port), Role.OTHER, name))
        observer = _Observer(session, keys)
        _await(lambda: is_alive(session, keys.token), (node,), None, stop)
        watched = [node]
        if settings.viewer:
            notify(f"{rate:g} Hz: starting the viewer")
            shown = [name, "--no-browser", "--web-port", "0", *common]
            watched.append(stack.enter_context(child("view", shown, folder)))
            watched[-1].give_way()
            _await(lambda: observer.is_watched, (watched[-1], node), None, stop)
        sending = [str(folder / "path.csv"), "--robot", robot, "--repeat"]
        sending += ["--rate", repr(settings.target_rate), "--duration", repr(settings.seconds)]
        sender = stack.enter_context(child("stream", [*sending, *common], folder))
        sender.give_way()
        _await(lambda: sender.ended or observer.follows, (sender, *watched), None, stop)
        notify(f"{rate:g} Hz: following targets for {settings.seconds:g} s")
        begin, before = time.monotonic(), [one.processor_time for one in watched]
        _await(lambda: sender.ended, (sender, *watched), _PATIENCE + settings.seconds, stop)
        lasted = time.monotonic() - begin
        used = [one.processor_time - then for one, then in zip(watched, before, strict=True)]
        observer.read()
    return _Run(
        tuple(observer.ticks), observer.surfaces_hz(begin), used[0] / lasted, sum(used[1:]) / lasted
    )


def _await(
    done: Callable[[], bool], children: tuple[Child, ...], seconds: float | None, stop: StopFlag
) -> None:
    """Wait for the first child, all of which must live on or end well. Without seconds: `StartLimit`."""
    limit, begin = StartLimit(), time.monotonic()
    while not done() and not stop.requested:
        if seconds is None:
            limit.check(f"tauten {children[0].name}")
        elif time.monotonic() - begin > seconds:
            raise DemoError(f"tauten {children[0].name} took more than {seconds:g} s")
        time.sleep(0.1)
        if not stop.requested:  # a child that Ctrl-C has met may end before it is ready
            for one in children:
                one.check()
