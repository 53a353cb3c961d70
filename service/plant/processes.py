"""`tauten` commands as processes on this machine, for the demo and the benchmark of the node."""

from __future__ import annotations

import contextlib
import gc
import os
import random
import signal
import socket
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from tauten.model.kernels import kernel_folder
from tauten.service.link import HOST, ZENOH_CONFIG_VARIABLE
from tauten.service.parent import PARENT, end_with
from tauten.service.process import give_lower_priority

STOP_TIME = 60.0  # s, with the release of the cables, on a machine that is busy with something else
_START = 300.0  # s without a kernel that is compiled
_PORTS = range(28_000, 32_000, 2)


class DemoError(RuntimeError):
    """A process that failed, or a file in the way; the message names it, or the file with its output."""


Program = Callable[[], object]


class Copy:
    """A copy of this process that runs a program; it has the methods of `subprocess.Popen`.

    It has all that this process has imported, loaded and compiled. This process must have started no thread
    of Python and no Zenoh session, which would be missing in the copy.
    """

    def __init__(self, program: Program, output: Path) -> None:
        process = get_context("fork").Process(target=_become, args=(program, output, os.getpid()))
        with warnings.catch_warnings():  # of threads: BLAS ends its own before a fork
            warnings.simplefilter("ignore", DeprecationWarning)
            process.start()
        assert process.pid is not None
        self.pid, self._process = process.pid, process

    def poll(self) -> int | None:
        """The exit code, negative for a signal; None while it runs."""
        return self._process.exitcode

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended, at most so long [s]; returns the exit code.

        Raises:
            TimeoutExpired: it has not.
        """
        self._process.join(timeout)
        code = self.poll()
        if code is None:
            raise subprocess.TimeoutExpired("tauten", timeout or 0.0)
        return code

    def send_signal(self, number: int) -> None:
        """Send it a signal where it has not ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)


# Ctrl-C in a terminal reaches every process of it
INTERRUPTED = (128 + signal.SIGINT, -signal.SIGINT)


@dataclass(slots=True)
class Child:
    """A `tauten` command as a process: its name, the process, the file of its output."""

    name: str
    process: subprocess.Popen[bytes] | Copy
    output: Path

    @property
    def ended(self) -> bool:
        """Whether the process has ended."""
        return self.process.poll() is not None

    @property
    def processor_time(self) -> float:
        """Processor time of the process so far [s]; NaN where the system has no /proc."""
        try:
            facts = Path(f"/proc/{self.process.pid}/stat").read_text(encoding="ascii")
        except OSError:
            return float("nan")
        user, system = facts.rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def give_way(self) -> None:
        """Lower the priority of all threads; a real robot does not use the node's processor, here it does.

        Called when the process is ready: on a busy machine one of low priority takes minutes until it is.
        """
        done: set[int] = set()
        while new := self._threads() - done:  # a thread may have started one before its own turn
            for thread in new:
                with contextlib.suppress(ProcessLookupError):
                    give_lower_priority(thread)
            done |= new

    def _threads(self) -> set[int]:
        """The threads of the process; elsewhere than on Linux a priority is that of the whole process."""
        try:
            return {int(folder.name) for folder in Path(f"/proc/{self.process.pid}/task").iterdir()}
        except OSError:
            return {self.process.pid}

    def check(self) -> None:
        """Check that the process has not ended with an error; an interrupt is none.

        Raises:
            DemoError: it has.
        """
        code = self.process.poll()
        if code not in (None, 0, *INTERRUPTED):
            lines = self.output.read_text(encoding="utf-8", errors="replace").strip().splitlines()
            last = lines[-1].removeprefix("tauten: ") if lines else "no output"
            raise DemoError(f"tauten {self.name} ended with {code}: {last} (see {self.output})")


class StartLimit:
    """How long processes may take to start: a time from now, and from the last kernel that was compiled.

    When a robot runs for the first time on a busy machine, compiling takes many minutes. Each process
    writes a kernel into the folder of kernels as soon as it is compiled.
    """

    def __init__(self, seconds: float = _START) -> None:
        self.seconds = seconds
        self._changed, self._end = _last_compiled(), time.monotonic() + seconds

    def check(self, what: str) -> None:
        """Check that the limit is not exceeded.

        Raises:
            DemoError: it is.
        """
        changed, now = _last_compiled(), time.monotonic()
        if changed != self._changed:
            self._changed, self._end = changed, now + self.seconds
        elif now > self._end:
            raise DemoError(
                f"{what} did not start; no kernel has been compiled for {self.seconds:g} s"
            )


def _last_compiled() -> int:
    """When a kernel was last written [ns]; 0 where there is no folder for them."""
    try:
        return kernel_folder().stat().st_mtime_ns
    except OSError:
        return 0


def free_ports() -> int:
    """The first of two successive TCP ports of loopback that are free.

    No other process gets the same two from this function while the caller's process runs: that process
    holds an abstract Unix socket whose name contains the port, and the kernel closes it when it ends.

    Raises:
        DemoError: there are none.
    """
    for port in random.SystemRandom().sample(_PORTS, len(_PORTS)):
        reservation = socket.socket(socket.AF_UNIX)
        with contextlib.closing(reservation):
            if _can_bind(reservation, f"\0tauten-{port}") and _is_free(port) and _is_free(port + 1):
                reservation.detach()  # stays open until the process ends
                return port
    raise DemoError(f"no two free TCP ports from {_PORTS.start} to {_PORTS.stop} on loopback")


def _is_free(port: int) -> bool:
    with socket.socket() as probe:
        return _can_bind(probe, (HOST, port))


def _can_bind(one: socket.socket, address: str | tuple[str, int]) -> bool:
    try:
        one.bind(address)
    except OSError:
        return False
    return True


@contextlib.contextmanager
def child(
    command: str, arguments: list[str], folder: Path, program: Program | None = None
) -> Iterator[Child]:
    """Run a `tauten` command as a process; it is interrupted, then killed, when the block is left.

    Where this process is killed, so that the block is never left, it is asked to end too (on Linux).

    Args:
        command: name of the command.
        arguments: its arguments.
        folder: of the file with its output, COMMAND.txt.
        program: what a `Copy` of this process runs instead of the command; None: a new process runs that.
    """
    output = folder / f"{command}.txt"
    process = _start(command, arguments, output) if program is None else Copy(program, output)
    try:
        yield Child(command, process, output)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(STOP_TIME)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _start(command: str, arguments: list[str], output: Path) -> subprocess.Popen[bytes]:
    """A command as a process; it stays on loopback, whatever network the user has chosen for a robot."""
    own = {name: value for name, value in os.environ.items() if name != ZENOH_CONFIG_VARIABLE}
    with output.open("wb") as sink:
        return subprocess.Popen(
            [sys.executable, "-m", "tauten.service", command, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=sink,
            stderr=subprocess.STDOUT,
            env={**own, PARENT: str(os.getpid())},
        )


def _become(program: Program, output: Path, parent: int) -> None:
    """Run a program in a copy, without the handlers of signals of the process that was copied."""
    gc.freeze()  # a collection would write to, and so copy, all that the processes share
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGALRM):
        if callable(signal.getsignal(number)):  # a handler of the process that was copied
            interrupts = number is signal.SIGINT
            signal.signal(number, signal.default_int_handler if interrupts else signal.SIG_DFL)
    end_with(parent)
    with output.open("wb") as sink:
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
    program()
