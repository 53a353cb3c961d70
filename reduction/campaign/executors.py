"""Executors for the chunks of a campaign: this process, several processes, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from typing import Any, TypeVar

T = TypeVar("T")


class ClusterError(RuntimeError):
    """A cluster that cannot be used; the text explains what to do."""


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C to this thread and, for all of their time, to the processes that it starts meanwhile."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class InProcess(Executor):
    """Computes immediately, in this process."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """A finished future; exceptions, Ctrl-C among them, are raised immediately."""
        future: Future[T] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


class Processes(ProcessPoolExecutor):
    """Processes to which Ctrl-C is blocked from their start on; the parent handles it.

    One that Ctrl-C ends while it imports leaves the pool waiting for ever for what nobody reads.
    """

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """A future of a call, for which a process may start."""
        with interrupts_blocked():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Processes on this machine, which Ctrl-C does not reach; a single worker is this process.

    Raises:
        ValueError: fewer than one worker.
    """
    if workers < 1:
        raise ValueError(f"{workers} workers requested: at least 1 is needed")
    if workers == 1:
        yield InProcess()
        return
    context = multiprocessing.get_context("spawn")  # a fork would copy the locks of our threads
    with Processes(workers, mp_context=context, initializer=_begin) as pool:
        yield pool


@contextmanager
def dask_cluster(address: str, timeout: float = 10.0) -> Iterator[Executor]:
    """A Dask cluster whose scheduler listens at `tcp://host:port`; needs `tauten[cluster]`.

    Raises:
        ClusterError: `distributed` is not installed, or no scheduler replies within `timeout` [s].
    """
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        raise ClusterError(
            "a Dask cluster needs the package distributed: pip install -e '.[cluster]' in the clone of tauten"
        ) from error
    try:
        client = distributed.Client(address, timeout=timeout)
    except (OSError, ValueError) as error:
        raise ClusterError(f"no Dask scheduler replies at {address!r} ({error})") from error
    with client:
        yield client.get_executor(pure=False)


def _begin() -> None:
    """One thread per worker, set before MKL is loaded, and an end with the process that started it."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for library in ("OMP", "MKL", "OPENBLAS"):
        os.environ[f"{library}_NUM_THREADS"] = "1"


def _end_with_parent() -> None:
    """Wait for the end of the process that started this one, and end: nobody takes what it computes."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
