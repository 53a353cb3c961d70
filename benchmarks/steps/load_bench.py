"""`python -m benchmarks load-errors`: reduced against full models where they were not trained."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.steps.load_comparison import LoadKind, load_errors
from tauten.model import one_blas_thread
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.setup import load_setup


@dataclass(frozen=True, slots=True)
class LoadRow:
    """Distances of the effectors of reduced and full model under loads of one kind.

    Attributes:
        kind: of the loads, see `benchmarks.steps.ForeignLoadError`.
        cases: equilibria, or time steps.
        lost: those that only the full model found.
        mean_mm: mean distance; None without cases.
        max_mm: the largest; None without cases.
        at: where the largest is.
    """

    kind: LoadKind
    cases: int
    lost: int
    mean_mm: float | None
    max_mm: float | None
    at: str


@dataclass(frozen=True, slots=True)
class RobotLoads:
    """One robot.

    Attributes:
        robot: its name.
        size_mm: of the robot.
        state_modes: r of its state basis.
        sampled: elements in its sample.
        loads: errors, a kind of loads each.
    """

    robot: str
    size_mm: float
    state_modes: int
    sampled: int
    loads: tuple[LoadRow, ...]


@dataclass(frozen=True, slots=True)
class LoadBench:
    """Everything `python -m benchmarks load-errors` measures."""

    machine: HostInfo
    robots: tuple[RobotLoads, ...]


def bench_load_errors(names: tuple[str, ...], progress: Progress) -> LoadBench:
    """Compare reduced models with full ones under loads and in motions that took no part in the training.

    Args:
        names: of shipped robots, or robot files, with a state basis.
        progress: called with the share of the work done and what comes next.

    Raises:
        RobotFileError, StateBasisError: a robot that cannot be loaded, or has no reduced model.
    """
    rows = []
    with one_blas_thread():
        for name in names:
            rows.append(_loads(name, progress))
            progress(1.0 / len(names), name)
    return LoadBench(host_info(), tuple(rows))


def _loads(name: str, progress: Progress) -> RobotLoads:
    """All errors of one robot.

    Args:
        name: of a shipped robot, or a robot file.
        progress: called with what comes next.
    """

    def say(what: str) -> None:
        progress(0.0, f"{name}: {what}")

    setup = load_setup(name, model="reduced", accept_error=True)
    full = load_setup(name, model="full").robot
    assert setup.reduced is not None
    return RobotLoads(
        robot=full.name,
        size_mm=1e3 * full.size,
        state_modes=sum(basis.origin.r for basis in setup.states),
        sampled=sum(basis.origin.sample for basis in setup.states),
        loads=tuple(
            LoadRow(
                found.kind,
                found.cases,
                found.lost,
                1e3 * found.mean if found.cases else None,
                1e3 * found.largest if found.cases else None,
                found.at,
            )
            for found in load_errors(full, setup.reduced, setup.contact, say)
        ),
    )
