"""The demo: node and plant as processes of their own, targets for them, then a report of what they did."""

from __future__ import annotations

import contextlib
import logging
import math
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from tauten.controller import Order, Status, warm_controller
from tauten.model import Actuators, Robot, one_blas_thread
from tauten.service.check import faster, first_decision, rate_for
from tauten.service.describing import describe
from tauten.service.kernels import waiting
from tauten.service.link import step_at_start
from tauten.service.node import ServeSettings, serve
from tauten.service.plant.copying import robot_copies, write_copies
from tauten.service.plant.drives import Drive
from tauten.service.plant.paths import PathSettings, make_path
from tauten.service.plant.plant import (
    PlantSettings,
    Steps,
    plant_robot,
    simulate,
)
from tauten.service.plant.processes import (
    STOP_TIME,
    Child,
    DemoError,
    Program,
    StartLimit,
    child,
    free_ports,
)
from tauten.service.plant.streaming import StreamSettings, stream
from tauten.service.plant.waypoints import TargetPath, save_path
from tauten.service.process import Interrupted, StopFlag, alone_in, stop_on_signals
from tauten.service.replay import RecordedRun, RunReport, make_report, read_run
from tauten.service.setup import Setup, load_setup
from tauten.service.wire import (
    Keys,
    Network,
    RobotDescription,
    Role,
    is_alive,
    session_of,
    typestore,
)

log = logging.getLogger(__name__)

LOG, REPORT, FIGURE, TARGETS = "log.mcap", "report.json", "figure.png", "targets.csv"
NODE, PLANT = "serve", "plant"  # the commands
# How much longer than at the start a control step may take. Else a node refuses to start: the next is tried.
SPARE = (2.0, 4.0, 8.0)
_KEEPS_UP = 0.9  # share of the periods that a simulated robot goes through
_GLANCE = 0.03  # s between two looks at what is alive
_ANSWER = 20.0  # s until a node that is alive must have said how long its control step takes


@dataclass(frozen=True, slots=True)
class DemoSettings:
    """Settings of the demo.

    Attributes:
        robot: name or file.
        folder: of log, report and targets.
        seconds: of targets.
        path: of the targets, as for `tauten stream`.
        period: of one pass [s]; None: 10, or as many as the robot needs for "reach".
        fraction: of the largest pull, for "reach".
        basis: of the node, as for `tauten serve`.
        model: of node and plant, as for `tauten serve`; a plant of another stiffness is always full.
        closed_loop: whether the plant's measurements correct the targets.
        young_scale: the plant's Young's modulus, as a multiple of the robot file's.
        drive: what the plant's winches obey, as for `tauten plant`.
        steps: the plant's time steps, as for `tauten plant`.
    """

    robot: str
    folder: Path
    seconds: float
    path: str = "reach"
    period: float | None = None
    fraction: float = 0.8
    basis: str | None = None
    model: Order | None = None
    closed_loop: bool = False
    young_scale: float = 1.0
    drive: Drive = "pull"
    steps: Steps = "own"


@dataclass(frozen=True, slots=True)
class DemoResult:
    """What the demo did: its run, the numbers of it, the robot's actuators, and what to do about it."""

    run: RecordedRun
    report: RunReport
    actuators: Actuators
    notes: tuple[str, ...] = ()


def run_demo(
    settings: DemoSettings,
    stop: StopFlag,
    notify: Callable[[str], None],
    as_command: Callable[[Program], object] | None = None,
) -> DemoResult:
    """Run the demo; leaves targets, log and report in a folder.

    Args:
        settings: what to do.
        stop: raised to end early; what has been recorded is still reported.
        notify: called with a sentence before each part of the work.
        as_command: runs a program and ends the process as a command does; node and plant then begin as
            copies of this process, which have imported everything and loaded the robot. It must have
            started no thread and no Zenoh session, and `notify` is called after that. None: they are new
            processes.

    Raises:
        DemoError: a process failed, or a file of the user is in the folder.
        RobotFileError, MeshError, BasisError, PathError: what cannot be used, and why.
        LogError: nothing was recorded.
        OSError: another demo writes into the folder.
    """
    if kernels := waiting():
        log.info("%s", kernels)
    folder = settings.folder
    with contextlib.ExitStack() as held:
        with one_blas_thread():
            setup = load_setup(settings.robot, basis=settings.basis, model=settings.model)
        typestore()  # for the copies too
        copies = robot_copies(setup.path, settings.basis, folder)
        _spare(folder, settings.path)
        folder.mkdir(parents=True, exist_ok=True)
        held.enter_context(alone_in(folder))
        write_copies(copies)
        return _Demo(settings, setup, stop, notify).run(as_command)


class _Demo:
    """A demo whose robot is loaded and whose folder is its own."""

    def __init__(
        self, settings: DemoSettings, setup: Setup, stop: StopFlag, notify: Callable[[str], None]
    ) -> None:
        self._settings, self._setup, self._stop, self._notify = settings, setup, stop, notify
        self._keys, self._port, self._notes = Keys(setup.robot.name), free_ports(), list[str]()
        self._network = Network(self._port)

    def run(self, as_command: Callable[[Program], object] | None) -> DemoResult:
        """Run it, see `run_demo`."""
        settings, setup, robot = self._settings, self._setup, self._setup.robot
        folder, rate = settings.folder, robot.integration.rate
        with contextlib.ExitStack() as stack:
            started = (
                self._started(stack) if as_command is None else self._copies(stack, as_command)
            )
            self._notify("node and plant get ready, targets that can be reached are found")
            with contextlib.suppress(Interrupted), self._stop.interruptible():
                wanted = PathSettings(period=settings.period, fraction=settings.fraction)
                save_path(make_path(settings.path, robot, wanted), folder / TARGETS)
            step = _wait_alive(self._keys, self._network, started, self._stop)
            if self._stop.requested:
                raise DemoError(
                    "stopped before the node and the plant were ready: nothing was recorded"
                )
            path = make_path(str(folder / TARGETS), robot, PathSettings(repeats=True))
            if math.isnan(step):
                self._say(
                    f"the node does not say how long a control step takes: whether it holds {rate:g} Hz is "
                    "unknown"
                )
            if step_in_demo(step, robot) * rate > 1.0:  # a node that misses its deadlines holds
                rate, started = self._slowed(stack, step, started)
                path = replace(path, times=robot.integration.rate / rate * path.times)
                save_path(path, folder / TARGETS)
            node, plant = started
            sending = StreamSettings(rate, settings.seconds, False, 0, True)
            sender = stack.enter_context(_sending(describe(setup), path, sending, self._network))
            plant.give_way()
            whole = (
                "" if path.duration <= settings.seconds else f"; a pass takes {path.duration:g} s"
            )
            self._notify(f"following targets for {settings.seconds:g} s{whole}")
            _wait_end(sender, started, self._stop)
            self._notify("releasing the actuators")
            _end(node)
            _end(plant)
        self._notify("reading the log")
        run = read_run(folder / LOG)
        report = make_report(run)
        report.save(folder / REPORT)
        self._notes += slow_plant(run)
        if not report.statuses.get(Status.OK.name):
            found = first_decision(warm_controller(setup))
            advice = f": {found.advice}" if found.advice else ""
            self._notes.append(f"no decision was OK; {found.found}{advice}")
        return DemoResult(run, report, robot.actuators, tuple(self._notes))

    def _say(self, note: str) -> None:
        self._notes.append(note)
        self._notify(note)

    def _slowed(
        self, stack: contextlib.ExitStack, step: float, started: tuple[Child, Child]
    ) -> tuple[float, tuple[Child, Child]]:
        """Node and plant at a rate that the node holds [Hz], instead of those that have been started.

        Where the node refuses the first rate for control steps of some time [s], a still lower one is tried.
        """
        for spare in SPARE:
            rate = min(rate_for(spare * step), self._setup.robot.integration.rate)
            self._say(_too_slow(step, rate, self._setup))
            for one in started:
                if one.process.poll() is None:  # a node that refused has ended
                    _end(one)
            started = self._started(stack, rate)
            try:
                _wait_alive(self._keys, self._network, started, self._stop)
                break
            except DemoError:
                if spare == SPARE[-1]:
                    raise
        return rate, started

    def _started(
        self, stack: contextlib.ExitStack, rate: float | None = None
    ) -> tuple[Child, Child]:
        """Node and plant as new processes."""
        settings, folder = self._settings, self._settings.folder
        common = ["--port", str(self._port), *([] if rate is None else ["--rate", repr(rate)])]
        serving = [settings.robot, "--record", str(folder / LOG), *common]
        if settings.basis is not None:
            serving += ["--basis", settings.basis]
        if settings.model is not None:
            serving += ["--model", settings.model]
        behaving = ["--young-scale", repr(settings.young_scale), "--drive", settings.drive]
        if settings.model is not None and settings.young_scale == 1.0:
            behaving += ["--model", settings.model]
        behaving += ["--steps", settings.steps]
        if settings.closed_loop:
            serving.append("--closed-loop")
            behaving.append("--measure")
        node = stack.enter_context(child(NODE, serving, folder))
        plant = [settings.robot, *behaving, *common]
        return node, stack.enter_context(child(PLANT, plant, folder))

    def _copies(
        self, stack: contextlib.ExitStack, as_command: Callable[[Program], object]
    ) -> tuple[Child, Child]:
        """Node and plant as copies of this process, with the robot that it has loaded; see `_started`."""
        settings, setup, network = self._settings, self._setup, self._network

        def serving() -> None:
            with stop_on_signals() as stop:
                ways = ServeSettings(settings.folder / LOG, settings.closed_loop)
                serve(setup, network, ways, stop)

        def behaving() -> None:
            simulated = setup
            if settings.young_scale != 1.0:
                simulated = plant_robot(settings.robot, None, None, settings.young_scale)
            ways = PlantSettings(settings.closed_loop, settings.drive, settings.steps)
            with stop_on_signals() as stop:
                simulate(simulated, network, ways, stop, settings.model)

        node = stack.enter_context(child(NODE, [], settings.folder, partial(as_command, serving)))
        plant = child(PLANT, [], settings.folder, partial(as_command, behaving))
        return node, stack.enter_context(plant)


def _spare(folder: Path, path: str) -> None:
    """Check that what the demo writes replaces no file but those of a demo before.

    Raises:
        DemoError: it would.
    """
    is_left = (folder / f"{NODE}.txt").exists()  # by a demo
    for file in (folder / name for name in (LOG, REPORT, FIGURE, TARGETS)):
        if file.exists() and (not is_left or file.resolve() == Path(path).resolve()):
            raise DemoError(f"{file}: the demo would replace it: choose another --out, or move it")


def step_in_demo(step: float, robot: Robot) -> float:
    """How long a control step may take [s] that takes some time at the start, before contacts push."""
    return (SPARE[0] if robot.contacts.pairs else 1.0) * step


def _too_slow(step: float, rate: float, setup: Setup) -> str:
    """That the period cannot be held, by how much all is slower, and what to do."""
    own = setup.robot.integration.rate
    advice = faster(setup.path, step, bool(setup.states), setup.robot, here=True)
    contact = (
        " at the start and longer in contact" if step_in_demo(step, setup.robot) > step else ""
    )
    return (
        f"a control step takes {1e3 * step:.0f} ms{contact}, the period is {1e3 / own:.0f} ms: the demo runs "
        f"at {rate:g} Hz, its targets move {own / rate:.1f} times slower; {advice}"
    )


def slow_plant(run: RecordedRun) -> list[str]:
    """A sentence where the simulated robot of a run did not keep up with the time that passed."""
    time = run.plant.time  # (m,) of its periods
    if len(time) < 2:
        return []
    share = (len(time) - 1) / (time[-1] - time[0]) / run.description.rate
    if share > _KEEPS_UP:
        return []
    return [
        f"the simulated robot went through {100.0 * share:.0f} % of its periods, because this computer is "
        "busy or slow: it lags behind, and its errors are not those of the model"
    ]


def _wait_alive(keys: Keys, network: Network, children: tuple[Child, ...], stop: StopFlag) -> float:
    """Wait until node and plant are alive; the time of a control step by the node [s], NaN without one."""
    with session_of(network, Role.OTHER, keys.robot) as session:
        limit = StartLimit()
        missing = {keys.token, keys.plant_token}
        while missing and not stop.requested:
            for one in children:
                one.check()
            limit.check(", ".join(sorted(missing)))
            missing -= {key for key in missing if is_alive(session, key)}
            time.sleep(_GLANCE)
        step, end = math.nan, time.monotonic() + _ANSWER
        while math.isnan(step) and not stop.requested and time.monotonic() < end:
            for one in children:
                one.check()
            step = step_at_start(session, keys.robot)
        return step


@contextlib.contextmanager
def _sending(
    robot: RobotDescription, path: TargetPath, settings: StreamSettings, network: Network
) -> Iterator[Future[int]]:
    """Stream targets in a thread, which ends with the block."""
    end = StopFlag()
    with ThreadPoolExecutor(1, "stream") as pool:
        try:
            yield pool.submit(stream, robot, path, settings, network, end)
        finally:
            end.request()


def _wait_end(sender: Future[int], others: tuple[Child, ...], stop: StopFlag) -> None:
    while not sender.done() and not stop.requested:
        for one in others:
            one.check()
        time.sleep(0.05)
    if not stop.requested:
        sender.result()


def _end(one: Child) -> None:
    """End a process as Ctrl-C does, and wait for it."""
    if one.process.poll() is None:
        one.process.send_signal(signal.SIGINT)
    try:
        one.process.wait(STOP_TIME)
    except subprocess.TimeoutExpired as error:
        raise DemoError(f"tauten {one.name} did not end within {STOP_TIME:g} s") from error
    one.check()
