"""Every back end solves the same systems and refuses what it cannot factorise."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp

from tauten.model.numerics import (
    BACKENDS,
    FactorisationError,
    installed_backends,
    make_factorisation,
)
from tauten.model.numerics.factorisation import FEW, FewUnknowns, mkl


def random_spd(seed: int, n: int = 60) -> sp.csc_array:
    rng = np.random.default_rng(seed)
    pattern = sp.random_array((n, n), density=0.05, rng=np.random.default_rng(0))
    pattern = sp.csc_array(pattern + pattern.T + sp.eye_array(n))
    pattern.sort_indices()
    A = pattern.copy()
    A.data = rng.standard_normal(A.nnz)
    return sp.csc_array(A @ A.T + sp.eye_array(n))


@pytest.mark.parametrize("backend", sorted(BACKENDS))
def test_back_ends_refactor_and_solve(backend: str) -> None:
    if backend not in installed_backends():
        pytest.skip(f"{backend} is not installed")
    A = random_spd(1)
    A.sort_indices()
    factorisation = make_factorisation(A.indptr, A.indices, backend)
    rng = np.random.default_rng(2)
    for seed in (3, 4):
        A = random_spd(seed)
        A.sort_indices()
        factorisation.refactor(A.data)
        for b in (rng.standard_normal(60), np.asfortranarray(rng.standard_normal((60, 7)))):
            assert np.allclose(A @ factorisation.solve(b), b, atol=1e-9)
        assert factorisation.solve(np.zeros((60, 0))).shape == (60, 0)


def test_few_unknowns_have_dense_factors() -> None:
    A = random_spd(1, FEW)
    A.sort_indices()
    factorisation = make_factorisation(A.indptr, A.indices)
    assert isinstance(factorisation, FewUnknowns)
    B, dense = np.random.default_rng(2).standard_normal((FEW, 5)), A.toarray()
    with pytest.raises(FactorisationError, match="not positive definite"):
        factorisation.refactor(-A.data)
    with pytest.raises(FactorisationError, match="not finite"):
        factorisation.refactor(np.full(A.nnz, np.nan))
    for one in (factorisation, factorisation.fork(), pickle.loads(pickle.dumps(factorisation))):
        one.refactor(A.data)
        np.testing.assert_allclose(dense @ one.solve(B), B, atol=1e-9)
        Y = one.first_half(B)
        np.testing.assert_allclose(Y.T @ Y, B.T @ one.solve(B), atol=1e-9)
        np.testing.assert_allclose(one.second_half(Y), one.solve(B), atol=1e-12)


def test_the_fastest_installed_one_is_picked() -> None:
    A = random_spd(1)
    assert make_factorisation(A.indptr, A.indices).name == installed_backends()[0]


def test_unknown_back_end_is_refused_with_the_choices() -> None:
    A = random_spd(1)
    with pytest.raises(ValueError, match=r"'nothing' is not installed, available are .*superlu"):
        make_factorisation(A.indptr, A.indices, "nothing")


@pytest.mark.parametrize("backend", sorted(BACKENDS))
def test_indefinite_matrices_are_refused(backend: str) -> None:
    if backend not in installed_backends():
        pytest.skip(f"{backend} is not installed")
    A = random_spd(1)
    A.sort_indices()
    factorisation = make_factorisation(A.indptr, A.indices, backend)
    with pytest.raises(FactorisationError):
        factorisation.refactor(-A.data)
    factorisation.refactor(A.data)  # and usable afterwards
    assert np.allclose(A @ factorisation.solve(np.ones(60)), 1.0)


@pytest.mark.skipif("pardiso" not in installed_backends(), reason="pardiso is not installed")
def test_no_folder_is_searched_for_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    """pypardiso would start a compiler and read all of the environment for every matrix."""
    pytest.importorskip("pypardiso")
    searched: list[str] = []
    monkeypatch.setattr("pypardiso.pardiso_wrapper.find_library", searched.append)
    monkeypatch.delenv("PYPARDISO_MKL_RT", raising=False)
    mkl.cache_clear()
    A = random_spd(1)
    make_factorisation(A.indptr, A.indices, "pardiso")
    make_factorisation(A.indptr, A.indices, "pardiso")
    assert searched == []


@pytest.mark.long
@pytest.mark.skipif("pardiso" not in installed_backends(), reason="pardiso is not installed")
def test_no_folder_is_searched_when_the_library_is_imported() -> None:
    """pypardiso makes a solver when it is imported, and searches for it unless it knows the file."""
    code = (
        "import glob\n"
        "def found(*arguments, **options): raise AssertionError(arguments)\n"
        "glob.glob = found\n"
        "from tauten.model.numerics.factorisation import mkl\n"
        "mkl()\n"
    )
    environment = {k: v for k, v in os.environ.items() if k != "PYPARDISO_MKL_RT"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
