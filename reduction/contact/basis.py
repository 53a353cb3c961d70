"""ContactBasis: contact forces as nonnegative combinations of a few modes, λ_c = Ψ β (17)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tauten.model import ChainedRows, ContactRows, ReducedContacts, Robot
from tauten.model.numerics import Array, Ints, kernel
from tauten.reduction.provenance import Provenance, made_for_another
from tauten.reduction.storage import located, named, parsed, read, write

SUFFIX = ".basis"
_KIND = "tauten contact basis"


class BasisError(ValueError):
    """A basis that cannot be used; the text names what was found and what is expected."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactBasis:
    """Contact modes of one robot; a `tauten.model.step.contact_space.ContactSpace`.

    Attributes:
        Psi: (n_c, k) modes, nonnegative, unit columns.
        provenance: its origin.
        k: number of modes.
    """

    Psi: Array
    provenance: Provenance
    k: int = field(init=False)

    def __post_init__(self) -> None:
        if self.Psi.ndim != 2 or self.Psi.shape[1] != self.provenance.k:
            raise BasisError(
                f"Psi has shape {self.Psi.shape}: expected (n_c, {self.provenance.k}), "
                "k as in the provenance"
            )
        if self.Psi.size == 0:
            raise BasisError(f"Psi has shape {self.Psi.shape}: expected at least one mode")
        if not np.isfinite(self.Psi).all() or (self.Psi < 0.0).any():
            raise BasisError("Psi has negative or non-finite entries: contact modes are Ψ ≥ 0")
        long = self.Psi.max() > 2.0  # where squares could overflow
        if long or np.abs(np.linalg.norm(self.Psi, axis=0) - 1.0).max() > 1e-9:
            raise BasisError("Psi has columns that are not of unit length: normalise them")
        object.__setattr__(self, "k", self.Psi.shape[1])

    @property
    def n_c(self) -> int:
        """Number of contact candidates."""
        return int(self.Psi.shape[0])

    def reduce(self, contacts: ContactRows) -> ReducedContacts:
        """Rows of the modes that have a candidate in range (18)-(19).

        Only candidates in range contribute to Ψᵀ H_c and Ψᵀ δ_c, as in the paper, of pairs without friction;
        a mode without any is left out.

        Returns:
            H (k', n) dense, so that Hᵀ is a Fortran-ordered right-hand side without a copy;
            delta (k',) [m]; modes (k',) columns of Ψ, ascending.
        """
        rows, found = contacts.rows, (contacts.found.slots, contacts.found.friction)
        if isinstance(rows, ChainedRows):
            S = rows.starts, rows.columns, rows.data
            return ReducedContacts(*_condense_chained(self.Psi, found, S, rows.motion, rows.delta))
        if isinstance(rows.H, np.ndarray):
            H, delta = np.zeros((self.k, rows.H.shape[1])), np.zeros(self.k)
            modes = np.empty(self.k, np.int64)
            count = _condense(self.Psi, found, rows.H, rows.delta, (H, delta, modes))
            return ReducedContacts(H[:count], delta[:count], modes[:count])
        slots, friction = found
        weights = self.Psi[slots]  # (m, k)
        weights[friction != 0.0] = 0.0
        modes = np.flatnonzero(weights.any(axis=0))  # (k',)
        weights = weights[:, modes]  # (m, k')
        H_c = rows.H
        H = np.zeros((len(modes), H_c.shape[1]))  # (k', n)
        _accumulate(H, weights, H_c.indptr, H_c.indices, H_c.data)
        return ReducedContacts(H, weights.T @ rows.delta, modes)

    def lift(self, beta: Array) -> Array:
        """Pointwise forces λ_c = Ψ β (n_c,) [N] of beta (k,) [N]."""
        lam: Array = self.Psi @ beta  # (n_c,)
        return lam

    def untouched(self) -> Ints:
        """Slots of the candidates without force in any mode: contact there needs extra columns."""
        return np.flatnonzero(~self.Psi.any(axis=1))

    def fitted(self, robot: Robot) -> ContactBasis:
        """This basis for a robot that has the contacts it was made for, and perhaps others after them.

        Candidates of contacts that were added since are in no mode: unit columns push them.

        Raises:
            BasisError: it was made for another robot, or for an earlier version of this one.
        """
        made_for, Psi = self.provenance.robot_digest, self.Psi
        if made_for in robot.digests_of_fewer:
            pairs = robot.contacts.pairs[: robot.digests_of_fewer.index(made_for)]
            if self.n_c == sum(len(pair.nodes) for pair in pairs):
                Psi = np.vstack([Psi, np.zeros((robot.n_c - self.n_c, self.k))])
                return ContactBasis(Psi, replace(self.provenance, robot_digest=robot.digest))
        self.check_robot(robot)
        return self

    def check_robot(self, robot: Robot) -> None:
        """Make sure that this basis was made for this robot.

        Raises:
            BasisError: it was made for another robot, or for an earlier version of this one.
        """
        made_for = self.provenance
        if made_for.robot_digest != robot.digest:
            other = made_for_another(
                made_for.robot, made_for.robot_digest, robot.name, robot.digest
            )
            raise BasisError(
                f"this basis {other}; make one from its robot file with `tauten reduce`"
            )
        if self.n_c != robot.n_c:
            raise BasisError(
                f"this basis has {self.n_c} contact candidates, robot {robot.name!r} has "
                f"{robot.n_c}: make one from its robot file with `tauten reduce`"
            )

    @staticmethod
    def new_file(path: str | Path) -> Path:
        """The path of a new .basis file.

        Raises:
            BasisError: the name does not end in .basis.
        """
        return named(path, SUFFIX, "contact basis", BasisError)

    def save(self, path: str | Path) -> Path:
        """Write one .basis file (npz with a JSON header), whole or not at all; returns its path.

        Raises:
            BasisError: the name does not end in .basis.
        """
        path = self.new_file(path)
        write(path, _KIND, {"provenance": asdict(self.provenance)}, {"Psi": self.Psi})
        return path

    @classmethod
    def load(cls, name_or_path: str | Path) -> ContactBasis:
        """Read a .basis file, or the one shipped for a robot of that name.

        Raises:
            BasisError: no such basis, or the file is damaged; names the file and what was found.
        """
        with located(name_or_path, SUFFIX, "contact basis", BasisError) as path:
            header, arrays = read(path, _KIND, {"Psi": "f"})
            provenance = parsed(Provenance, header["provenance"])
            return cls(np.ascontiguousarray(arrays["Psi"], dtype=float), provenance)


@kernel
def _condense_chained(
    Psi: Array,
    found: tuple[Ints, Array],
    S: tuple[NDArray[np.int32], NDArray[np.int32], Array],
    motion: Array,
    delta: Array,
) -> tuple[Array, Array, Ints]:
    """`_condense` for the rows S J of `ChainedRows`; only rows in a mode are computed.

    Args:
        Psi: (n_c, k) modes.
        found: (m,) slots and coefficients of friction of the rows.
        S: row starts, columns and data.
        motion: (N, n) J.
        delta: (m,) gaps [m].
    """
    starts, columns, data = S
    slots, friction = found
    H_r, delta_r = np.zeros((Psi.shape[1], motion.shape[1])), np.zeros(Psi.shape[1])
    touched, h = np.zeros(Psi.shape[1], np.bool_), np.empty(motion.shape[1])
    for row in range(slots.shape[0]):
        if friction[row] != 0.0:
            continue
        known = False
        for mode in range(Psi.shape[1]):
            weight = Psi[slots[row], mode]
            if weight == 0.0:
                continue
            if not known:
                h[:], known = 0.0, True
                for place in range(starts[row], starts[row + 1]):
                    value, column = data[place], columns[place]
                    for j in range(h.shape[0]):
                        h[j] += value * motion[column, j]
            touched[mode] = True
            delta_r[mode] += weight * delta[row]
            for j in range(h.shape[0]):
                H_r[mode, j] += weight * h[j]
    modes = np.flatnonzero(touched)
    return H_r[modes], delta_r[modes], modes


@kernel
def _condense(
    Psi: Array, found: tuple[Ints, Array], H: Array, delta: Array, out: tuple[Array, Array, Ints]
) -> int:
    """Number of modes with a candidate without friction in range, for dense rows H (m, n), delta (m,).

    Args:
        Psi: (n_c, k) modes.
        found: (m,) slots and coefficients of friction of the rows.
        H: (m, n) rows.
        delta: (m,) gaps [m].
        out: rows (k, n), gaps (k,), zeros, and numbers (k,), of which the first are those of these modes.
    """
    touched, count, (slots, friction) = np.zeros(Psi.shape[1], np.bool_), 0, found
    H_r, delta_r, modes = out
    for row in range(slots.shape[0]):
        if friction[row] != 0.0:
            continue
        for mode in range(Psi.shape[1]):
            weight = Psi[slots[row], mode]
            if weight != 0.0:
                touched[mode] = True
                delta_r[mode] += weight * delta[row]
                for j in range(H.shape[1]):
                    H_r[mode, j] += weight * H[row, j]
    for mode in range(Psi.shape[1]):
        if touched[mode]:
            H_r[count], delta_r[count], modes[count] = H_r[mode], delta_r[mode], mode
            count += 1
    return count


@kernel
def _accumulate(
    H: Array, weights: Array, indptr: NDArray[np.int32], indices: NDArray[np.int32], data: Array
) -> None:
    """H (k', n) += weightsᵀ (k', m) times the csr matrix (m, n); skips zero weights."""
    for row in range(weights.shape[0]):
        for mode in range(weights.shape[1]):
            weight = weights[row, mode]
            if weight != 0.0:
                for entry in range(indptr[row], indptr[row + 1]):
                    H[mode, indices[entry]] += weight * data[entry]


@dataclass(frozen=True, slots=True, eq=False)
class PairCoverage:
    """Coverage of one contact pair.

    Attributes:
        pair: its name.
        slots: (m,) slots of its candidates.
        untouched: (u,) those without force in any mode: contact there needs extra columns.
        modes: (j,) modes with forces on the pair.
    """

    pair: str
    slots: Ints
    untouched: Ints
    modes: Ints


def coverage(robot: Robot, basis: ContactBasis) -> tuple[PairCoverage, ...]:
    """Coverage of every contact pair of the robot that the basis was made for.

    Raises:
        BasisError: it was made for another robot.
    """
    basis.check_robot(robot)
    result = []
    for pair in robot.pairs:
        slots = np.arange(pair.first, pair.end)
        weights = basis.Psi[slots]  # (m, k)
        untouched = slots[~weights.any(axis=1)]
        result.append(
            PairCoverage(pair.name, slots, untouched, np.flatnonzero(weights.any(axis=0)))
        )
    return tuple(result)
