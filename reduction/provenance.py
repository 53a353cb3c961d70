"""Where a contact basis comes from: enough to know whom it fits and to make it again."""

from __future__ import annotations

import platform
from dataclasses import asdict, dataclass, fields
from importlib.metadata import PackageNotFoundError, version
from typing import Any

_PACKAGES = ("tauten", "numpy", "scipy", "numba")


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """What was found of one k, as in `tauten.reduction.contact.mode_count.Curve`.

    Attributes:
        k: number of modes.
        training: energy error on what they were fitted to.
        held_out: energy error on what was held out.
        force: largest held-out error of the sum of contact forces [N].
        tip: largest held-out effector error [m].
    """

    k: int
    training: float
    held_out: float
    force: float
    tip: float


@dataclass(frozen=True, slots=True)
class Provenance:
    """Origin of a basis.

    Attributes:
        robot: name of the robot.
        robot_digest: sha256 of its model; a basis fits no other one.
        campaign: one line that says which snapshots, such as "ramp: 0 to 40 mm in 800 steps".
        snapshots_digest: sha256 of the snapshot matrix.
        snapshots: number of columns factored.
        weighting: how much each of them counted.
        method: of the factorisation.
        k: number of modes.
        seed: of the factorisation.
        error: ‖S − Ψ B‖_F / ‖S‖_F on the weighted snapshots; of the start of "energy".
        energy_error: √ of the share of the contact energy that the modes lose, see `Quality`.
        tip_error: largest effector error on the snapshots, to first order [m].
        curve: a CurvePoint each for the k that were looked at; empty when k was given.
        created: date and time, ISO 8601 in UTC.
        versions: (package, version) pairs, Python among them.
    """

    robot: str
    robot_digest: str
    campaign: str
    snapshots_digest: str
    snapshots: int
    weighting: str
    method: str
    k: int
    seed: int
    error: float
    energy_error: float
    tip_error: float
    curve: tuple[CurvePoint, ...]
    created: str
    versions: tuple[tuple[str, str], ...]

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, entries: dict[str, Any]) -> Provenance:
        """From what `to_dict` gave, through JSON.

        Raises:
            KeyError, TypeError, ValueError: an entry is missing or of another type.
        """
        values = {field.name: entries[field.name] for field in fields(cls)}
        values["curve"] = tuple(CurvePoint(**point) for point in values["curve"])
        values["versions"] = tuple((str(name), str(found)) for name, found in values["versions"])
        return cls(**values)


def versions() -> tuple[tuple[str, str], ...]:
    """Versions of Python and of the packages that numbers depend on."""
    return (("python", platform.python_version()), *((name, _version(name)) for name in _PACKAGES))


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # run from a source tree that is not installed
        return "not installed"
