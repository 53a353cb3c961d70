import numpy as np
import pytest

from tauten.model.numerics import Array
from tauten.reduction.contact import snapshot_weights


def test_equal_weights_bring_columns_to_unit_length(forces: Array) -> None:
    norms = np.linalg.norm(forces, axis=0)
    weighted = np.linalg.norm(forces * snapshot_weights(forces, "equal"), axis=0)
    strong = norms > 1e-3 * norms.max()
    np.testing.assert_allclose(weighted[strong], 1.0)
    assert (weighted[~strong] < 1.0).all()
    assert np.isfinite(weighted).all()


def test_force_weights_leave_columns_alone(forces: Array) -> None:
    np.testing.assert_array_equal(snapshot_weights(forces, "force"), 1.0)
    with pytest.raises(ValueError, match="'mass' is unknown: one of equal, force"):
        snapshot_weights(forces, "mass")  # type: ignore[arg-type]


def test_no_force_at_all_makes_no_infinity() -> None:
    assert np.isfinite(np.zeros((3, 2)) * snapshot_weights(np.zeros((3, 2)), "equal")).all()
