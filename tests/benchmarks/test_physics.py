"""The benchmarks of energy and equilibria on a small robot: numbers, tables, files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.processes import run_benchmark

from benchmarks.physics import (
    EnergyBench,
    EnergySettings,
    EquilibriaSettings,
    bench_energy,
    bench_equilibria,
)
from benchmarks.tables import energy_page


@pytest.fixture(scope="module")
def energy(beam_file: Path) -> EnergyBench:
    done: list[float] = []
    settings = EnergySettings((str(beam_file),), seconds=0.5, path_seconds=0.3)
    result = bench_energy(settings, lambda share, what: done.append(share))
    assert sum(done) == pytest.approx(1.0)
    return result


def test_converged_steps_gain_no_energy(energy: EnergyBench) -> None:
    kinds = [(course.motion, course.steps) for course in energy.courses]
    assert len(set(kinds)) == 4
    for course in energy.courses:
        assert course.energy[0] > 0.0
        if course.steps == "converged":
            assert course.largest_rise < 1e-6
        rises = np.diff(course.energy).max() / course.energy[0]
        assert course.largest_rise == pytest.approx(max(rises, 0.0))


def test_shares_of_the_distance_add_up(energy: EnergyBench) -> None:
    """No distance is larger than the sum of the others."""
    found = {name: one.value for name, one in energy.paths[0].distances.series.items()}
    own = found["state reduction"] + found["time"]
    others = own + found["contact basis"] + found["delay"]
    assert (found["plant against model"] <= others + 1e-12).all()
    assert (found["model without contact"] <= own + 1e-12).all()
    assert 0.0 < found["time"].max() < 0.05 * found["delay"].max()


def test_shorter_steps_lead_elsewhere(energy: EnergyBench) -> None:
    for found in energy.paths[0].step_lengths:
        assert 0.0 < found.rms_mm <= found.max_mm < 1.0


def test_tables_have_every_course_and_share(energy: EnergyBench, tmp_path: Path) -> None:
    courses, costs, shares, lengths = energy_page(energy).tables
    assert (len(courses.rows), len(costs.rows), len(shares.rows)) == (4, 1, 7)
    assert [row[1] for row in lengths.rows] == ["one linearisation", "converged"]
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- python -m benchmarks energy -->\nold\n<!-- end -->\nafter\n")
    energy_page(energy).put_into(page)
    assert "free swing" in page.read_text()
    assert "old" not in page.read_text()


@pytest.mark.slow
def test_the_command_writes_numbers_and_figures(beam_file: Path, tmp_path: Path) -> None:
    numbers, figures = tmp_path / "energy.json", [tmp_path / "a.png", tmp_path / "b.png"]
    command = ["energy", "--robot", beam_file, "--seconds", "0.2"]
    command += ["--path-seconds", "0.1", "--json", numbers]
    command += ["--figure", figures[0], "--distance-figure", figures[1]]
    assert run_benchmark(*command) == 0
    assert json.loads(numbers.read_text())["paths"]["beam"]["time"]["max_mm"] >= 0.0
    assert all(figure.stat().st_size > 1000 for figure in figures)


def test_every_random_start_settles(beam_file: Path) -> None:
    result = bench_equilibria(EquilibriaSettings((str(beam_file),), 10), lambda share, what: None)
    (group,) = result.groups
    assert (group.searches, group.converged, group.endings) == (10, 10, {})
    assert 1 <= group.median <= group.most
    assert group.median <= group.median_factorisations <= group.most_factorisations
