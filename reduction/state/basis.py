"""StateBasis: configurations as combinations of a few modes (14), and the sampled elements."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from tauten.model import Robot
from tauten.model.numerics import Array, Ints
from tauten.model.schema import same_but_contacts
from tauten.reduction.provenance import made_for_another
from tauten.reduction.reduced_body import ReducedBody, StateBasisError
from tauten.reduction.state.bodies import reducible
from tauten.reduction.storage import located, named, parsed, read, write

SUFFIX = ".states"
_KIND = "tauten state basis"
_KINDS = {"Phi": "f", "elements": "i", "weights": "f"}
_ORTHONORMAL = 1e-6  # largest entry of ΦᵀWΦ − I; rounding leaves 1e-14


@dataclass(frozen=True, slots=True)
class StateOrigin:
    """Origin of a state basis and its sample of elements.

    Attributes:
        robot: name of the robot.
        robot_digest: digest of its description; a state basis fits no other one.
        campaign: one line that names the snapshots.
        snapshots_digest: sha256 of their contact forces, the same as in the contact basis.
        snapshots: number of states.
        r: number of modes.
        responses: how many of them are static responses instead of modes of motion.
        projection_error: root mean square of the motion left out, relative.
        sample: number of elements in the sample.
        sample_tolerance: relative residual allowed when they were chosen.
        sample_error: relative residual reached.
        tip_mean, tip_max: distance of the tip from the full model's on held-out paths, the mean over the
            range of the actuators [m], or NaN.
        seed: of the random directions.
        created: date and time, ISO 8601 in UTC.
        versions: (package, version) pairs, Python among them.
        pressed_mean, pressed_max: the same where spheres of the campaign are in the way, which counts in the
            others too [m]; None: nowhere.
        position_share: largest positions of the actuators in the snapshots, as a share of those in the
            campaign.
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
    pressed_mean: float | None = None
    pressed_max: float | None = None
    position_share: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class StateBasis:
    """State modes of one robot, with the elements over which its forces are summed.

    Attributes:
        Phi: (m, r) modes, ΦᵀWΦ = I in the norm of the robot (`tauten.reduction.reduced_body.Reducible`).
        elements: (s,) numbers of the sampled elements, ascending.
        weights: (s,) factors of their forces, positive.
        origin: robot, snapshots, errors and versions.
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
        if self.Phi.size == 0 or not np.isfinite(self.Phi).all():
            raise StateBasisError("Phi has no entries, or some that are not finite")
        if self.elements.ndim != 1 or self.elements.shape != self.weights.shape:
            raise StateBasisError(
                f"elements have shape {self.elements.shape}, weights {self.weights.shape}: "
                "expected one weight for each element"
            )
        if not (np.isfinite(self.weights) & (self.weights > 0.0)).all():
            raise StateBasisError("weights are not all positive and finite: expected w > 0")
        if not len(self.elements) or self.elements[0] < 0 or (np.diff(self.elements) <= 0).any():
            raise StateBasisError(
                "elements are not ascending numbers from 0, each of them once: sort them"
            )
        if len(self.elements) != self.origin.sample:
            raise StateBasisError(
                f"there are {len(self.elements)} elements: expected {self.origin.sample}, "
                "sample as in the origin"
            )
        mean, largest = self.origin.tip_mean, self.origin.tip_max
        if not (np.isnan(mean) and np.isnan(largest)) and not 0.0 <= mean <= largest < np.inf:
            raise StateBasisError(
                f"tip_mean is {mean} m and tip_max {largest} m: expected 0 ≤ tip_mean ≤ tip_max, "
                "or NaN for both where they were not measured"
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

    def with_tip_errors(
        self, mean: float, largest: float, pressed: tuple[float, float] | None = None
    ) -> StateBasis:
        """The same basis with its tip errors on held-out paths.

        Args:
            mean: of all [m].
            largest: of all [m].
            pressed: both where spheres are in the way [m]; None: nowhere.
        """
        origin = replace(self.origin, tip_mean=mean, tip_max=largest)
        if pressed is not None:
            origin = replace(origin, pressed_mean=pressed[0], pressed_max=pressed[1])
        return replace(self, origin=origin)

    def check_tip(self, allowed: float) -> None:
        """Make sure that its tip error on held-out paths is within what a robot file allows [m].

        Raises:
            StateBasisError: it is larger, or was not measured.
        """
        if not self.origin.tip_max <= allowed:
            raise StateBasisError(
                f"the state basis of {self.r} modes and {len(self.elements)} elements, from "
                f"{self.origin.snapshots} snapshots, takes the tip up to {1e3 * self.origin.tip_max:.3g} mm "
                f"(mean {1e3 * self.origin.tip_mean:.3g} mm) from where the full model takes it, allowed are "
                f"{1e3 * allowed:.3g} mm: use more modes, a finer sample or a wider campaign, or accept it"
            )

    def check_robot(self, robot: Robot) -> None:
        """Make sure that this state basis was made for this robot and describes its body.

        Raises:
            StateBasisError: it was made for another robot, or for an earlier version of this one; its
                modes are not orthonormal in the norm of the robot, its sample of elements cannot be this
                body's, its tip error is larger than the robot, or the robot has no state bases.
        """
        body, made_for = reducible(robot), self.origin
        again = "make it again from its robot file with `tauten reduce --states`"
        if not same_but_contacts(made_for.robot_digest, robot.digest):
            other = made_for_another(
                made_for.robot, made_for.robot_digest, robot.name, robot.digest
            )
            raise StateBasisError(
                f"this state basis {other}; make one from its robot file with `tauten reduce --states`"
            )
        if len(self.Phi) != len(body.weight):
            raise StateBasisError(
                f"the modes of this state basis have {len(self.Phi)} rows, robot {robot.name!r} has "
                f"{len(body.weight)} unknowns: {again}"
            )
        if self.elements[-1] >= body.n_elements:
            raise StateBasisError(
                f"this state basis samples element {self.elements[-1]}, robot {robot.name!r} has "
                f"the elements 0 to {body.n_elements - 1}: {again}"
            )
        with np.errstate(over="ignore", invalid="ignore"):
            gram = self.Phi.T @ (body.weight[:, None] * self.Phi)  # (r, r)
        apart = float(np.abs(gram - np.eye(self.r)).max())
        if not apart <= _ORTHONORMAL:
            raise StateBasisError(
                f"the modes of this state basis are not orthonormal in the {body.norm} of robot "
                f"{robot.name!r}: ΦᵀWΦ − I has an entry of {apart:.2g}, allowed are "
                f"{_ORTHONORMAL}: {again}"
            )
        doubt = body.implausible(self.elements, self.weights)
        if doubt:
            raise StateBasisError(f"{doubt}: {again}")
        if self.origin.tip_max > robot.size:
            raise StateBasisError(
                f"tip_max of this state basis is {self.origin.tip_max} m, more than the size of "
                f"robot {robot.name!r}, {robot.size:.3g} m: {again}"
            )

    def save(self, path: str | Path) -> Path:
        """Write one .states file (npz with a JSON header), whole or not at all; returns its path.

        Raises:
            StateBasisError: the name does not end in .states.
        """
        path = named(path, SUFFIX, "state basis", StateBasisError)
        arrays = {"Phi": self.Phi, "elements": self.elements, "weights": self.weights}
        write(path, _KIND, {"origin": asdict(self.origin)}, arrays)
        return path

    @classmethod
    def load(cls, name_or_path: str | Path) -> StateBasis:
        """Read a .states file, or the one shipped for a robot of that name.

        Raises:
            StateBasisError: no such file, or it is damaged; names the file and what was found.
        """
        with located(name_or_path, SUFFIX, "state basis", StateBasisError) as path:
            header, arrays = read(path, _KIND, _KINDS)
            return cls(
                Phi=np.ascontiguousarray(arrays["Phi"], dtype=float),
                elements=arrays["elements"].astype(np.int64),
                weights=arrays["weights"].astype(float),
                origin=parsed(StateOrigin, header["origin"]),
            )


def reduced_robot(robot: Robot, states: StateBasis) -> Robot[ReducedBody]:
    """The robot in the coordinates of a state basis.

    Raises:
        StateBasisError: the basis was made for another robot, or this one has no state bases.
    """
    states.check_robot(robot)
    return reducible(robot).reduced(states.Phi, states.elements, states.weights)
