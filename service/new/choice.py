"""The meshes of a part that were tried: which one is taken, and what that means."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tauten.service.check import MESH_ERROR, RobotCheck, fits
from tauten.service.new.trial import Reached

LEAST_RATE = 20.0  # Hz; of meshes whose steps fit it, the nearest to the part is taken
FINER = 0.7  # size of the elements of a finer mesh that is advised, in that of the mesh


@dataclass(frozen=True, slots=True)
class Trial:
    """One mesh of the part, half way of the guessed command.

    Attributes:
        size: of its elements [m].
        nodes: of the mesh.
        reached: where the guessed actuators take it.
        step: processor time of a control step [s]; NaN of a mesh that is finer than one whose steps are not
            in time.
        difference: of effort or tip to the finest mesh, the larger of both, relative to its effort and to the
            movement of its tip; NaN where it was moved by another share.
    """

    size: float
    nodes: int
    reached: Reached
    step: float
    difference: float = np.nan

    @property
    def in_time(self) -> bool:
        """Whether a control step fits the period of the least rate."""
        return fits(LEAST_RATE, self.step)


def compared(trials: list[Trial]) -> tuple[Trial, ...]:
    """The trials with their differences to the last; none where one was moved by another share."""
    *coarser, finest = [trial.reached for trial in trials]
    moved = max(finest.moved, 1e-9)
    differences = [
        max(
            abs(one.effort / finest.effort - 1.0),
            float(np.linalg.norm(one.tip - finest.tip)) / moved,
        )
        if one.share == finest.share
        else np.nan
        for one in coarser
    ]
    return tuple(
        replace(one, difference=value)
        for one, value in zip(trials, [*differences, np.nan], strict=True)
    )


def chosen_trial(trials: tuple[Trial, ...], accuracy: float) -> int:
    """Index of the mesh to take.

    The coarsest that is accurate, where its control steps are in time; otherwise the finest whose steps are.
    Where there is none the robot needs a reduced model, whose steps do not grow with the mesh: the coarsest
    that is accurate.
    """
    good = accurate_trial(trials, accuracy)
    if trials[good].in_time:
        return good
    return max((i for i, trial in enumerate(trials) if trial.in_time), default=good)


def accurate_trial(trials: tuple[Trial, ...], accuracy: float) -> int:
    """Index of the coarsest mesh that is accurate, else of the finest."""
    good = (i for i, trial in enumerate(trials) if trial.difference <= accuracy)
    return next(good, len(trials) - 1)


def finer_than(trials: tuple[Trial, ...], taken: Trial) -> float:
    """Size of the elements of a mesh with at least twice the nodes [m].

    Details of a part may need so many that meshes of other sizes have as many: none of those that were tried
    is finer then.
    """
    larger = (one.size for one in trials if one.nodes >= 2 * taken.nodes)
    return next(larger, FINER * trials[-1].size)


def verdict(
    trials: tuple[Trial, ...],
    chosen: int,
    accuracy: float,
    file: Path,
    check: RobotCheck,
    sized: bool,
) -> str:
    """One sentence on mesh and time of a control step, and what to do next.

    Args:
        trials: the meshes that were compared, coarse to fine.
        chosen: index of the one that was taken.
        accuracy: largest difference that is accepted.
        file: the robot file.
        check: of it.
        sized: whether the part can be meshed with other sizes.
    """
    taken, good = trials[chosen], accurate_trial(trials, accuracy)
    reduce = f"tauten reduce {file} --states --write"
    exact = all(item.level == "fine" for item in check.findings if item.subject == MESH_ERROR)
    finer = trials[good].size if good > chosen else finer_than(trials, taken)
    other = f"tauten new with --size {1e3 * finer:.3g}" if sized else "a finer mesh of the part"
    if not taken.in_time:
        nearer = "" if exact else f" Where the error of the mesh is too large: first {other}."
        return (
            f"Verdict: control steps of the full model do not fit even {LEAST_RATE:g} Hz; those of a reduced "
            f"model do not grow with the mesh. Next: {reduce}.{nearer}"
        )
    if exact and good <= chosen:
        return "Verdict: the mesh is fine, and its control steps fit the rate."
    return (
        f"Verdict: this mesh of {taken.nodes:,} nodes holds the rate as it is. Where its error is too large: "
        f"{other}, and then tauten reduce with --states --write, because a finer mesh does not hold the rate."
    )
