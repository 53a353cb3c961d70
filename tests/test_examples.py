"""The examples run, and the numbers they assert hold."""

from __future__ import annotations

import runpy
from pathlib import Path

import meshio
import numpy as np
import pytest

from benchmarks.robots.grasping import MESHES

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("[0-9]*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_it_runs(example: Path) -> None:
    runpy.run_path(str(example), run_name="__main__")


def test_meshes_are_those_that_their_script_makes(tmp_path: Path) -> None:
    for make in MESHES.values():
        make(tmp_path)
    made = sorted(tmp_path.glob("*.vtu"))
    assert made
    for path in made:
        kept, new = meshio.read(EXAMPLES[0].with_name(path.name)), meshio.read(path)
        np.testing.assert_allclose(kept.points, new.points, atol=1e-9)
        np.testing.assert_array_equal(kept.cells_dict["tetra"], new.cells_dict["tetra"])
