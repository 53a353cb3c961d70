"""The QPCC (1)-(3) as a user writes it down, in memory and in a file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np

from tauten.controller.qpcc.solution import Solution
from tauten.model.numerics import Array, Bools
from tauten.reduction import atomic_write


class QpccArrays(NamedTuple):
    """The arrays of a `Qpcc`, with the same names, shapes and units, as kernels take them."""

    Q: Array
    c: Array
    lb: Array
    ub: Array
    G: Array
    g_lo: Array
    g_hi: Array
    M: Array
    m: Array


@dataclass(frozen=True, slots=True)
class Qpcc:
    """Quadratic program with complementarity constraints.

        min  1/2 z'Qz + c'z + constant,   z = (a, β)                                       (1)
        s.t. lb <= a <= ub,   g_lo <= G z <= g_hi                                          (2)
             0 <= w = M z + m   ⟂   β >= 0                                                 (3)

    n = n_a + k variables, p limits. In inverse control a are tensions [N], β reduced contact forces
    [N], w reduced gaps [m], the limits (2) those of tension and pulled length [m], the objective is in
    m²; nothing here depends on it.

    Attributes:
        Q: (n, n) symmetric positive semidefinite.
        c: (n,).
        lb: (n_a,) -inf for none.
        ub: (n_a,) +inf for none.
        G: (p, n).
        g_lo: (p,) -inf for none.
        g_hi: (p,) +inf for none.
        M: (k, n); its columns of β are positive semidefinite in a contact problem.
        m: (k,).
        constant: added to the objective.
        bound_names: (n_a,) what a bound is called when it is in conflict; default: "bound 0", ...
        row_names: (p,) what the lower and the upper limit of a row are called; default: "row 0", ...
    """

    Q: Array
    c: Array
    lb: Array
    ub: Array
    G: Array
    g_lo: Array
    g_hi: Array
    M: Array
    m: Array
    constant: float = 0.0
    bound_names: tuple[str, ...] = ()
    row_names: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        n_a, k, p = len(self.lb), len(self.m), len(self.g_lo)
        n = n_a + k
        found = (self.Q.shape, self.c.shape, self.ub.shape, self.G.shape, self.g_hi.shape)
        if (*found, self.M.shape) != ((n, n), (n,), (n_a,), (p, n), (p,), (k, n)):
            raise ValueError(
                f"Qpcc: Q, c, ub, G, g_hi, M have shapes {found} and {self.M.shape}, which do not fit "
                f"{n_a} bounds, {k} complementarity rows and {p} limits"
            )

    @property
    def arrays(self) -> QpccArrays:
        """Its arrays, contiguous: a kernel is compiled anew for every memory layout."""
        p = self
        given = (p.Q, p.c, p.lb, p.ub, p.G, p.g_lo, p.g_hi, p.M, p.m)
        return QpccArrays(*map(partial(np.ascontiguousarray, dtype=np.float64), given))

    def limited(
        self,
        G: Array,
        g_lo: Array,
        g_hi: Array,
        names: Iterable[tuple[str, str]],
        bounds: tuple[Array, Array] | None = None,
    ) -> Qpcc:
        """The problem with more limits.

        Args:
            G: (r, n) their rows.
            g_lo: (r,) lower limits.
            g_hi: (r,) upper limits.
            names: (r,) what these are called.
            bounds: lb and ub (n_a,) instead of those of the problem; None: these.
        """
        lb, ub = (self.lb, self.ub) if bounds is None else bounds
        return Qpcc(
            self.Q, self.c, lb, ub, np.concatenate([self.G, G]), np.concatenate([self.g_lo, g_lo]),
            np.concatenate([self.g_hi, g_hi]), self.M, self.m, self.constant, self.bound_names,
            (*self.row_names, *names),
        )  # fmt: skip

    def objective(self, lam_a: Array, beta: Array) -> float:
        """(1) at a point."""
        z = np.concatenate([lam_a, beta])
        return float(z @ (0.5 * (self.Q @ z) + self.c)) + self.constant

    def name_of_bound(self, j: int) -> str:
        """What bound j is called."""
        return self.bound_names[j] if self.bound_names else f"bound {j}"

    def name_of_row(self, i: int, upper: bool) -> str:
        """What a limit of row i is called."""
        return self.row_names[i][int(upper)] if self.row_names else f"row {i}"


@dataclass(frozen=True, slots=True)
class Start:
    """Where to start: what is known of the step before.

    Attributes:
        lam_a: (n_a,) tensions; the solution is never worse than these with the contact forces they
            cause, as long as they satisfy the limits.
        piece: (k,) modes that pushed.
    """

    lam_a: Array
    piece: Bools


Warm = Start | Solution | Bools | None


def start_of(warm: Warm, n_a: int, k: int) -> tuple[Array, Bools]:
    """Tensions and piece to start from, in arrays of their own; what does not fit the problem is ignored.

    Args:
        warm: the last solution, a `Start`, a piece (k,) alone, or None.
        n_a: number of tensions.
        k: number of contact modes.
    """
    lam_a, piece = np.zeros(n_a), np.zeros(k, dtype=np.bool_)
    if warm is None:
        return lam_a, piece
    if isinstance(warm, np.ndarray):
        given, pushes = lam_a, warm
    else:
        given, pushes = warm.lam_a, warm.piece
    if given.shape == (n_a,) and all(np.isfinite(given).tolist()):
        lam_a[:] = given
    if pushes.shape == (k,):
        piece[:] = pushes
    return lam_a, piece


def write_qpcc(path: Path, problem: Qpcc, start: Start | None = None) -> None:
    """Write a problem, and where its solution started, to an npz file that `read_qpcc` reads.

    Args:
        path: of the file; one that is there is replaced, by the whole new one or not at all.
        problem: the QPCC.
        start: tensions and piece of the step before, without which the failure may not repeat.
    """
    arrays: dict[str, Any] = problem.arrays._asdict()
    named = {"bound_names": problem.bound_names, "row_names": problem.row_names}
    arrays |= {name: np.array(names, dtype=np.str_) for name, names in named.items() if names}
    if start is not None:
        arrays |= {"start_lam_a": start.lam_a, "start_piece": start.piece}
    with atomic_write(path) as file:  # np.savez would append ".npz" to the name
        np.savez_compressed(file, constant=problem.constant, **arrays)


def read_qpcc(path: Path) -> tuple[Qpcc, Start | None]:
    """A problem of `write_qpcc`, and the start of its solution where the file has one.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is not such a file; the message says what is missing or does not fit.
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            found: dict[str, Any] = {name: data[name] for name in data.files}
    except (BadZipFile, EOFError, ValueError, AttributeError, TypeError) as error:
        raise ValueError(
            f"{path}: not an npz file of arrays, as `tauten replay --problem` writes"
        ) from error
    missing = [name for name in QpccArrays._fields if name not in found]
    if missing:
        raise ValueError(f"{path}: no QPCC, the arrays {', '.join(missing)} are missing")
    try:
        problem = Qpcc(
            **{name: found[name].astype(np.float64) for name in QpccArrays._fields},
            constant=float(found.get("constant", 0.0)),
            bound_names=tuple(found.get("bound_names", np.zeros(0, np.str_)).tolist()),
            row_names=tuple(map(tuple, found.get("row_names", np.zeros((0, 2), np.str_)).tolist())),
        )
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: {error}") from error
    if "start_lam_a" not in found or "start_piece" not in found:
        return problem, None
    return problem, Start(found["start_lam_a"], found["start_piece"].astype(np.bool_))
