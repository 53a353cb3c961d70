import dataclasses
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from tauten.model import ContactRows, Contacts, Rows
from tauten.model.numerics import Array
from tauten.reduction import CurvePoint, Provenance, package_versions, storage
from tauten.reduction.contact import BasisError, ContactBasis

ORIGIN = Provenance(
    robot="thumb",
    robot_digest="ab" * 32,
    campaign="ramp: 0 to 40 mm in 800 steps",
    snapshots_digest="cd" * 32,
    snapshots=800,
    weighting="equal",
    method="hals",
    k=3,
    seed=0,
    error=0.0123,
    energy_error=0.01,
    tip_error=1e-5,
    curve=(CurvePoint(1, 0.4, 0.5, 2.0, 1e-3), CurvePoint(3, 0.01, 0.0123, 0.1, 1e-5)),
    created="2026-01-02T03:04:05+00:00",
    versions=package_versions(),
)


def a_basis(Psi: Array) -> ContactBasis:
    return ContactBasis(Psi, dataclasses.replace(ORIGIN, k=Psi.shape[1]))


@pytest.fixture
def basis() -> ContactBasis:
    rng = np.random.default_rng(0)
    Psi = rng.random((12, 3)) * (rng.random((12, 3)) < 0.5)
    Psi[:, 2] = 0.0
    Psi[4:6, 2] = 1.0  # a mode of two candidates only
    Psi[11] = 0.0  # a candidate that no mode touches
    return a_basis(Psi / np.linalg.norm(Psi, axis=0))


def contact_rows(slots: list[int], n_slots: int = 12, n: int = 20, seed: int = 0) -> ContactRows:
    """Random rows of the candidates in range."""
    rng = np.random.default_rng(seed)
    H = sp.random_array((len(slots), n), density=0.3, rng=rng, format="csr")
    index = np.array(slots, dtype=np.int64)
    gap, none = rng.normal(size=len(slots)), np.full((len(slots), 3), np.nan)
    found = Contacts(n_slots, index, np.zeros_like(index), gap, none, none, np.zeros_like(gap))
    return ContactRows(Rows(H, gap), found)


@settings(deadline=None)  # the first call compiles
@given(slots=st.lists(st.integers(0, 11), unique=True).map(sorted), seed=st.integers(0, 99))
def test_reduce_is_the_product_over_candidates_in_range(slots: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    Psi = rng.random((12, 4)) * (rng.random((12, 4)) < 0.4) + np.eye(12)[:, :4]
    basis = a_basis(Psi / np.linalg.norm(Psi, axis=0))
    contacts = contact_rows(slots, seed=seed)
    reduced = basis.reduce(contacts)
    in_play = basis.Psi[slots]  # (m, k)
    expected_modes = np.flatnonzero(in_play.sum(axis=0) > 0.0)
    np.testing.assert_array_equal(reduced.modes, expected_modes)
    product = in_play.T @ contacts.rows.H.toarray()
    np.testing.assert_allclose(reduced.H, product[expected_modes], atol=1e-14)
    np.testing.assert_allclose(
        reduced.delta, (in_play.T @ contacts.rows.delta)[expected_modes], atol=1e-14
    )
    assert reduced.H.T.flags.f_contiguous
    dense = dataclasses.replace(contacts, rows=Rows(contacts.rows.dense(), contacts.rows.delta))
    again = basis.reduce(dense)
    np.testing.assert_array_equal(again.modes, reduced.modes)
    np.testing.assert_allclose(again.H, reduced.H, atol=1e-14)
    np.testing.assert_allclose(again.delta, reduced.delta, atol=1e-14)


def test_mode_without_candidate_in_range_is_dropped(basis: ContactBasis) -> None:
    assert 2 in basis.reduce(contact_rows([0, 3, 5])).modes
    assert 2 not in basis.reduce(contact_rows([0, 3, 6])).modes
    assert len(basis.reduce(contact_rows([]))) == 0
    assert len(basis.reduce(contact_rows([11]))) == 0


def test_reduced_force_on_the_robot_is_the_pointwise_one(basis: ContactBasis) -> None:
    """H_cᵀ (Ψ β) = (Ψᵀ H_c)ᵀ β: the same force, with every candidate in range."""
    contacts = contact_rows(list(range(12)))
    reduced = basis.reduce(contacts)
    beta = np.array([0.3, 0.0, 2.0])
    np.testing.assert_allclose(
        contacts.rows.H.T @ basis.lift(beta), reduced.H.T @ beta[reduced.modes], atol=1e-14
    )


def test_full_basis_changes_nothing() -> None:
    """Unit columns for all candidates: rows, gaps and forces are the pointwise ones."""
    basis, contacts = a_basis(np.eye(12)), contact_rows([1, 4, 5, 9])
    reduced = basis.reduce(contacts)
    np.testing.assert_array_equal(reduced.H, contacts.rows.H.toarray())
    np.testing.assert_array_equal(reduced.delta, contacts.rows.delta)
    np.testing.assert_array_equal(reduced.modes, contacts.slots)
    np.testing.assert_array_equal(basis.lift(np.arange(12.0)), np.arange(12.0))


def test_untouched_candidates(basis: ContactBasis) -> None:
    np.testing.assert_array_equal(
        basis.untouched(), [slot for slot in range(12) if basis.Psi[slot].sum() == 0.0]
    )
    assert 11 in basis.untouched()


def test_round_trip(basis: ContactBasis, tmp_path: Path) -> None:
    path = basis.save(tmp_path / "thumb.basis")
    again = ContactBasis.load(path)
    np.testing.assert_array_equal(again.Psi, basis.Psi)
    assert again.provenance == basis.provenance
    assert again.provenance.versions[0][0] == "python"


def test_file_name_must_have_its_suffix(basis: ContactBasis, tmp_path: Path) -> None:
    with pytest.raises(BasisError, match=r"thumb.npz: a contact basis file ends in .basis"):
        basis.save(tmp_path / "thumb.npz")


@pytest.mark.parametrize("length", [0, 20, 400, -10])
def test_cut_file(basis: ContactBasis, tmp_path: Path, length: int) -> None:
    path = basis.save(tmp_path / "thumb.basis")
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(BasisError, match=r"thumb.basis: "):
        ContactBasis.load(path)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(
        BasisError, match=r"none\.basis: no contact basis can be read there \(No such file"
    ):
        ContactBasis.load(tmp_path / "none.basis")


def test_unknown_name() -> None:
    with pytest.raises(BasisError, match="no contact basis 'octopus': expected a path ending in"):
        ContactBasis.load("octopus")


@pytest.mark.parametrize(
    ("Psi", "message"),
    [
        (np.ones((4, 2)) / 2.0, r"expected \(n_c, 3\)"),
        (-np.eye(3), "negative or non-finite"),
        (np.full((4, 3), np.nan), "negative or non-finite"),
        (np.ones((4, 3)), "not of unit length"),
    ],
)
def test_content_that_is_no_basis(Psi: Array, message: str, tmp_path: Path) -> None:
    with pytest.raises(BasisError, match=message):
        ContactBasis(Psi, ORIGIN)
    path = tmp_path / "thumb.basis"
    storage.write(
        path, "tauten contact basis", {"provenance": dataclasses.asdict(ORIGIN)}, {"Psi": Psi}
    )
    with pytest.raises(
        BasisError, match=rf"thumb.basis: this contact basis file is damaged .*{message}"
    ):
        ContactBasis.load(path)


def test_header_without_an_entry(tmp_path: Path) -> None:
    header = {
        "provenance": {k: v for k, v in dataclasses.asdict(ORIGIN).items() if k != "robot_digest"}
    }
    path = tmp_path / "thumb.basis"
    storage.write(path, "tauten contact basis", header, {"Psi": np.eye(3)})
    with pytest.raises(BasisError, match=r"damaged \(robot_digest: Field required\)"):
        ContactBasis.load(path)
