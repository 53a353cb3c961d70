"""`python -m benchmarks contact-basis` on the thumb: what it finds holds, and where it goes."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pytest
from support.robots.thumb import write_thumb

from benchmarks.contact_basis import ContactBasisBench, ContactBasisInputs, bench_contact_basis
from benchmarks.plots import draw_contact_basis
from benchmarks.tables import contact_basis_page
from tauten.model import load_robot
from tauten.reduction.campaign import ramp
from tauten.reduction.contact import ReduceSettings, reduce_robot
from tauten.service.process import StopFlag


def inputs(folder: Path, step: float) -> ContactBasisInputs:
    """The thumb's campaign with steps of this pull [m], and its basis."""
    robot = load_robot(write_thumb(folder))
    settings = ReduceSettings(k=4)
    made = reduce_robot(robot, ramp(robot, step), folder / "campaign", settings)
    return ContactBasisInputs(
        robot, made.basis, made.snapshots, folder / "campaign", 6, 3, ks=(2, 5)
    )


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> ContactBasisBench:
    fine = inputs(tmp_path_factory.mktemp("thumb"), 2e-4)
    return bench_contact_basis(fine, StopFlag(), lambda share, what: None)


@pytest.mark.slow
def test_errors_of_the_default_method_fall(result: ContactBasisBench) -> None:
    assert result.complete
    energy = [error for error in result.training if error.method == "energy"]
    assert [error.k for error in energy] == sorted(error.k for error in energy)
    assert energy[-1].energy < 0.5 * energy[0].energy
    for error in energy:
        others = [e.energy for e in result.training if e.k == error.k and e.method != "energy"]
        assert error.energy < min(others)
    # without a certificate, two modes let the walls pass each other by a millimetre where the thumb is bent
    # most, and there it has no stable equilibrium; five hold it on the whole path
    assert energy[0].unsettled <= 1
    assert energy[-1].unsettled == 0
    assert energy[-1].max_mm is not None
    assert energy[-1].max_mm < 0.003 * result.size_mm


@pytest.mark.slow
def test_enrichment_never_hurts_the_worst_path(result: ContactBasisBench) -> None:
    bare, rich = (
        max(e.max_mm or 0.0 for e in result.held_out if e.enriched is enriched)
        for enriched in (False, True)
    )
    assert rich <= bare
    assert all(error.max_mm is not None for error in result.held_out), "or a path counts as exact"
    assert len(result.held_out) == 2 * 19
    assert any(error.extra_columns for error in result.held_out if error.enriched)


@pytest.mark.slow
def test_full_problems_are_solved(result: ContactBasisBench) -> None:
    exact = result.lcp[0]
    assert exact.solver == "active set"
    assert exact.solved == exact.problems > 0
    assert exact.residual_m <= 1e-9


@pytest.mark.slow
def test_it_goes_into_json_a_page_and_a_picture(result: ContactBasisBench, tmp_path: Path) -> None:
    assert json.loads(json.dumps(asdict(result)))["basis"] == "energy, k = 4"
    page = tmp_path / "page.md"
    marks = ("<!-- python -m benchmarks contact-basis -->", "<!-- end -->")
    page.write_text(f"before\n\n{marks[0]}\nold\n{marks[1]}\n\nafter\n")
    contact_basis_page(result).put_into(page)
    text = page.read_text()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text
    for table in contact_basis_page(result).tables:
        assert table.title in text
    draw_contact_basis(result, tmp_path / "bench.png")
    assert (tmp_path / "bench.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.long
def test_stopping_keeps_what_is_done(tmp_path: Path) -> None:
    stop, done = StopFlag(), []

    def progress(share: float, what: str) -> None:
        done.append(what)
        if done.count("bases on the training path") == 3:  # announced once, then after each
            stop.request()

    found = bench_contact_basis(inputs(tmp_path, 8e-4), stop, progress)
    assert not found.complete
    assert len(found.training) == 2
    assert found.held_out == ()
    assert found.lcp
