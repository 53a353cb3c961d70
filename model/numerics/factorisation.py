"""Sparse factorisation of symmetric matrices that share one pattern: analyse once, refactor often.

Few unknowns, as of a rigid object, have dense factors. Back ends for more, fastest first: MKL PARDISO (`pip
install -e '.[pardiso]'` in a clone), CHOLMOD from cvxopt (`tauten[cholmod]`), SuperLU from scipy.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import importlib.util
import logging
import os
import sys
from abc import abstractmethod
from collections.abc import Callable
from functools import cache
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from tauten.model.numerics.arrays import Array, Ints
from tauten.model.numerics.long_calls import LongCalls

log = logging.getLogger(__name__)

BACKENDS = {"pardiso": "pypardiso", "cholmod": "cvxopt", "superlu": "scipy"}


ZERO_PIVOT = -4  # PARDISO's number of this error
FEW = 24  # unknowns; of no more, dense factors are found before a back end has read its arguments
LONG = 20_000  # unknowns; with fewer, a call of a library ends within about half a second


class FactorisationError(RuntimeError):
    """The matrix could not be factorised (not positive definite, or not finite)."""


class Factorisation(Protocol):
    """Factors of a symmetric matrix whose pattern does not change."""

    @property
    def name(self) -> str:
        """Of the solver."""

    def refactor(self, values: Array) -> None:
        """Factorise the matrix with these CSC values (nnz,).

        Raises:
            FactorisationError: not positive definite or not finite.
        """

    def solve(self, B: Array) -> Array:
        """A⁻¹ B for B (n,) or (n, m); column-major B is not copied. Returns the shape of B."""

    def fork(self) -> Factorisation:
        """A workspace of its own for the same pattern, without factors."""


class HalfSolving(Factorisation):
    """Factors A = L Lᵀ that solve by halves: Bᵀ A⁻¹ B = Yᵀ Y with the first half Y of A⁻¹ B."""

    @abstractmethod
    def first_half(self, B: Array) -> Array:
        """Y = L⁻¹ B for B (n, m); column-major B is not copied."""

    @abstractmethod
    def second_half(self, Y: Array) -> Array:
        """A⁻¹ B = L⁻ᵀ Y for Y of the shape (n,) or (n, m)."""


def installed_backends() -> tuple[str, ...]:
    """Names of the usable back ends, fastest first."""
    return tuple(name for name, module in BACKENDS.items() if importlib.util.find_spec(module))


def make_factorisation(
    indptr: Ints, indices: Ints, backend: str = "auto", threads: int = 1
) -> Factorisation:
    """Analyse a symmetric pattern.

    Args:
        indptr: (n + 1,) CSC column pointers.
        indices: (nnz,) row indices, sorted in each column; the pattern holds both triangles.
        backend: "auto" for the fastest one, or a name of `BACKENDS`, or that of `FewUnknowns`.
        threads: on which PARDISO computes, whatever the rest of the process does; the other back ends use
            those of the library of dense algebra that they call.

    Raises:
        ValueError: the back end is unknown or not installed.
    """
    available, few = installed_backends(), len(indptr) - 1 <= FEW
    name = backend if backend != "auto" else FewUnknowns.name if few else available[0]
    if name not in (*available, FewUnknowns.name):
        raise ValueError(
            f"factorisation {name!r} is not installed, available are {', '.join(available)}; "
            f"try pip install -e '.[{name}]' in the clone of tauten"
        )
    makers: dict[str, Callable[[Ints, Ints, int], Factorisation]] = {
        "dense": FewUnknowns,
        "pardiso": Pardiso,
        "cholmod": Cholmod, "superlu": SuperLU,
    }  # fmt: skip
    log.debug("factorisation: %s, %d unknowns, %d entries", name, len(indptr) - 1, len(indices))
    return makers[name](indptr, indices, threads)


def triangle(indptr: Ints, indices: Ints) -> tuple[Ints, Ints, Ints]:
    """Lower triangle of a CSC pattern: (indptr, indices, places of its values in the full one)."""
    column = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    places = np.flatnonzero(indices >= column)
    counts = np.bincount(column[places], minlength=len(indptr) - 1)
    return np.concatenate([[0], np.cumsum(counts)]), indices[places], places


class Analysed:
    """Pickled as its pattern: the other side analyses again and starts without factors."""

    name: str

    def __init__(self, indptr: Ints, indices: Ints, threads: int) -> None:
        self._pattern = indptr, indices
        self.threads = threads

    def fork(self) -> Factorisation:
        """See `Factorisation`."""
        return make_factorisation(*self._pattern, self.name, self.threads)

    def __reduce__(self) -> tuple[Any, ...]:
        return make_factorisation, (*self._pattern, self.name, self.threads)


class FewUnknowns(Analysed, HalfSolving):
    """Dense factors of small matrices, kept by their inverse."""

    name = "dense"

    def refactor(self, values: Array) -> None:
        """See `Factorisation`."""
        indptr, indices = self._pattern
        A = np.zeros((len(indptr) - 1, len(indptr) - 1))
        A[np.repeat(np.arange(len(A)), np.diff(indptr)), indices] = values
        if not np.isfinite(values).all():
            raise FactorisationError("not finite")
        try:
            self._inverse = np.linalg.inv(np.linalg.cholesky(A))
        except np.linalg.LinAlgError as error:
            raise FactorisationError("not positive definite") from error

    def solve(self, B: Array) -> Array:
        """See `Factorisation`."""
        return self.second_half(self.first_half(B))

    def first_half(self, B: Array) -> Array:
        """See `HalfSolving`."""
        return np.asarray(self._inverse @ B)

    def second_half(self, Y: Array) -> Array:
        """See `HalfSolving`."""
        return np.asarray(self._inverse.T @ Y)


class SuperLU(Analysed):
    """scipy's SuperLU; the column ordering is found once and applied to the values afterwards."""

    name = "superlu"

    def __init__(self, indptr: Ints, indices: Ints, threads: int) -> None:
        super().__init__(indptr, indices, threads)
        n = len(indptr) - 1
        numbers = sp.csc_array((np.arange(len(indices)), indices, indptr), shape=(n, n))
        column = np.repeat(np.arange(n), np.diff(indptr))
        # a Laplacian of the pattern: any positive definite matrix will do for the ordering
        values = np.where(indices == column, np.diff(indptr)[column].astype(float), -1.0 + 1e-3)
        probe = sp.csc_array((values, indices, indptr), shape=(n, n))
        self._order = np.argsort(splu(probe, "MMD_AT_PLUS_A", options=SUPERLU_OPTIONS).perm_c)
        permuted = sp.csc_array(numbers[self._order][:, self._order])
        permuted.sort_indices()
        self._source = permuted.data
        self._matrix = sp.csc_array(
            (np.zeros(len(indices)), permuted.indices, permuted.indptr), shape=(n, n)
        )
        self._lu: Any = None

    def refactor(self, values: Array) -> None:
        """See `Factorisation`."""
        self._matrix.data[:] = values[self._source]
        try:
            self._lu = splu(self._matrix, "NATURAL", options=SUPERLU_OPTIONS)
        except RuntimeError as error:
            raise FactorisationError(str(error)) from error
        # without pivoting U = D Lᵀ, and A is positive definite exactly when D is
        if not (self._lu.U.diagonal() > 0.0).all():
            raise FactorisationError("not positive definite")

    def solve(self, B: Array) -> Array:
        """See `Factorisation`."""
        X = np.empty_like(B, order="F")
        X[self._order] = self._lu.solve(B[self._order])
        return X


SUPERLU_OPTIONS = {"SymmetricMode": True, "DiagPivotThresh": 0.0}


class Cholmod(Analysed):
    """CHOLMOD's supernodal Cholesky as shipped in cvxopt's wheels."""

    name = "cholmod"

    def __init__(self, indptr: Ints, indices: Ints, threads: int) -> None:
        from cvxopt import cholmod, matrix, spmatrix

        super().__init__(indptr, indices, threads)
        self._cholmod, self._to_matrix = cholmod, matrix
        lower_ptr, lower, self._places = triangle(indptr, indices)
        columns = np.repeat(np.arange(len(indptr) - 1), np.diff(lower_ptr))
        # a diagonally dominant probe: any positive definite matrix will do for the analysis
        values = np.where(lower == columns, float(len(indptr)), -0.5)
        self._matrix = spmatrix(values, lower, columns, (len(indptr) - 1,) * 2)
        cholmod.options["supernodal"] = 2
        self._factor = cholmod.symbolic(self._matrix)

    def refactor(self, values: Array) -> None:
        """See `Factorisation`."""
        self._matrix.V = self._to_matrix(values[self._places])
        try:
            self._cholmod.numeric(self._matrix, self._factor)
        except (ArithmeticError, ValueError) as error:
            raise FactorisationError(f"not positive definite ({error})") from error

    def solve(self, B: Array) -> Array:
        """See `Factorisation`."""
        X = self._to_matrix(B)
        self._cholmod.solve(self._factor, X)
        return np.asarray(X).reshape(B.shape, order="F")


@cache
def mkl() -> Any:
    """The MKL library as pypardiso opens it, found once for the process.

    Without the name of the library's file pypardiso starts a compiler and reads every folder of the
    environment, for each solver, and for one when it is imported. Pip knows the file; where it does not,
    pypardiso searches.
    """
    try:
        files = importlib.metadata.files("mkl") or []
    except importlib.metadata.PackageNotFoundError:
        files = []
    for file in files:
        if "mkl_rt" in file.name:
            os.environ.setdefault("PYPARDISO_MKL_RT", str(file.locate()))
    from pypardiso import PyPardisoSolver

    library = PyPardisoSolver(mtype=2).libmkl
    library.MKL_Set_Num_Threads_Local.argtypes = [ctypes.c_int]
    library.MKL_Set_Num_Threads_Local.restype = ctypes.c_int
    return library


def int_argument(value: int) -> Any:
    """A number as Fortran takes it."""
    return ctypes.byref(ctypes.c_int32(value))


def array_argument(array: Any, number: type) -> Any:
    """An array of numbers of a C type; it lives as long as the argument."""
    return array.ctypes.data_as(ctypes.POINTER(number))


MINIMUM_DEGREE, NESTED_DISSECTION = 0, 2  # PARDISO's orderings
RELEASE = -1  # PARDISO's number of the phase that frees memory
WHOLE, FORWARD, BACKWARD = 33, 331, 333  # and those that solve, and solve with one of the factors


class Pardiso(Analysed, HalfSolving):
    """MKL PARDISO for positive definite matrices, through the library pypardiso finds.

    Both of its orderings are tried and that with fewer operations is kept: minimum degree suits slender
    bodies and small meshes, nested dissection large ones. PARDISO breaks where the number of threads changes
    after the analysis, so every call sets it, for the calling thread only.
    """

    name = "pardiso"

    def __init__(
        self, indptr: Ints, indices: Ints, threads: int, other: Pardiso | None = None
    ) -> None:
        """As `make_factorisation`; triangle and ordering are those of another one for the same pattern."""
        super().__init__(indptr, indices, threads)
        # The lower triangle by columns is the upper triangle by rows, which PARDISO expects.
        if other is None:
            lower_ptr, lower, self._places = triangle(indptr, indices)
            self._ia, self._ja = (lower_ptr + 1).astype(np.int32), (lower + 1).astype(np.int32)
        else:
            self._ia, self._ja, self._places = other._ia, other._ja, other._places
        self._ordering: int | None = None if other is None else other._ordering
        self._is_analysed = False
        self._a = np.zeros(len(self._ja))
        self._n = len(indptr) - 1
        # calling the library without pypardiso spares a conversion of the pattern in every phase
        self._pardiso, self._set_threads = mkl().pardiso, mkl().MKL_Set_Num_Threads_Local
        self._pt = np.zeros(64, dtype=np.int64)
        self._iparm = np.zeros(64, dtype=np.int32)
        self._calls = LongCalls()
        self._iparm[0], self._iparm[9] = 1, 8  # user-defined parameters
        self._arguments = (  # the same in every call; each takes some µs to convert
            array_argument(self._pt, ctypes.c_int64), int_argument(1), int_argument(2),
            int_argument(self._n), array_argument(self._a, ctypes.c_double),
            array_argument(self._ia, ctypes.c_int32), array_argument(self._ja, ctypes.c_int32),
            int_argument(0), array_argument(self._iparm, ctypes.c_int32), int_argument(0),
        )  # fmt: skip

    def fork(self) -> Pardiso:
        """See `Factorisation`."""
        return Pardiso(*self._pattern, self.threads, self)

    def _prepare(self) -> None:
        """Analyse the pattern, with the ordering that takes fewer operations."""
        columns = np.repeat(np.arange(1, self._n + 1), np.diff(self._ia))
        # a diagonally dominant probe for the analysis; later matrices share only the pattern
        self._a[:] = np.where(self._ja == columns, 1.0, 0.0)
        tried = [MINIMUM_DEGREE, NESTED_DISSECTION] if self._ordering is None else [self._ordering]
        operations = [self._analyse(ordering) for ordering in tried]
        best = tried[operations.index(min(operations))]
        if best != tried[-1]:
            self._analyse(best)
        self._ordering, self._is_analysed = best, True

    def _analyse(self, ordering: int) -> int:
        """Analyse with an ordering; returns the millions of operations that a factorisation takes."""
        if self._pt.any():
            self._call(RELEASE, np.zeros(1), np.zeros(1), 1)  # release the analysis before
            self._pt[:] = 0
        self._iparm[1], self._iparm[18] = ordering, -1
        self._call(11, np.zeros(1), np.zeros(1), 1)
        return int(self._iparm[18])

    def _call(self, phase: int, b: Array, x: Array, m: int) -> None:
        if self._n < LONG or phase == RELEASE:
            self._call_now(phase, b, x, m)
        else:
            self._calls.run(lambda: self._call_now(phase, b, x, m))

    def _call_now(self, phase: int, b: Array, x: Array, m: int) -> None:
        error = ctypes.c_int32(0)
        before = self._set_threads(self.threads)
        pt, one, kind, n, a, ia, ja, permutation, iparm, silent = self._arguments
        self._pardiso(
            pt, one, one, kind, int_argument(phase), n, a, ia, ja, permutation, int_argument(m),
            iparm, silent, array_argument(b, ctypes.c_double), array_argument(x, ctypes.c_double),
            ctypes.byref(error),
        )  # fmt: skip
        self._set_threads(before)  # 0 where the thread had no number of its own
        if error.value:
            reason = "not positive definite, " if error.value == ZERO_PIVOT else ""
            raise FactorisationError(f"{reason}PARDISO error {error.value} in phase {phase}")

    def refactor(self, values: Array) -> None:
        """See `Factorisation`."""
        self._calls.wait()  # one that was interrupted reads the pattern's analysis and the values
        if not self._is_analysed:
            self._prepare()
        np.take(values, self._places, out=self._a)
        self._call(22, np.zeros(1), np.zeros(1), 1)

    def solve(self, B: Array) -> Array:
        """See `Factorisation`."""
        return self._solved(WHOLE, B)

    def first_half(self, B: Array) -> Array:
        """See `HalfSolving`."""
        return self._solved(FORWARD, B)

    def second_half(self, Y: Array) -> Array:
        """See `HalfSolving`."""
        return self._solved(BACKWARD, Y)

    def _solved(self, phase: int, B: Array) -> Array:
        self._calls.wait()
        B = np.asfortranarray(B)
        X = np.empty_like(B, order="F")
        if B.size:
            self._call(phase, B, X, 1 if B.ndim == 1 else B.shape[1])
        return X

    def __del__(self) -> None:
        # MKL keeps the factors outside Python's memory; at exit modules are gone and it may keep them
        if not sys.is_finalizing() and hasattr(self, "_pt") and self._pt.any():
            self._call(RELEASE, np.zeros(1), np.zeros(1), 1)
