"""Quadratic elements against CalculiX; `tests/reference/make_calculix.py` writes decks and results."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from support.robots.solids import body_of_quadratic_mesh

from tauten.model.materials import neo_hookean

REFERENCE = Path(__file__).parents[1] / "reference"
sys.path.insert(0, str(REFERENCE))
from make_calculix import cases, deck  # noqa: E402

RESULTS = json.loads((REFERENCE / "data/calculix.json").read_text(encoding="utf-8"))
CASES = cases()


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    [
        "block_tension",
        "block_shear",
        "cantilever",
        "cantilever_rubber",
        pytest.param("finger", marks=pytest.mark.slow),
    ],
)
def test_same_displacements_as_c3d10(name: str) -> None:
    """Same elements, same law, same quadrature: what is left is the tolerance of the two solvers."""
    case, expected = CASES[name], RESULTS[name]
    law = neo_hookean(case.young_modulus, case.poisson_ratio)
    body = body_of_quadratic_mesh(case.mesh, law, case.fixed)
    x = case.mesh.nodes
    for share in np.linspace(0.25, 1.0, 4):
        x, _ = body.equilibrium(share * case.load, start=x)
    u = x - case.mesh.nodes
    loaded = np.any(case.load != 0.0, axis=1)
    largest = float(expected["largest_displacement"])
    assert np.linalg.norm(u, axis=1).max() == pytest.approx(largest, rel=1e-4)
    mean = expected["mean_displacement_of_loaded_nodes"]
    assert u[loaded].mean(axis=0) == pytest.approx(mean, abs=1e-4 * largest)


@pytest.mark.parametrize("name", ["block_tension", "cantilever_rubber"])
def test_decks_kept_are_the_ones_the_script_writes(name: str) -> None:
    path = REFERENCE / f"data/calculix_{name}.inp"
    assert path.read_text(encoding="ascii") == deck(CASES[name])
