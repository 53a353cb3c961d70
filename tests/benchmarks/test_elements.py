"""The comparison of elements on a small beam: what it measures, where it writes, what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import meshio
import pytest
from support.robots.bodies import box_mesh
from typer.testing import CliRunner

from benchmarks.commands import app
from benchmarks.elements import (
    ElementBenchSettings,
    ElementVariant,
    bench_elements,
    load_variant,
    parse_material,
)
from tauten.model import Simulator

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
        robot=str(beam), materials=("corotational", "neo-hookean"), positions=(0.1, 0.3), refinements=1,
        reference=1,
    )  # fmt: skip
    messages: list[str] = []
    result = bench_elements(settings, lambda _share, what: messages.append(what))
    assert len(messages) == 12
    assert [case.nodes for case in result.references] == [2025, 2025]
    errors = {}
    for case in result.cases:
        assert [state.position for state in case.equilibria] == [0.1, 0.3]
        assert all(state.converged for state in case.equilibria)
        assert case.step_ms.p50 is not None
        last = case.equilibria[-1]
        assert last.tension_error is not None
        assert last.contact_error is None
        errors[case.material, case.element, case.refinements] = last.tension_error
    assert len(errors) == len(result.cases) == 10
    for material in settings.materials:
        coarse = {
            element: errors[material, element, 0] for element in ("linear", "smoothed", "quadratic")
        }
        assert coarse["linear"] > 2.0 * abs(coarse["smoothed"])
        assert coarse["linear"] > 2.0 * abs(coarse["quadratic"])
        assert 0.0 < errors[material, "linear", 1] < coarse["linear"]


@pytest.mark.long
def test_the_command_writes_json_and_a_page(beam: Path, tmp_path: Path) -> None:
    numbers, page, figure = (
        tmp_path / name for name in ("elements.json", "page.md", "elements.png")
    )
    page.write_text("before\n<!-- python -m benchmarks elements -->\nold\n<!-- end -->\nafter\n")
    arguments = [
        "elements",
        "--robot",
        str(beam),
        "--refinements",
        "0",
        "--reference",
        "0",
    ]
    done = CliRunner().invoke(
        app, [*arguments, "--json", str(numbers), "--markdown", str(page), "--figure", str(figure)]
    )
    assert done.exit_code == 0, done.output
    cases = json.loads(numbers.read_text(encoding="utf-8"))["cases"]
    assert [case["element"] for case in cases] == ["linear", "smoothed"]
    text = page.read_text(encoding="utf-8")
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "| smoothed | 63 |" in text
    assert "old" not in text
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_a_silicone_has_its_own_law_and_the_young_modulus_of_the_robot(beam: Path) -> None:
    robots = {
        material: load_variant(str(beam), ElementVariant("linear", material, 0))
        for material in ("neo-hookean", "dragon-skin-10")
    }
    efforts = {}
    for material, robot in robots.items():
        simulator = Simulator(robot, contact="none")
        assert simulator.settle(position=[0.002]).converged
        efforts[material] = simulator.effort[0]
        assert robot.body.tetrahedra.mass.sum() == pytest.approx(
            robots["neo-hookean"].body.tetrahedra.mass.sum()
        )
    # Stiffness in bending is Young's modulus; Poisson's ratio 0.49 instead of 0.45 locks linear elements.
    assert 1.0 < efforts["dragon-skin-10"] / efforts["neo-hookean"] < 2.0


def test_a_material_that_is_none(beam: Path) -> None:
    with pytest.raises(ValueError, match="material is 'yeoh', to compare are corotational, stable"):
        parse_material("yeoh")
    done = CliRunner().invoke(app, ["elements", "--robot", str(beam), "--material", "ogden"])
    assert done.exit_code == 2
    assert "material is 'ogden'" in done.output
