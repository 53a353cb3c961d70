"""Origin of a contact basis: the robot it fits, and all that is needed to make it again."""

from __future__ import annotations

import platform
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from tauten.model.schema import differences

_PACKAGES = ("tauten", "numpy", "scipy", "numba")


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """Errors for one k, as in `tauten.reduction.contact.mode_count.Curve`.

    Attributes:
        k: number of modes.
        training: energy error on the training problems.
        held_out: energy error on the held-out problems.
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
        robot_digest: digest of its description; a basis fits no other one.
        campaign: one line that names the snapshots, such as "ramp: 0 to 40 mm in 800 steps".
        snapshots_digest: sha256 of the snapshot matrix.
        snapshots: number of columns factored.
        weighting: of the columns.
        method: of the factorisation.
        k: number of modes.
        seed: of the factorisation.
        error: ‖S − Ψ B‖_F / ‖S‖_F on the weighted snapshots; of the start of "energy".
        energy_error: √ of the lost share of the contact energy, see `BasisQuality`.
        tip_error: largest effector error on the snapshots at equal positions of the actuators, to first order
            [m].
        curve: errors for every k that was compared; empty when k was given.
        created: date and time, ISO 8601 in UTC.
        versions: (package, version) pairs, Python among them.
        tip_error_as_held: the same at equal efforts of the actuators that the robot holds by their effort,
            as chambers at equal pressure; None: it has no such, or nobody computed it.
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
    tip_error_as_held: float | None = None


def made_for_another(made_for: str, digest: str, name: str, now: str) -> str:
    """What a basis was made for, as the end of a sentence, where that is not the robot it is used with."""
    what = differences(digest, now)
    return f"was made for robot {made_for!r}, which is not {name!r} as it is now: {what} differ"


def package_versions() -> tuple[tuple[str, str], ...]:
    """Versions of Python and of the packages that numbers depend on."""
    return (
        ("python", platform.python_version()),
        *((name, package_version(name)) for name in _PACKAGES),
    )


@cache
def package_version(package: str) -> str:
    """Version of an installed package, and of tauten also where its sources run without installation."""
    try:
        return version(package)
    except PackageNotFoundError:
        return source_version() if package == "tauten" else "not installed"


def source_version() -> str:
    """Version of the source tree that this module belongs to, from its pyproject.toml."""
    file = Path(__file__).resolve().parents[1] / "pyproject.toml"
    if not file.is_file():
        return "not installed"
    found: str = tomllib.loads(file.read_text(encoding="utf-8"))["project"]["version"]
    return found
