"""StateBasis: configurations as combinations of a few modes (14), and the elements that stand for all."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from tauten.model import Robot
from tauten.model.numerics import Array, Ints
from tauten.reduction.storage import DamagedFile, UnknownFile, located, read, write

SUFFIX = ".states"
_KIND = "tauten state basis"


class StateBasisError(ValueError):
    """A state basis that cannot be used; the text says which one, what was found and what fits."""


@dataclass(frozen=True, slots=True)
class StateOrigin:
    """Where a state basis and its sample of elements come from.

    Attributes:
        robot: name of the robot.
        robot_digest: sha256 of its model; a state basis fits no other one.
        campaign: one line that says which snapshots.
        snapshots_digest: sha256 of their contact forces, the same as in the contact basis.
        snapshots: number of states.
        r: number of modes.
        responses: how many of them are static responses instead of modes of motion.
        projection_error: root mean square of the motion left out, relative.
        sample: number of elements in the sample.
        sample_tolerance: relative residual asked for when they were chosen.
        sample_error: relative residual reached.
        tip_mean, tip_max: distance of the tip from the full model's on held-out paths [m]; NaN unchecked.
        seed: of what is random.
        created: date and time, ISO 8601 in UTC.
        versions: (package, version) pairs, Python among them.
    """

    robot: str
    robot_digest: str
    campaign: str
    snapshots_digest: str
    snapshots: int
    r: int
    responses: int
    projection_error: float
    sample: int
    sample_tolerance: float
    sample_error: float
    tip_mean: float
    tip_max: float
    seed: int
    created: str
    versions: tuple[tuple[str, str], ...]

    @classmethod
    def from_dict(cls, entries: dict[str, Any]) -> StateOrigin:
        """From what `dataclasses.asdict` gave, through JSON.

        Raises:
            KeyError, TypeError, ValueError: an entry is missing or of another type.
        """
        values = {field.name: entries[field.name] for field in fields(cls)}
        values["versions"] = tuple((str(name), str(found)) for name, found in values["versions"])
        return cls(**values)


@dataclass(frozen=True, slots=True, eq=False)
class StateBasis:
    """State modes of one robot, with the elements its forces are summed over.

    Attributes:
        Phi: (n, r) modes, orthonormal in the mass (`tauten.reduction.state.modes`).
        elements: (s,) numbers of the sampled elements, ascending.
        weights: (s,) how many elements each stands for, positive.
        origin: where it comes from.
    """

    Phi: Array
    elements: Ints
    weights: Array
    origin: StateOrigin

    def __post_init__(self) -> None:
        if self.Phi.ndim != 2 or self.Phi.shape[1] != self.origin.r:
            raise StateBasisError(
                f"Phi has shape {self.Phi.shape}: expected (n, {self.origin.r}), r as in the origin"
            )
        if not np.isfinite(self.Phi).all():
            raise StateBasisError("Phi has entries that are not finite")
        if self.elements.shape != self.weights.shape or not (self.weights > 0.0).all():
            raise StateBasisError(
                f"{len(self.elements)} elements and {len(self.weights)} weights: "
                "expected one positive weight an element"
            )

    @property
    def r(self) -> int:
        """Number of modes."""
        return int(self.Phi.shape[1])

    def digest(self) -> str:
        """SHA-256 of modes, elements and weights."""
        hasher = hashlib.sha256()
        for array in (self.Phi, self.elements, self.weights):
            hasher.update(np.ascontiguousarray(array).tobytes())
        return hasher.hexdigest()

    def with_tip_errors(self, mean: float, largest: float) -> StateBasis:
        """The same with what it errs on held-out paths [m]."""
        return replace(self, origin=replace(self.origin, tip_mean=mean, tip_max=largest))

    def check_tip(self, allowed: float) -> None:
        """Make sure that its tip error on held-out paths is within what a robot file allows [m].

        Raises:
            StateBasisError: it is larger, or was never measured.
        """
        if not self.origin.tip_max <= allowed:
            raise StateBasisError(
                f"this state basis takes the tip up to {1e3 * self.origin.tip_max:.3g} mm (mean "
                f"{1e3 * self.origin.tip_mean:.3g} mm) from where the full model takes it, allowed are "
                f"{1e3 * allowed:.3g} mm: use more modes, a finer sample or a wider campaign, or accept "
                "the error"
            )

    def check_robot(self, robot: Robot) -> None:
        """Make sure that this state basis was made for this robot.

        Raises:
            StateBasisError: it was made for another robot, or for an earlier state of this one.
        """
        made_for = self.origin
        if made_for.robot_digest != robot.digest or len(self.Phi) != robot.n:
            raise StateBasisError(
                f"this state basis was made for robot {made_for.robot!r} with model digest "
                f"{made_for.robot_digest[:12]}, not for {robot.name!r} with {robot.digest[:12]}: "
                f"make one with `tauten reduce {robot.name} --states`"
            )

    def save(self, path: str | Path) -> Path:
        """Write one .states file (npz with a JSON header), whole or not at all; returns its path.

        Raises:
            StateBasisError: the name does not end in .states.
        """
        path = Path(path)
        if path.suffix != SUFFIX:
            raise StateBasisError(f"{path}: a state basis file ends in {SUFFIX}")
        arrays = {"Phi": self.Phi, "elements": self.elements, "weights": self.weights}
        write(path, _KIND, {"origin": asdict(self.origin)}, arrays)
        return path

    @classmethod
    def load(cls, name_or_path: str | Path) -> StateBasis:
        """Read a .states file, or the one shipped for a robot of that name.

        Raises:
            StateBasisError: no such file, or it is damaged; says which and what was found.
        """
        try:
            with located(name_or_path, SUFFIX, "state basis") as file:
                return _load(file)
        except UnknownFile as error:
            raise StateBasisError(str(error)) from error


def _load(path: Path) -> StateBasis:
    try:
        header, arrays = read(path, _KIND)
        return StateBasis(
            Phi=np.ascontiguousarray(arrays["Phi"], dtype=float),
            elements=arrays["elements"].astype(np.int64),
            weights=arrays["weights"].astype(float),
            origin=StateOrigin.from_dict(header["origin"]),
        )
    except OSError as error:
        raise StateBasisError(
            f"{path}: no state basis can be read there ({error.strerror})"
        ) from error
    except DamagedFile as error:
        raise StateBasisError(str(error)) from error
    except (StateBasisError, KeyError, TypeError, ValueError) as error:
        raise StateBasisError(f"{path}: this state basis file is damaged ({error})") from error
