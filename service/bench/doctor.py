"""`tauten doctor`: measures how well this machine can run a node."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import zenoh
from threadpoolctl import threadpool_info

from tauten.controller import warm_controller
from tauten.model import one_blas_thread
from tauten.service.check import rate_for, step_seconds
from tauten.service.node import ControlLoop, Signals, punctual_clock
from tauten.service.plant import free_ports
from tauten.service.process import busy, host_info, manual_garbage_collection, realtime_permitted
from tauten.service.setup import Setup
from tauten.service.wire import Network, Role, session_of

_SLEEPS = 200
_ROUND_TRIPS = 200
_LATE = 0.01  # share of deadlines that may be missed
_FAST = frozenset({"pardiso", "cholmod"})


@dataclass(frozen=True, slots=True)
class HostFinding:
    """One line of the examination: subject, result, and advice where the result is not good."""

    what: str
    found: str
    advice: str = ""


def examine(setup: Setup, seconds: float) -> list[HostFinding]:
    """Examine machine, libraries, clock and network, and run the loop without cables."""
    facts = host_info()
    found = [
        HostFinding("processor", f"{facts.processor}, {facts.cores} may be used"),
        HostFinding("system", f"{facts.system}, Python {facts.python}"),
        *(HostFinding(name, version) for name, version in facts.versions.items()),
        HostFinding("load", f"{facts.load:.1f} processes", busy()),
    ]
    with one_blas_thread():
        found += [_factorisation(setup, facts.factorisations), _blas()]
        found += [*_clock(), _realtime(), _network()]
        found += _rate(setup, seconds)
    return found


def _factorisation(setup: Setup, installed: tuple[str, ...]) -> HostFinding:
    name = setup.robot.body.linear_solver
    slow = name == "superlu" and not _FAST & set(installed)
    advice = "pip install -e '.[fast]' in the clone of tauten for a faster one" if slow else ""
    return HostFinding("factorisation", f"{name} in use, installed: {', '.join(installed)}", advice)


def _blas() -> HostFinding:
    pools = [(pool["internal_api"], pool["num_threads"]) for pool in threadpool_info()]
    many = [name for name, threads in pools if threads > 1]
    text = ", ".join(f"{name} {threads}" for name, threads in pools)
    return HostFinding(
        "threads of BLAS and OpenMP", text, "more than one slows down" if many else ""
    )


def _clock() -> list[HostFinding]:
    resolution = time.get_clock_info("monotonic").resolution
    late = []
    for _ in range(_SLEEPS):
        begin = time.monotonic()
        time.sleep(1e-3)
        late.append(time.monotonic() - begin - 1e-3)
    p50, p99 = (1e3 * float(value) for value in np.percentile(late, [50.0, 99.0]))
    advice = "processors sleep deeply or are busy: try --priority and --cpus" if p99 > 2.0 else ""
    return [
        HostFinding("clock resolution", f"{1e9 * resolution:.0f} ns"),
        HostFinding("waking up late, p50 / p99", f"{p50:.2f} / {p99:.2f} ms", advice),
    ]


def _realtime() -> HostFinding:
    if realtime_permitted():
        return HostFinding("SCHED_FIFO", "permitted")
    return HostFinding("SCHED_FIFO", "not permitted", "needs CAP_SYS_NICE or rtprio; optional")


def _network() -> HostFinding:
    network = Network(free_ports())
    with (
        session_of(network, Role.NODE, "doctor") as here,
        session_of(network, Role.OTHER, "doctor") as there,
    ):
        times = _round_trips(here, there)
    p50, p99 = (1e3 * float(value) for value in np.percentile(times, [50.0, 99.0]))
    advice = "no answer on loopback: a firewall?" if p50 > 40.0 else ""
    return HostFinding(
        "Zenoh round trip on loopback, p50 / p99", f"{p50:.2f} / {p99:.2f} ms", advice
    )


def _round_trips(here: zenoh.Session, there: zenoh.Session) -> list[float]:
    """Times of messages from one session to another one and back [s]."""
    echo = there.declare_publisher("tauten/doctor/back", express=True)
    back = here.declare_subscriber("tauten/doctor/back", zenoh.handlers.RingChannel(1))
    replier = there.declare_subscriber("tauten/doctor/there", lambda sample: echo.put(b"x"))
    sender = here.declare_publisher("tauten/doctor/there", express=True)
    times: list[float] = []
    end = time.monotonic() + 5.0
    while len(times) < _ROUND_TRIPS and time.monotonic() < end:
        begin = time.perf_counter()
        sender.put(b"x")
        while back.try_recv() is None and time.perf_counter() - begin < 0.05:
            time.sleep(2e-5)
        times.append(time.perf_counter() - begin)
    replier.undeclare()  # type: ignore[no-untyped-call]
    return times


def _rate(setup: Setup, seconds: float) -> list[HostFinding]:
    robot, controller = setup.robot, warm_controller(setup)
    step = step_seconds(controller)
    rate, best = 1.0 / robot.h, rate_for(step)
    loop, goal = ControlLoop(controller, settings=setup.service), controller.effector_values
    late: list[float] = []
    with manual_garbage_collection():
        begin, clock = time.monotonic(), punctual_clock(robot.h)
        while not late or time.monotonic() - begin < seconds:
            late.append(clock.wait().lateness)
            loop.tick(goal, Signals(target=True))
            loop.prepare()
    achieved = len(late) / (time.monotonic() - begin)
    p99 = 1e3 * float(np.percentile(late, 99.0))
    advice = ""
    if clock.missed > _LATE * len(late):
        busy = "a step alone would fit: something else takes the time of the processor"
        advice = f"this machine holds {best:g} Hz" if best < rate else busy
    return [
        HostFinding("robot", f"{robot.name}, {robot.n} unknowns, basis {setup.basis_name}"),
        HostFinding("control step", f"{1e3 * step:.2f} ms, allows {best:g} Hz"),
        HostFinding("rate, requested / achieved", f"{rate:g} / {achieved:.1f} Hz", advice),
        HostFinding("deadlines missed / ticks", f"{clock.missed} / {len(late)}"),
        HostFinding("tick jitter p99", f"{p99:.2f} ms"),
    ]
