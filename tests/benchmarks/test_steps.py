"""`python -m benchmarks sofa-meshes`: targets, numbers, and the refusal of a folder without the meshes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.processes import run_benchmark

from benchmarks.steps.sofa_meshes import circle
from tauten.service.bench.steps import WARM_UP


def test_a_circle_begins_at_its_centre_and_is_closed() -> None:
    centre = np.array([0.01, 0.02, 0.03])
    targets = circle(centre, 9, radius=0.005)[:, 0]
    assert len(targets) == 9 + WARM_UP
    np.testing.assert_allclose(targets[0], centre)
    np.testing.assert_allclose(targets[WARM_UP], targets[-1], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(targets[WARM_UP:] - centre, axis=1), 0.005)


def test_a_folder_without_the_meshes_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_benchmark("sofa-meshes", "--data", str(tmp_path)) == 2
    assert "sofa_robots" in capsys.readouterr().err


@pytest.mark.slow
def test_steps_on_the_meshes_of_sofa(reference: Path, tmp_path: Path) -> None:
    file, page = tmp_path / "numbers.json", tmp_path / "page.md"
    page.write_text("<!-- python -m benchmarks sofa-meshes -->\n<!-- end -->\n", encoding="utf-8")
    options = (
        "--data",
        str(reference),
        "--steps",
        "5",
        "--json",
        str(file),
        "--markdown",
        str(page),
    )
    assert run_benchmark("sofa-meshes", *options) == 0
    found = json.loads(file.read_text(encoding="utf-8"))["robots"]
    assert {row["robot"]: row["sizes"]["nodes"] for row in found} == {
        "diamond": 1628, "trunk": 709, "finger": 857,
    }  # fmt: skip
    for row in found:
        assert row["inverse"]["statuses"] == {"OK": 5}
        assert row["forward_ms"]["p50"] > 0.0
    text = page.read_text(encoding="utf-8")
    assert "| trunk | 709 | forward |" in text
    assert "was not run here" in text
