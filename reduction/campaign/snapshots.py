"""Snapshots: contact forces of a robot at many equilibria, with the loads that cause them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from tauten.model.numerics import Array, Bools, Ints
from tauten.reduction.storage import named, parsed, read, whole, write

SUFFIX = ".snapshots"
_KIND = "tauten snapshots"
# Kinds of data type and numbers of dimensions.
_ARRAYS = {"run": ("i", 1), "converged": ("b", 1)}
_MATRIX = ("f", 2)


class SnapshotError(ValueError):
    """Snapshots that cannot be used; the text names what was found and what is expected."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Origin of snapshots.

    Attributes:
        robot: name of the robot.
        robot_digest: digest of its description.
        campaign: description of the design and its digest, one line.
        versions: (package, version) pairs.
    """

    robot: str
    robot_digest: str
    campaign: str
    versions: tuple[tuple[str, str], ...]

    def difference(self, other: Origin) -> str:
        """What differs from another origin, the first of what matters most, in a few words."""
        if self.robot != other.robot:
            return f"of robot {self.robot!r}, this one is {other.robot!r}"
        if self.robot_digest != other.robot_digest:
            return "made before the model in the robot file or its mesh was changed"
        if self.campaign != other.campaign:
            return f"{self.campaign}, this one is {other.campaign}"
        ours, theirs = dict(self.versions), dict(other.versions)
        changed = [
            f"{name} {ours.get(name, 'none')}, now {theirs.get(name, 'none')}"
            for name in ours | theirs
            if ours.get(name) != theirs.get(name)
        ]
        return f"made with {'; '.join(changed)}"


@dataclass(frozen=True, slots=True, eq=False)
class Snapshots:
    """One column for each equilibrium.

    Attributes:
        lam: (n_c, s) contact forces of nearly least norm [N].
        position: (n_a, s) pulled lengths [m].
        effort: (n_a, s) cable tensions [N].
        effector: (3 p, s) effector positions [m].
        gravity: (3, s) acceleration of gravity [m/s²].
        effector_force: (3 p, s) outer forces on the effectors [N].
        pressed: (3 k, s) centres of the spheres that press the robot [m], see
            `tauten.reduction.campaign.touched`.
        run: (s,) which run of the campaign, ascending.
        converged: (s,) whether equilibrium and contact met their tolerances.
        q: (n, s) configurations [m], or (0, s) when they were not recorded.
        origin: robot, campaign and versions.
    """

    lam: Array
    position: Array
    effort: Array
    effector: Array
    gravity: Array
    effector_force: Array
    pressed: Array
    run: Ints
    converged: Bools
    q: Array
    origin: Origin

    def __post_init__(self) -> None:
        for name, array in self._arrays().items():
            kind, dimensions = _ARRAYS.get(name, _MATRIX)
            if array.ndim != dimensions or array.dtype.kind != kind:
                raise SnapshotError(
                    f"{name} has shape {array.shape} and data type {array.dtype}: expected "
                    f"{dimensions} dimensions and kind {kind!r}"
                )
            # forces that are not finite are refused by the fit, which names their columns
            if name != "lam" and not np.isfinite(array).all():
                raise SnapshotError(f"{name} has entries that are not finite")
        counts = {name: array.shape[-1] for name, array in self._arrays().items()}
        if len(set(counts.values())) > 1:
            listing = ", ".join(f"{name} {count}" for name, count in counts.items())
            raise SnapshotError(f"snapshots with different numbers of columns: {listing}")
        if len(self.gravity) != 3 or len(self.position) != len(self.effort):
            raise SnapshotError(
                f"gravity has {len(self.gravity)} rows, position {len(self.position)}, effort "
                f"{len(self.effort)}: expected 3 for gravity and as many positions as efforts"
            )
        if len(self.effector) != len(self.effector_force) or len(self.effector) % 3:
            raise SnapshotError(
                f"effector has {len(self.effector)} rows, effector_force "
                f"{len(self.effector_force)}: expected the same multiple of 3"
            )
        if (self.run < 0).any() or (np.diff(self.run) < 0).any():
            raise SnapshotError("run has numbers that are negative or not ascending")

    def __len__(self) -> int:
        return int(self.lam.shape[1])

    def digest(self) -> str:
        """SHA-256 of the contact forces."""
        return hashlib.sha256(np.ascontiguousarray(self.lam).tobytes()).hexdigest()

    def select(self, columns: Ints | Bools) -> Snapshots:
        """The snapshots of some columns, by number or by mask (s,)."""
        chosen = {name: array[..., columns] for name, array in self._arrays().items()}
        return Snapshots(origin=self.origin, **chosen)

    def save(self, path: str | Path) -> Path:
        """Write one .snapshots file (npz with a JSON header), whole or not at all.

        Raises:
            SnapshotError: the name does not end in .snapshots.
        """
        path = named(path, SUFFIX, "snapshot", SnapshotError)
        write(path, _KIND, {"origin": asdict(self.origin)}, self._arrays())
        return path

    @classmethod
    def load(cls, path: str | Path) -> Snapshots:
        """Read a .snapshots file.

        Raises:
            FileNotFoundError: there is none.
            SnapshotError: it is damaged or no snapshot file.
        """
        with whole(path, "snapshot", SnapshotError):
            names = [field.name for field in fields(cls) if field.name != "origin"]
            kinds = {name: _ARRAYS.get(name, _MATRIX)[0] for name in names}
            header, arrays = read(Path(path), _KIND, kinds)
            return cls(origin=parsed(Origin, header["origin"]), **arrays)

    def _arrays(self) -> dict[str, Any]:
        names = (field.name for field in fields(self) if field.name != "origin")
        return {name: getattr(self, name) for name in names}


def join_snapshots(parts: Sequence[Snapshots]) -> Snapshots:
    """Snapshots of one campaign on one robot side by side, in the order given.

    Raises:
        SnapshotError: nothing to join, or the parts have different origins.
    """
    if not parts:
        raise SnapshotError("no snapshots to join: the campaign has no runs")
    origins = {part.origin for part in parts}
    if len(origins) > 1:
        first, other = list(origins)[:2]
        raise SnapshotError(
            f"snapshots of different origin do not mix: some are {first.difference(other)}"
        )
    columns = [part._arrays() for part in parts]
    joined = {name: np.concatenate([c[name] for c in columns], axis=-1) for name in columns[0]}
    return Snapshots(origin=parts[0].origin, **joined)
