"""The comparison of elements on a small beam: what it measures, where it writes, what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import meshio
import pytest
from support.robots.bodies import box_mesh
from typer.testing import CliRunner

from tauten.service.bench.elements import ElementBenchSettings, bench_elements, parse_law
from tauten.service.cli.app import app

SIZE = (0.06, 0.02, 0.02)
BEAM = """
name = "beam"
gravity = [0.0, 0.0, 0.0]
[mesh]
file = "beam.vtu"
[material]
young_modulus = 1e6
poisson_ratio = 0.45
density = 1000.0
[[fixed]]
lower = [0.0, 0.0, 0.0]
upper = [0.0, 0.02, 0.02]
[[cables]]
name = "tendon"
points = [[0.01, 0.01, 0.005], [0.06, 0.01, 0.005]]
max_tension = 100.0
max_pull = 0.01
max_rate = 0.1
[[effectors]]
name = "tip"
point = [0.06, 0.01, 0.01]
"""


@pytest.fixture
def beam(tmp_path: Path) -> Path:
    mesh = box_mesh(SIZE, (6, 2, 2))
    meshio.write(tmp_path / "beam.vtu", meshio.Mesh(mesh.nodes, [("tetra", mesh.tets)]))
    path = tmp_path / "beam.toml"
    path.write_text(BEAM, encoding="utf-8")
    return path


@pytest.mark.slow
def test_elements_are_compared_with_the_fine_quadratic_mesh(beam: Path) -> None:
    settings = ElementBenchSettings(
        robot=str(beam), laws=("corotational", "neo-hookean"), pulls=(0.1, 0.3), refinements=1,
        reference=1,
    )  # fmt: skip
    messages: list[str] = []
    result = bench_elements(settings, lambda _share, what: messages.append(what))
    assert len(messages) == 12
    assert [case.nodes for case in result.references] == [2025, 2025]
    errors = {}
    for case in result.cases:
        assert [state.pull for state in case.equilibria] == [0.1, 0.3]
        assert all(state.converged for state in case.equilibria)
        assert case.step_ms.p50 is not None
        last = case.equilibria[-1]
        assert last.tension_error is not None
        assert last.contact_error is None
        errors[case.law, case.element, case.refinements] = last.tension_error
    assert len(errors) == len(result.cases) == 10
    for law in settings.laws:
        coarse = {
            element: errors[law, element, 0] for element in ("linear", "smoothed", "quadratic")
        }
        assert coarse["linear"] > 2.0 * abs(coarse["smoothed"])
        assert coarse["linear"] > 2.0 * abs(coarse["quadratic"])
        assert 0.0 < errors[law, "linear", 1] < coarse["linear"]


def test_the_command_writes_json_and_a_page(beam: Path, tmp_path: Path) -> None:
    numbers, page = tmp_path / "elements.json", tmp_path / "page.md"
    page.write_text("before\n<!-- tauten bench elements -->\nold\n<!-- end -->\nafter\n")
    arguments = [
        "bench",
        "elements",
        "--robot",
        str(beam),
        "--refinements",
        "0",
        "--reference",
        "0",
    ]
    done = CliRunner().invoke(app, [*arguments, "--json", str(numbers), "--markdown", str(page)])
    assert done.exit_code == 0, done.output
    cases = json.loads(numbers.read_text(encoding="utf-8"))["cases"]
    assert [case["element"] for case in cases] == ["linear", "smoothed"]
    text = page.read_text(encoding="utf-8")
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "| smoothed | 63 |" in text
    assert "old" not in text


def test_a_law_that_is_none(beam: Path) -> None:
    with pytest.raises(ValueError, match="law is 'yeoh', to compare are corotational, stable-neo"):
        parse_law("yeoh")
    done = CliRunner().invoke(app, ["bench", "elements", "--robot", str(beam), "--law", "ogden"])
    assert done.exit_code == 2
    assert "law is 'ogden'" in done.output
