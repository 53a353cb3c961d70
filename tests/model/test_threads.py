"""Linear algebra takes one thread, whatever the process allows and in whatever order things are imported."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from typing import Any

import numpy as np
import pytest
from support.robots.bodies import beam_robot, box_mesh
from threadpoolctl import threadpool_info, threadpool_limits

from tauten.controller import Controller
from tauten.model import ObstaclePoses, Report, Simulator, one_blas_thread
from tauten.model.numerics import installed_backends, make_factorisation
from tauten.model.numerics.factorisation import Pardiso, mkl
from tauten.model.simulation.search import EquilibriumSearch

SIZE = (0.1, 0.02, 0.02)
# What README's loop does; prints the processor time of the thread that runs the loop and of all others of the
# process, after the first steps.
LOOP = """
import json, resource, time
{imports}
from tauten.controller import Controller
from tauten.model import load_robot

controller = Controller(load_robot("manipulator"), contact="{contact}")
target = controller.effector
for _ in range(3):
    controller.step(target)
whole, own = time.process_time(), time.thread_time()
times = []
for _ in range({steps}):
    begin = time.perf_counter()
    controller.step(target)
    times.append(time.perf_counter() - begin)
own, whole = time.thread_time() - own, time.process_time() - whole
print(json.dumps({{"own": own, "others": whole - own, "median": sorted(times)[len(times) // 2]}}))
"""
FREE = {"OMP_NUM_THREADS": "4", "MKL_NUM_THREADS": "4", "OPENBLAS_NUM_THREADS": "4"}


def run_loop(imports: str, contact: str, steps: int, **environment: str) -> dict[str, float]:
    """The output of `LOOP` in a process of its own."""
    script = LOOP.format(imports=imports, contact=contact, steps=steps)
    done = subprocess.run(
        [sys.executable, "-c", script], env={**os.environ, **environment},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    times: dict[str, float] = json.loads(done.stdout)
    return times


def most_threads() -> int:
    """The largest number of threads of the libraries of dense algebra."""
    return int(max(p["num_threads"] for p in threadpool_info() if p["user_api"] == "blas"))


@pytest.mark.skipif("pardiso" not in installed_backends(), reason="pardiso is not installed")
@pytest.mark.parametrize("threads", [1, 2])
def test_pardiso_has_its_own_number_in_every_phase(
    monkeypatch: pytest.MonkeyPatch, threads: int
) -> None:
    """Also where the process allows three, and where that changes after the analysis."""
    library, seen, dynamic = mkl(), [], mkl().MKL_Get_Dynamic()
    pattern = beam_robot(box_mesh(SIZE, (6, 2, 2)), SIZE).body.pattern
    library.MKL_Set_Dynamic(0)  # else it never takes more threads than there are cores
    original = library.pardiso

    def observed(*arguments: object) -> None:
        seen.append(library.MKL_Get_Max_Threads())
        original(*arguments)

    monkeypatch.setattr(library, "pardiso", observed)
    try:
        with threadpool_limits(3):
            factors = make_factorisation(pattern.indptr, pattern.indices, "pardiso", threads)
            assert isinstance(factors, Pardiso)
            outside = library.MKL_Get_Max_Threads()
        with threadpool_limits(2):
            values = np.zeros(len(pattern.indices))
            values[pattern.diagonal] = 2.0
            twice = factors.fork()
            twice.refactor(values)
            np.testing.assert_allclose(twice.solve(np.ones(pattern.n)), 0.5)
    finally:
        library.MKL_Set_Dynamic(dynamic)
    assert outside == 3, "of the rest of the process"
    assert len(seen) >= 6 and set(seen) == {threads}


def test_dense_algebra_returns_to_what_it_was() -> None:
    with threadpool_limits(2):
        assert most_threads() == 2
        with one_blas_thread():
            assert most_threads() == 1
            with one_blas_thread():
                pass
            assert most_threads() == 1, "the outer one is still entered"
        assert most_threads() == 2


def test_two_threads_of_python_may_leave_in_any_order() -> None:
    """The first to enter leaves first; the number from before both returns at the end."""
    entered, leave = threading.Event(), threading.Event()

    def first() -> None:
        with one_blas_thread():
            entered.set()
            leave.wait(10.0)

    with threadpool_limits(2):
        other = threading.Thread(target=first)
        other.start()
        entered.wait(10.0)
        with one_blas_thread():
            leave.set()
            other.join()
            assert most_threads() == 1
        assert most_threads() == 2


def test_entering_costs_less_than_a_hundredth_of_a_step() -> None:
    """Processor time: 1 µs inside another one, some µs outside; a look for libraries would take 700."""

    @one_blas_thread()
    def nothing() -> None:
        pass

    nothing()
    begin = time.thread_time()
    for _ in range(1000):
        nothing()
    assert time.thread_time() - begin < 0.1


@pytest.mark.long
def test_a_loop_of_a_user_takes_one_thread() -> None:
    """README's loop in a process that could take more: nothing is computed on other threads.

    Of 8 steps with 3500 unknowns; a library that takes a second thread spends as much there as here.
    """
    times = run_loop("import scipy.linalg, numpy", "none", 8, **FREE)
    assert times["others"] < 0.1 * times["own"], times


@pytest.mark.slow
@pytest.mark.parametrize(
    "imports", ["", "import scipy.linalg", "import pypardiso", "import tauten.service.process"]
)
@pytest.mark.parametrize("contact", ["none", "full"])
def test_the_order_of_imports_is_of_no_effect(imports: str, contact: str) -> None:
    times = run_loop(imports, contact, 30, **FREE)
    assert times["others"] < 0.1 * times["own"], times


@pytest.mark.realtime
def test_steps_beside_another_program_take_no_longer_than_on_one_thread() -> None:
    """Medians of the same loop beside a busy process, with the libraries free and held to one thread."""
    one = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        free = [run_loop("", "none", 40, **FREE)["median"] for _ in range(2)]
        held = [run_loop("", "none", 40, **one)["median"] for _ in range(2)]
    finally:
        busy.kill()
        busy.wait()
    assert min(free) < 1.5 * min(held), (free, held)


class Pressed:
    """Ctrl-C is pressed in the middle of the next step."""

    waiting = False

    def press(self) -> None:
        """Once."""
        if self.waiting:
            self.waiting = False
            signal.raise_signal(signal.SIGINT)


class Simulated(Pressed, Simulator):
    """Also a simulator."""

    def set_obstacles(self, poses: ObstaclePoses) -> None:
        super().set_obstacles(poses)
        self.press()


class Controlled(Pressed, Controller):
    """Also a controller."""

    def prepare(self) -> None:
        super().prepare()
        self.press()


def test_a_step_is_whole_where_ctrl_c_is_pressed_in_it() -> None:
    """Where the exception came while numba made a kernel's result, about one of fifty ended the process."""
    robot = beam_robot(box_mesh(SIZE, (4, 1, 1)), SIZE)
    pull = np.full(robot.n_a, 1e-3)
    for name in ("step", "move"):
        simulator, usual = Simulated(robot), Simulator(robot)
        simulator.waiting = True
        with pytest.raises(KeyboardInterrupt):
            getattr(simulator, name)(position=pull)
        getattr(usual, name)(position=pull)
        np.testing.assert_array_equal(simulator.effector_values, usual.effector_values)
    controller, other = Controlled(robot), Controller(robot)
    goal, controller.waiting = other.effector_values + 1e-3, True
    with pytest.raises(KeyboardInterrupt):
        controller.step(goal)
    other.step(goal)
    for _ in range(2):
        found, expected = controller.step(goal), other.step(goal)
        np.testing.assert_array_equal(found.position, expected.position)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


class Settling(Simulator):
    """Ctrl-C is pressed in its search."""

    def _attempt(self, *given: Any) -> Report:
        signal.raise_signal(signal.SIGINT)
        return super()._attempt(*given)


def test_ctrl_c_ends_a_settling_between_two_of_its_steps() -> None:
    """In a kernel it ends the process, and until the end of a settling some robots take a minute."""
    simulator = Settling(beam_robot(box_mesh(SIZE, (4, 1, 1)), SIZE))
    before, begun = simulator.state, []
    with pytest.raises(KeyboardInterrupt), pytest.MonkeyPatch.context() as patched:
        patched.setattr(EquilibriumSearch, "_condensed", lambda *_: begun.append(1))
        simulator.settle(effort=[0.1])
    assert not begun
    np.testing.assert_array_equal(simulator.state.q, before.q)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_waits_once_and_only_for_python_s_own_handler() -> None:
    done = []

    @one_blas_thread(whole=True)
    def press(times: int) -> None:
        for _ in range(times):
            signal.raise_signal(signal.SIGINT)
            done.append(times)

    for times, passed in ((1, [1]), (2, [1, 2])):
        with pytest.raises(KeyboardInterrupt):
            press(times)
        assert done == passed
    with pytest.raises(KeyboardInterrupt), one_blas_thread():  # as loops do
        press(1)
    assert done == [1, 2, 1]
    handler = signal.signal(signal.SIGINT, lambda *_: done.append(0))
    try:
        press(1)
    finally:
        signal.signal(signal.SIGINT, handler)
    assert done == [1, 2, 1, 0, 1]
    thread = threading.Thread(target=one_blas_thread(whole=True)(done.append), args=(7,))
    thread.start()
    thread.join()
    assert done[-1] == 7
