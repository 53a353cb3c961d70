import dataclasses
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.processes import START
from support.robots.small_bodies import constrained

from tauten.model import Robot
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import (
    Design,
    Ranges,
    SnapshotError,
    Snapshots,
    executors,
    latin_hypercube,
    ramp,
    run_campaign,
)
from tauten.reduction.campaign import run as campaign
from tauten.reduction.campaign.chunk import Chunk, solve_chunk

STEPS = 6


class StopsBefore(Executor):
    """Ctrl-C before the n-th chunk."""

    left: int

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        return super().submit(fn, *args, **kwargs)


class Interrupted(StopsBefore, executors.InProcess):
    """One chunk after the other."""

    def __init__(self, chunks: int) -> None:
        self.left = chunks


class InterruptedThreads(StopsBefore, ThreadPoolExecutor):
    """Chunks of all runs at the same time."""

    def __init__(self, chunks: int) -> None:
        super().__init__(chunks)
        self.left = chunks


def assert_same(one: Snapshots, other: Snapshots) -> None:
    assert one.origin == other.origin
    for field in dataclasses.fields(Snapshots):
        if field.name != "origin":
            np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))


@pytest.fixture(scope="module", autouse=True)
def short_chunks() -> Iterator[None]:
    """Chunks of 5 equilibria instead of 50, for the sake of time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(campaign, "CHUNK", 5)
        yield


@pytest.fixture(scope="module")
def design(thumb: Robot[NodalBody], short_chunks: None) -> Design:
    """Three runs of two chunks each, the second shorter."""
    ranges = Ranges(position=(0.5, 1.0), tilt=0.8, force=0.05)
    return latin_hypercube(thumb, ranges, runs=3, seed=1, steps=STEPS)


@pytest.fixture(scope="module")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of `snapshots`."""
    return tmp_path_factory.mktemp("whole")


@pytest.fixture(scope="module")
def snapshots(thumb: Robot[NodalBody], design: Design, complete: Path) -> Snapshots:
    return run_campaign(thumb, design, complete)


def test_snapshots_are_as_in_the_design(
    thumb: Robot[NodalBody], design: Design, snapshots: Snapshots
) -> None:
    assert len(snapshots) == design.size
    assert np.count_nonzero(~snapshots.converged) <= 2
    np.testing.assert_array_equal(
        snapshots.position, np.hstack([run.position for run in design.runs])
    )
    np.testing.assert_array_equal(snapshots.run, np.repeat([0, 1, 2], STEPS))
    assert snapshots.lam.min() >= 0.0
    assert (snapshots.lam[:, snapshots.run == 0].sum(axis=0)[-1]) > 1.0, "the notches closed"
    assert not snapshots.lam[:, 0].any(), "nothing touches at the first step"


def test_recorded_forces_hold_the_robot_in_place(
    thumb: Robot[NodalBody], design: Design, snapshots: Snapshots
) -> None:
    """Force balance at a recorded equilibrium: body, cable and contact forces sum to zero."""
    for i in (STEPS - 1, len(snapshots) - 1):
        robot = thumb.loaded(snapshots.gravity[:, i], snapshots.effector_force[:, i])
        state = dataclasses.replace(robot.rest(), q=snapshots.q[:, i])
        rows = robot.rows(state)
        body, _ = robot.forces(state)
        cable = rows.actuators.H.T @ snapshots.effort[:, i]
        contact = rows.contacts.rows.H.T @ snapshots.lam[rows.contacts.slots, i]
        assert np.linalg.norm(contact) > 0.1
        assert np.linalg.norm(body + cable + contact) < 1e-3 * np.linalg.norm(contact)
        np.testing.assert_allclose(rows.actuators.delta, snapshots.position[:, i], atol=1e-7)
        np.testing.assert_allclose(robot.effector(state).ravel(), snapshots.effector[:, i])


@pytest.mark.long
@pytest.mark.parametrize("chunks", [*(pytest.param(n, marks=pytest.mark.slow) for n in (0, 1)), 4])
def test_interrupted_campaign_goes_on_to_the_same_result(
    thumb: Robot[NodalBody], design: Design, snapshots: Snapshots, tmp_path: Path, chunks: int
) -> None:
    with pytest.raises(KeyboardInterrupt):
        run_campaign(thumb, design, tmp_path, Interrupted(chunks))
    assert len(list(tmp_path.glob("*.snapshots"))) == chunks
    again = run_campaign(thumb, design, tmp_path, Interrupted(6 - chunks))
    assert_same(again, snapshots)


def test_complete_campaign_is_not_done_again(
    thumb: Robot[NodalBody], design: Design, snapshots: Snapshots, complete: Path
) -> None:
    said: list[tuple[float, str]] = []
    found = run_campaign(thumb, design, complete, Interrupted(0), lambda *part: said.append(part))
    assert_same(found, snapshots)
    assert said == [(1.0, f"snapshots {design.size} of {design.size}")]


def test_a_campaign_says_after_each_chunk_how_far_it_is(
    thumb: Robot[NodalBody], tmp_path: Path
) -> None:
    said: list[tuple[float, str]] = []
    design = ramp(thumb, step=0.001)
    run_campaign(thumb, design, tmp_path, report=lambda *part: said.append(part))
    assert said[0] == (0.0, f"snapshots 0 of {design.size}") and len(said) > 1
    assert sum(share for share, _ in said) == pytest.approx(1.0)
    assert said[-1][1] == f"snapshots {design.size} of {design.size}"


@pytest.mark.long
def test_workers_do_not_change_the_result_and_do_not_hear_ctrl_c_while_they_start(
    thumb: Robot[NodalBody], design: Design, snapshots: Snapshots, tmp_path: Path
) -> None:
    """One that it ended while it imported left `tauten reduce` waiting for ever.

    Results are the same to rounding: kernels that a worker has just compiled may round otherwise than
    those on disk.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    with executors.processes(2) as pool:
        pool.submit(os.getpid)
        assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == before
        (worker,) = pool._processes  # while it imports
        os.kill(worker, signal.SIGINT)
        found = run_campaign(thumb, design, tmp_path, pool)
        assert pool._processes[worker].is_alive()
    np.testing.assert_array_equal(found.converged, snapshots.converged)
    np.testing.assert_allclose(found.q, snapshots.q, atol=1e-9)
    np.testing.assert_allclose(found.lam, snapshots.lam, atol=1e-6)


ENDED = """
import os, signal
from tauten.reduction.campaign import executors

if __name__ == "__main__":
    with executors.processes(2) as pool:
        print(pool.submit(os.getpid).result(), flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.long
def test_workers_end_with_the_process_that_started_them(tmp_path: Path) -> None:
    """They stayed for ever, with a GB each, where `tauten reduce` was ended by SIGTERM or SIGKILL."""
    script = tmp_path / "ended.py"
    script.write_text(ENDED)
    # ends where nobody has its output any more
    done = subprocess.run([sys.executable, script], stdout=subprocess.PIPE, timeout=START)
    assert done.returncode == -signal.SIGKILL
    assert int(done.stdout) > 0


def test_ctrl_c_saves_what_is_under_way(
    thumb: Robot[NodalBody], design: Design, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The interrupt comes when the first of three chunks is back: all three are kept."""
    caplog.set_level("INFO")
    with pytest.raises(KeyboardInterrupt), InterruptedThreads(chunks=3) as threads:
        run_campaign(thumb, design, tmp_path, threads)
    starts = sorted(path.name for path in tmp_path.iterdir())
    assert starts == [f"run{run:04d}-000000.snapshots" for run in range(3)]
    assert "interrupted: what is under way" in caplog.text


def test_ctrl_c_in_the_only_process_keeps_what_is_done(
    thumb: Robot[NodalBody], design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As with `--workers 1`: the interrupt comes while the third chunk is computed."""
    chunks = iter(range(6))

    def solve(chunk: Chunk) -> Snapshots:
        if next(chunks) == 2:
            raise KeyboardInterrupt
        return solve_chunk(chunk)

    monkeypatch.setattr(campaign, "solve_chunk", solve)
    with pytest.raises(KeyboardInterrupt), executors.processes(1) as here:
        run_campaign(thumb, design, tmp_path, here)
    kept = sorted(path.name for path in tmp_path.iterdir())
    assert kept == ["run0000-000000.snapshots", "run0000-000005.snapshots"]


class Failing(executors.InProcess):
    """The first chunk is back; while the third is sent the second one's worker fails, by Ctrl-C."""

    def __init__(self, first: Snapshots) -> None:
        self.first = first
        self.sent: list[Future[Any]] = []

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        if len(self.sent) == 2:
            self.sent[1].set_exception(BrokenProcessPool("its worker was just starting"))
            raise KeyboardInterrupt
        self.sent.append(Future())
        if len(self.sent) == 1:
            self.sent[0].set_result(self.first)
        return self.sent[-1]


def test_workers_that_fail_at_ctrl_c_do_not_hide_it(
    thumb: Robot[NodalBody], design: Design, snapshots: Snapshots, complete: Path, tmp_path: Path
) -> None:
    name = "run0000-000000.snapshots"
    with pytest.raises(KeyboardInterrupt):
        run_campaign(thumb, design, tmp_path, Failing(Snapshots.load(complete / name)))
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_folder_of_another_campaign_is_left_alone(thumb: Robot[NodalBody], tmp_path: Path) -> None:
    run_campaign(thumb, ramp(thumb, step=0.004), tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(SnapshotError, match="holds another campaign"):
        run_campaign(thumb, ramp(thumb, step=0.002), tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_damaged_chunk_is_named(thumb: Robot[NodalBody], tmp_path: Path) -> None:
    run_campaign(thumb, ramp(thumb, step=0.004), tmp_path)
    (path,) = tmp_path.iterdir()
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(SnapshotError, match=r"run0000-000000\.snapshots: this is no readable"):
        run_campaign(thumb, ramp(thumb, step=0.004), tmp_path)


@pytest.mark.long
def test_impossible_equilibrium_is_recorded_as_such(
    thumb: Robot[NodalBody], tmp_path: Path
) -> None:
    """A force that tears the robot out of the linear range: not converged, and the run goes on."""
    (run,) = ramp(thumb, step=0.002).runs
    force = np.zeros((3, len(run)))
    force[2, 2] = -1e6
    design = Design("torn", (dataclasses.replace(run, effector_force=force),))
    found = run_campaign(thumb, design, tmp_path)
    np.testing.assert_array_equal(found.converged, [True, True, False, True])
    assert not found.lam[:, 2].any()
    np.testing.assert_array_equal(found.q[:, 2], found.q[:, 1])


def test_gravity_and_force_change_the_weight_alone(thumb: Robot[NodalBody]) -> None:
    same = thumb.loaded(thumb.gravity, np.zeros(3))
    np.testing.assert_allclose(same.body.tetrahedra.load, thumb.body.tetrahedra.load)
    pushed = thumb.loaded(np.zeros(3), np.array([0.0, 0.0, 0.3]))
    np.testing.assert_allclose(
        pushed.body.tetrahedra.load.reshape(-1, 3).sum(axis=0), [0.0, 0.0, 0.3]
    )


def test_worker_counts(thumb: Robot[NodalBody]) -> None:
    with pytest.raises(ValueError, match="0 workers requested"), executors.processes(0):
        pass


@pytest.mark.long
def test_dask_without_a_scheduler_is_a_sentence() -> None:
    with (
        pytest.raises(executors.ClusterError, match=r"distributed|no Dask scheduler replies"),
        executors.dask_cluster("tcp://127.0.0.1:9", timeout=0.5),
    ):
        pass


def test_a_campaign_with_rotations_is_read_again(tmp_path: Path) -> None:
    """A rigid region has seven coordinates and six velocities: snapshots hold the coordinates."""
    end = {"kind": "half_space", "point": [0.0874, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
    robot = constrained(rigid=[{"name": "tip", "region": end}])
    plan = latin_hypercube(robot, Ranges(position=(0.1, 0.2)), runs=1, seed=0, steps=4)
    first, second = (run_campaign(robot, plan, tmp_path) for _ in range(2))
    assert len(first.q) == robot.n + 1
    assert_same(first, second)
