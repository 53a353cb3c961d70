"""What simulated robots of controllers under test are asked for, and files with other values."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from tauten.model import Report, Simulator
from tauten.model.numerics import Array
from tauten.service.plant import DrivenRobot, own_steps

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


class ObservedRobot(DrivenRobot):
    """A simulated robot that keeps what is seen of it after each period since its start.

    Attributes:
        seen: one row a period.
    """

    def __init__(
        self, simulator: Simulator, steps: int, observe: Callable[[Simulator], Array]
    ) -> None:
        """Of a simulator at its start.

        Args:
            simulator: of the robot.
            steps: in a period.
            observe: what is seen.
        """
        super().__init__(simulator, steps)
        self.seen = list[Array]()
        self._observe = observe

    def reset(self) -> None:
        """Return to the simulator's start."""
        super().reset()
        self.seen.clear()

    def move(self, position: Array, effort: Array) -> Report:
        """One period under commands, see `DrivenRobot.move`."""
        report = super().move(position, effort)
        self.seen.append(self._observe(self.simulator))
        return report


def observed(
    simulator: Simulator, observe: Callable[[Simulator], Array], steps: int | None
) -> ObservedRobot:
    """A simulated robot that starts from its equilibrium.

    Args:
        simulator: of the robot.
        observe: what is seen.
        steps: in a period; None: as many as a trial motion needs.
    """
    simulator.settle_start()
    return ObservedRobot(simulator, steps or own_steps(simulator).count, observe)


def changed_example(file: str, folder: Path, changes: Mapping[str, str]) -> Path:
    """A robot file of the examples, and those of its parts, with other text.

    Args:
        file: its name.
        folder: into which all files of the examples go.
        changes: what is replaced by what; each occurs in one of the files at least.
    """
    missing = set(changes)
    for path in [*EXAMPLES.glob("*.vtu"), *EXAMPLES.glob("*.stl")]:
        shutil.copy(path, folder)
    for path in EXAMPLES.glob("*.toml"):
        text = path.read_text(encoding="utf-8")
        for old, new in changes.items():
            missing -= {old} if old in text else set()
            text = text.replace(old, new)
        (folder / path.name).write_text(text, encoding="utf-8")
    assert not missing, missing
    return folder / file


def force_of(simulator: Simulator, pair: int) -> Array:
    """The force (3,) on the candidates of a pair [N]."""
    found = simulator.contacts
    force: Array = found.force[found.contacts.pair == pair].sum(axis=0)
    return force


def ramp(ticks: int) -> Array:
    """From 0 to 1, smoothly: (ticks,)."""
    share = np.arange(1, ticks + 1) / ticks
    found: Array = share * share * (3.0 - 2.0 * share)
    return found
