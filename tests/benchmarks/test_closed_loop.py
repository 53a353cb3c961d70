"""`python -m benchmarks closed-loop`: its cases, its numbers, and what must come out of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.thumb import write_coarse_finger

from benchmarks.control import (
    CASES,
    Case,
    CaseRunner,
    CaseRuns,
    Outcome,
    bench_cases,
    make_cases,
    planned,
)
from benchmarks.control.outcome import case_outcome, settling
from benchmarks.plots import draw_case
from benchmarks.tables import closed_loop_page
from tauten.controller import Controller
from tauten.model import Robot, Simulator, load_robot
from tauten.reduction.campaign import ramp, run_campaign
from tauten.reduction.contact import ReduceSettings, make_basis
from tauten.service.bench import Trace, follow
from tauten.service.plant import DrivenRobot
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup

LENGTH = 0.1
STIFFER = 1.2


@pytest.fixture(scope="module")
def cases(beam: Robot) -> list[Case]:
    return make_cases(beam, 4.0, 0, lambda: None)


def test_cases_start_at_rest_and_are_within_reach(beam: Robot, cases: list[Case]) -> None:
    assert tuple(case.name for case in cases) == CASES
    rest = beam.effector_values(beam.rest())
    for case in cases:
        assert case.targets.shape == (200, 6)
        np.testing.assert_allclose(case.targets[0], rest, atol=1e-6)
        assert 0.002 < np.linalg.norm(case.targets[:, :3] - rest[:3], axis=1).max() < 0.08
    again = make_cases(beam, 4.0, 0, lambda: None)
    np.testing.assert_array_equal(again[3].targets, cases[3].targets)


@pytest.mark.long
@pytest.mark.parametrize("scale", [pytest.param(0.8, marks=pytest.mark.slow), STIFFER])
def test_a_robot_of_another_stiffness_settles_in_closed_loop_only(
    beam: Robot, beam_file: Path, cases: list[Case], scale: float
) -> None:
    plant = DrivenRobot(Simulator(load_robot(beam_file, young_scale=scale), "none"), 1)
    controller = Controller(beam)
    found: dict[bool, Outcome] = {}
    for closed in (False, True):
        trace = follow(controller, plant, cases[0].targets, None, closed, "tension")
        found[closed] = case_outcome(cases[0], trace, beam.h, "none", closed, scale, "tension")
    assert found[True].end_mm < 0.01 * 1e3 * LENGTH
    assert found[False].end_mm > 3.0 * found[True].end_mm
    assert found[False].settling_s is None


def made_up(error: list[float]) -> Trace:
    zero = np.zeros((len(error), 1))
    times = np.zeros(len(error))
    touching = np.zeros(len(error), dtype=bool)
    tips, errors = np.zeros((len(error), 3)), np.array(error)
    return Trace(tips, errors, zero, zero, times, times, times, touching, touching, tips, errors)


def test_settling_counts_from_the_step_to_the_last_time_outside() -> None:
    targets = np.zeros((6, 3))
    targets[2:, 0] = 1.0
    step = Case("step", targets, 2, 1.0)
    assert settling(step, made_up([0.0, 0.0, 1.0, 0.5, 0.01, 0.01]), 0.1) == pytest.approx(0.2)
    assert settling(step, made_up([0.0, 0.0, 1.0, 0.01, 0.5, 0.01]), 0.1) == pytest.approx(0.3)
    assert settling(step, made_up([0.0, 0.0, 1.0, 0.5, 0.5, 0.5]), 0.1) is None
    assert settling(Case("circle", targets, 0), made_up([0.0] * 6), 0.1) is None


@pytest.mark.long
def test_a_figure_is_drawn(beam: Robot, cases: list[Case], tmp_path: Path) -> None:
    case = Case("circle", cases[1].targets[:30], 0)
    plant = DrivenRobot(Simulator(beam, "none"), 1)
    trace = follow(Controller(beam), plant, case.targets, closed=True)
    outcome = case_outcome(case, trace, beam.h, "none", True, 1.0, "pull")
    found = CaseRuns("circle", case, ((outcome, trace),))
    draw_case(found, beam.h, tmp_path / "circle.png")
    assert (tmp_path / "circle.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_without_contact_the_finger_is_missed(tmp_path: Path) -> None:
    """On a coarse mesh, with a contact basis of its own: eight runs of the shipped one take half an hour."""
    setup = load_setup(write_coarse_finger(tmp_path), model="full")
    design = ramp(setup.robot, step=5e-4)
    found = run_campaign(setup.robot, design, tmp_path / "ramp")
    snapshots = found.select(found.converged)
    basis, _ = make_basis(setup.robot, snapshots, ReduceSettings(k=6))
    setup = replace(setup, contact=basis)
    bench = CaseRunner(setup)
    cases = make_cases(setup.robot, 4.0, 0, lambda: None)
    groups = {group.name: group for group in planned(cases)}
    assert set(groups) == {*CASES, "stiffness-0.8", "stiffness-1.2"}
    for closed in (False, True):
        reduced, along = bench.run(groups["contact"], "reduced", closed)
        _, blind = bench.run(groups["contact"], "none", closed)
        assert reduced.touching > 0.3
        both = along.touching & blind.touching  # on the way back the cable is slack, and all lag
        assert np.mean(blind.error[both]) > 2.0 * np.mean(along.error[both])
        for name in ("stiffness-0.8", "stiffness-1.2"):
            outcome, _ = bench.run(groups[name], "reduced", closed)
            assert (outcome.end_mm < 0.01 * 1e3 * LENGTH) == closed


@pytest.mark.long
def test_a_stopped_benchmark_keeps_what_is_done(beam_file: Path) -> None:
    stop = StopFlag()

    def progress(share: float, what: str = "") -> None:
        if what == "step" and share > 0.0:
            stop.request()

    result, runs = bench_cases(load_setup(beam_file), 1.0, 0, stop, progress)
    assert not result.complete
    assert [(one.case, one.contact, one.closed) for one in result.outcomes] == [
        ("step", "reduced", False)
    ]
    assert [one.name for one in runs] == ["step"]
    assert runs[0].runs[0][0] == result.outcomes[0]
    page = closed_loop_page(result)
    assert [len(table.rows) for table in page.tables] == [1, 1]
