"""Campaigns: snapshots of all runs of a design, computed in parallel, resumable."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

from tauten.model import Robot
from tauten.reduction.campaign.chunk import Chunk, solve_chunk
from tauten.reduction.campaign.command_range import Report
from tauten.reduction.campaign.designs import Design
from tauten.reduction.campaign.executors import InProcess
from tauten.reduction.campaign.snapshots import (
    SUFFIX,
    Origin,
    SnapshotError,
    Snapshots,
    join_snapshots,
)
from tauten.reduction.provenance import package_versions

log = logging.getLogger(__name__)

CHUNK = 20  # equilibria in a chunk: a killed campaign loses a few seconds of work


def run_campaign(
    robot: Robot,
    design: Design,
    folder: str | Path,
    executor: Executor | None = None,
    report: Report = lambda share, what: None,
    announce: Callable[[int, float], None] | None = None,
) -> Snapshots:
    """Compute all equilibria of a design, except those that the folder already holds.

    Runs are independent and are distributed to the executor's workers; the equilibria of a run follow one
    another. The result depends neither on the executor nor on interruptions. On Ctrl-C the chunks in
    progress are finished and saved before KeyboardInterrupt is raised again.

    Args:
        robot: the robot.
        design: runs of excitations.
        folder: of the saved chunks; one campaign in each folder, made when missing.
        executor: see `tauten.reduction.campaign.executors`; None computes in this process.
        report: called with the share of the equilibria that are new, first of those in the folder, then after
            each chunk, and with how many there are in words.
        announce: called before with the number of equilibria that are not in the folder, and with about the
            time of one of them in this process by the real clock [s]; not where none is left.

    Raises:
        SnapshotError: the folder holds another campaign, or a damaged file.
    """
    ledger = _Ledger.open(robot, design, Path(folder))

    def advance(count: int) -> None:
        report(count / design.size, f"snapshots {ledger.size} of {design.size}")

    first = filter(None, map(ledger.next_chunk, range(len(design.runs))))
    if announce is not None and (chunk := next(first, None)) is not None:
        report(0.0, "time of an equilibrium")
        announce(design.size - ledger.size, _equilibrium_seconds(chunk))
    advance(ledger.size)
    _work(ledger, executor or InProcess(), advance)
    return join_snapshots([part for parts in ledger.parts for part in parts])


def _equilibrium_seconds(chunk: Chunk) -> float:
    """Time of the first equilibrium of a chunk in this process, by the real clock [s]."""
    one = replace(chunk, run=chunk.run.piece(0, 1))
    solve_chunk(one)  # kernels are loaded or compiled
    begin = perf_counter()
    solve_chunk(one)
    return perf_counter() - begin


@dataclass(frozen=True, slots=True)
class _Ledger:
    """Progress of a campaign.

    Attributes:
        robot, design, folder: as in `run_campaign`.
        origin: of its snapshots.
        parts: the finished chunks of every run, in order.
    """

    robot: Robot
    design: Design
    folder: Path
    origin: Origin
    parts: tuple[list[Snapshots], ...]

    @classmethod
    def open(cls, robot: Robot, design: Design, folder: Path) -> _Ledger:
        """Read the finished chunks from the folder."""
        campaign = f"{design.description} [{design.digest()[:12]}]"
        origin = Origin(robot.name, robot.digest, campaign, package_versions())
        ledger = cls(robot, design, folder, origin, tuple([] for _ in design.runs))
        for index, run in enumerate(design.runs):
            while ledger.count(index) < len(run) and ledger.path(index).exists():
                left = len(run) - ledger.count(index)
                ledger.parts[index].append(ledger.load(ledger.path(index), left))
        return ledger

    @property
    def size(self) -> int:
        """Number of finished equilibria."""
        return sum(self.count(index) for index in range(len(self.parts)))

    def count(self, index: int) -> int:
        """Number of finished equilibria of a run."""
        return sum(len(part) for part in self.parts[index])

    def path(self, index: int) -> Path:
        """File of the next chunk of a run."""
        return self.folder / f"run{index:04d}-{self.count(index):06d}{SUFFIX}"

    def load(self, path: Path, most: int) -> Snapshots:
        """A chunk of this campaign."""
        part = Snapshots.load(path)
        if part.origin != self.origin:
            raise SnapshotError(
                f"{self.folder}: holds another campaign ({part.origin.difference(self.origin)}): "
                "delete this folder, or choose another with --snapshots"
            )
        robot = self.robot
        found = (len(part.lam), len(part.q), len(part.position), len(part.effector))
        expected = (robot.n_c, len(robot.rest().q), robot.n_a, 3 * len(robot.effector_names))
        if found != expected or not 0 < len(part) <= most:
            raise SnapshotError(
                f"{path}: has {len(part)} columns with {found} rows of lam, q, pull and effector, "
                f"expected 1 to {most} columns with {expected}"
            )
        return part

    def keep(self, index: int, part: Snapshots) -> None:
        """Save the next chunk of a run."""
        part.save(self.path(index))
        self.parts[index].append(part)

    def next_chunk(self, index: int) -> Chunk | None:
        """The next chunk of a run, or None when the run is complete."""
        run, first, parts = self.design.runs[index], self.count(index), self.parts[index]
        if first == len(run):
            return None
        start = (parts[-1].q[:, -1], parts[-1].effort[:, -1]) if parts else None
        piece = run.piece(first, first + CHUNK)
        return Chunk(self.robot, self.origin, piece, index, start)


def _work(ledger: _Ledger, executor: Executor, advance: Callable[[int], None]) -> None:
    """Submit the next chunk of a run as soon as the previous one is finished."""
    pending: dict[Future[Snapshots], int] = {}
    to_begin = deque(range(len(ledger.parts)))

    def send(index: int) -> None:
        if (chunk := ledger.next_chunk(index)) is not None:
            pending[executor.submit(solve_chunk, chunk)] = index

    def collect(future: Future[Snapshots]) -> int:
        index = pending.pop(future)
        part = future.result()
        ledger.keep(index, part)
        advance(len(part))
        return index

    try:
        while to_begin or pending:
            if to_begin:
                send(to_begin.popleft())  # finished at once, where this process computes
            for future in wait(pending, 0.0 if to_begin else None, FIRST_COMPLETED).done:
                send(collect(future))
    except KeyboardInterrupt:
        begun = [future for future in pending if not future.cancel()]
        log.info("interrupted: what is under way in %d processes is finished and kept", len(begun))
        for future in begun:
            with suppress(Exception):  # of workers that Ctrl-C has ended too; computed again
                collect(future)
        raise
