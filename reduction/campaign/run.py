"""Campaigns: the runs of a design made into snapshots, in parallel, resumable, with a bar."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from pathlib import Path

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from tauten.model import Robot
from tauten.reduction.campaign.chunk import Start, Task, visit
from tauten.reduction.campaign.designs import Design
from tauten.reduction.campaign.executors import InProcess
from tauten.reduction.campaign.snapshots import SUFFIX, Origin, SnapshotError, Snapshots, join
from tauten.reduction.provenance import versions

CHUNK = 50  # equilibria a chunk: a few seconds of work are lost when a campaign is killed


def run_campaign(
    robot: Robot,
    design: Design,
    folder: str | Path,
    executor: Executor | None = None,
    show_progress: bool = True,
) -> Snapshots:
    """Visit all equilibria of a design; what the folder already holds is not done again.

    Runs are independent and go to the executor's workers; the equilibria of a run follow one
    another. The result depends neither on the executor nor on interruptions. On Ctrl-C the chunks
    under way are finished and saved before KeyboardInterrupt goes on.

    Args:
        robot: whose contact forces are wanted.
        design: what it is shown.
        folder: where chunks are kept; one campaign a folder, made when missing.
        executor: see `tauten.reduction.campaign.executors`; None works in this process.
        show_progress: draw a bar on the terminal.

    Raises:
        SnapshotError: the folder holds another campaign, or a damaged file.
    """
    ledger = _Ledger.open(robot, design, Path(folder))
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeRemainingColumn(), disable=not show_progress) as progress:
        bar = progress.add_task("snapshots", total=design.size, completed=ledger.size)
        _work(ledger, executor or InProcess(), lambda count: progress.advance(bar, count))
    return join([part for parts in ledger.parts for part in parts])


@dataclass(frozen=True, slots=True)
class _Ledger:
    """What of a campaign is done.

    Attributes:
        robot, design, folder: as in `run_campaign`.
        origin: of its snapshots.
        parts: the chunks done of every run, from its start on.
    """

    robot: Robot
    design: Design
    folder: Path
    origin: Origin
    parts: tuple[list[Snapshots], ...]

    @classmethod
    def open(cls, robot: Robot, design: Design, folder: Path) -> _Ledger:
        """Read what the folder holds."""
        campaign = f"{design.description} [{design.digest()[:12]}]"
        origin = Origin(robot.name, robot.digest, campaign, versions())
        ledger = cls(robot, design, folder, origin, tuple([] for _ in design.runs))
        for index, run in enumerate(design.runs):
            while ledger.count(index) < len(run) and ledger.path(index).exists():
                ledger.parts[index].append(ledger.load(ledger.path(index)))
        return ledger

    @property
    def size(self) -> int:
        """Number of equilibria done."""
        return sum(self.count(index) for index in range(len(self.parts)))

    def count(self, index: int) -> int:
        """Number of equilibria done of a run."""
        return sum(len(part) for part in self.parts[index])

    def path(self, index: int) -> Path:
        """File of the next chunk of a run."""
        return self.folder / f"run{index:04d}-{self.count(index):06d}{SUFFIX}"

    def load(self, path: Path) -> Snapshots:
        """A chunk of this campaign."""
        part = Snapshots.load(path)
        if part.origin != self.origin:
            raise SnapshotError(
                f"{path}: belongs to another campaign ({part.origin}), expected {self.origin}: "
                "choose another folder"
            )
        return part

    def keep(self, index: int, part: Snapshots) -> None:
        """Save the next chunk of a run."""
        part.save(self.path(index))
        self.parts[index].append(part)

    def next_task(self, index: int) -> Task | None:
        """The next chunk of a run, or None when the run is complete."""
        run, first, parts = self.design.runs[index], self.count(index), self.parts[index]
        if first == len(run):
            return None
        start = Start(parts[-1].q[:, -1], parts[-1].tension[:, -1]) if parts else None
        piece = run.piece(first, first + CHUNK)
        return Task(self.robot, self.origin, piece, index, start)


def _work(ledger: _Ledger, executor: Executor, advance: Callable[[int], None]) -> None:
    """Send out the next chunk of every run whenever the one before is back."""
    pending: dict[Future[Snapshots], int] = {}

    def send(index: int) -> None:
        if (task := ledger.next_task(index)) is not None:
            pending[executor.submit(visit, task)] = index

    def collect(future: Future[Snapshots]) -> int:
        index = pending.pop(future)
        part = future.result()
        ledger.keep(index, part)
        advance(len(part))
        return index

    try:
        for index in range(len(ledger.parts)):
            send(index)
        while pending:
            for future in wait(pending, return_when=FIRST_COMPLETED).done:
                send(collect(future))
    except KeyboardInterrupt:
        for future in [future for future in pending if not future.cancel()]:
            collect(future)
        raise
