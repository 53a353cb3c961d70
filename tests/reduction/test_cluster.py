"""Campaigns on a Dask cluster of processes: a scheduler and two workers, one of which is killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tauten.model import Robot
from tauten.model.tetra import NodalBody
from tauten.reduction.campaign import Ranges, dask_cluster, latin_hypercube, run_campaign

STARTED = 60.0  # s that a process may take to start on a busy machine


def start(folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """A process of the cluster, listening on this machine only, its output in a file."""
    settings = {**os.environ, "OMP_NUM_THREADS": "1", "DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
    with (folder / f"{arguments[0]}-{time.monotonic_ns()}.log").open("wb") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]],
            env=settings, stdout=log, stderr=log, cwd=folder,
        )  # fmt: skip


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Address of a scheduler, and its two workers."""
    file = tmp_path / "scheduler.json"
    local = ("--host", "127.0.0.1", "--no-dashboard")
    processes = [start(tmp_path, "scheduler", *local, "--port", "0", "--scheduler-file", str(file))]
    try:
        deadline = time.monotonic() + STARTED
        while not file.is_file() and time.monotonic() < deadline:
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        one = ("--nthreads", "1", "--no-nanny", "--local-directory", str(tmp_path))
        processes += [start(tmp_path, "worker", address, *local, *one) for _ in range(2)]
        from distributed import Client  # which takes a while to import

        with Client(address, timeout=STARTED) as client:
            client.wait_for_workers(2, timeout=STARTED)
        yield address, processes[1:]
    finally:
        for process in processes[::-1]:
            process.kill()
            process.wait()


def kill_when_a_chunk_is_saved(
    folder: Path, worker: subprocess.Popen[bytes], done: threading.Event
) -> None:
    while not done.wait(0.01):
        if list(folder.glob("*.snapshots")):
            worker.send_signal(signal.SIGKILL)
            return


@pytest.mark.slow
def test_killed_worker_does_not_change_the_result(
    thumb: Robot[NodalBody], cluster: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path
) -> None:
    """The chunk that was lost is computed again by the other worker."""
    design = latin_hypercube(thumb, Ranges(tilt=0.8, force=0.05), runs=6, seed=1, steps=12)
    expected = run_campaign(thumb, design, tmp_path / "here")
    address, workers = cluster
    folder, done = tmp_path / "cluster", threading.Event()
    watch = threading.Thread(target=kill_when_a_chunk_is_saved, args=(folder, workers[0], done))
    watch.start()
    try:
        with dask_cluster(address) as executor:
            found = run_campaign(thumb, design, folder, executor)
    finally:
        done.set()
        watch.join()
    assert workers[0].wait() == -signal.SIGKILL and workers[1].poll() is None
    assert found.origin == expected.origin
    np.testing.assert_array_equal(found.run, expected.run)
    np.testing.assert_array_equal(found.converged, expected.converged)
    # kernels that a process has just compiled may round otherwise than those read from the cache
    np.testing.assert_allclose(found.q, expected.q, atol=1e-9)
    np.testing.assert_allclose(found.lam, expected.lam, atol=1e-6)
