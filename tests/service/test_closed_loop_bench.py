"""The closed-loop benchmark: its runs, its numbers, and what must come out of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tauten.controller import Controller
from tauten.model import Robot, Simulator, load_robot
from tauten.reduction import ContactBasis
from tauten.service.bench_closed_loop import BenchSettings, bench_closed_loop
from tauten.service.cases import CASES, Case, make_cases
from tauten.service.closed_loop_figures import draw_case
from tauten.service.closed_loop_run import Outcome, Trace, follow, judge, settling
from tauten.service.stopping import StopFlag

LENGTH = 0.1
STIFFER = 1.2


@pytest.fixture(scope="module")
def cases(beam: Robot) -> list[Case]:
    return make_cases(beam, 4.0, 0, lambda: None)


def test_cases_start_at_rest_and_stay_in_reach(beam: Robot, cases: list[Case]) -> None:
    assert tuple(case.name for case in cases) == CASES
    rest = beam.effector(beam.rest())
    for case in cases:
        assert case.targets.shape == (200, 2, 3)
        np.testing.assert_allclose(case.targets[0], rest, atol=1e-6)
        assert 0.002 < np.linalg.norm(case.targets[:, 0] - rest[0], axis=1).max() < 0.08
    again = make_cases(beam, 4.0, 0, lambda: None)
    np.testing.assert_array_equal(again[3].targets, cases[3].targets)


@pytest.mark.parametrize("scale", [0.8, STIFFER])
def test_a_robot_of_another_stiffness_settles_in_closed_loop_only(
    beam: Robot, beam_file: Path, cases: list[Case], scale: float
) -> None:
    plant = Simulator(load_robot(beam_file, young_scale=scale), "none")
    controller = Controller(beam)
    found: dict[bool, Outcome] = {}
    for closed in (False, True):
        trace = follow(controller, plant, cases[0], closed, "tension")
        found[closed] = judge(cases[0], trace, beam.h, "none", closed, scale, "tension")
    assert found[True].end_mm < 0.01 * 1e3 * LENGTH
    assert found[False].end_mm > 3.0 * found[True].end_mm
    assert found[False].settling_s is None


def test_a_run_is_deterministic(beam: Robot, cases: list[Case]) -> None:
    short = Case("circle", cases[1].targets[:60], 0)
    traces = [
        follow(Controller(beam), Simulator(beam, "none"), short, True, "pull") for _ in range(2)
    ]
    np.testing.assert_array_equal(traces[0].effector, traces[1].effector)
    np.testing.assert_array_equal(traces[0].pull, traces[1].pull)


def made_up(error: list[float]) -> Trace:
    zero = np.zeros((len(error), 1))
    times = np.zeros(len(error))
    touching = np.zeros(len(error), dtype=bool)
    return Trace(np.zeros((len(error), 3)), np.array(error), zero, zero, times, times, touching, 0)


def test_settling_counts_from_the_step_to_the_last_time_outside() -> None:
    targets = np.zeros((6, 1, 3))
    targets[2:, 0, 0] = 1.0
    step = Case("step", targets, 2)
    assert settling(step, made_up([0.0, 0.0, 1.0, 0.5, 0.01, 0.01]), 0.1) == pytest.approx(0.2)
    assert settling(step, made_up([0.0, 0.0, 1.0, 0.01, 0.5, 0.01]), 0.1) == pytest.approx(0.3)
    assert settling(step, made_up([0.0, 0.0, 1.0, 0.5, 0.5, 0.5]), 0.1) is None
    assert settling(Case("circle", targets, 0), made_up([0.0] * 6), 0.1) is None


def test_a_figure_is_drawn(beam: Robot, cases: list[Case], tmp_path: Path) -> None:
    case = Case("circle", cases[1].targets[:30], 0)
    trace = follow(Controller(beam), Simulator(beam, "none"), case, True, "pull")
    outcome = judge(case, trace, beam.h, "none", True, 1.0, "pull")
    draw_case("circle", case, [(outcome, trace)], beam.h, tmp_path / "circle.png")
    assert (tmp_path / "circle.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_without_contact_the_finger_is_missed(tmp_path: Path) -> None:
    robot, path = load_robot("finger"), Path("finger")
    basis = ContactBasis.load("finger")
    settings = BenchSettings(2.0, 0, tmp_path)
    result = bench_closed_loop(robot, path, basis, settings, StopFlag(), lambda share, what: None)
    assert result.complete
    assert {file.stem for file in tmp_path.iterdir()} == {
        *CASES, "stiffness-0.8", "stiffness-1.2",
    }  # fmt: skip
    by = {(o.case, o.contact, o.closed): o for o in result.outcomes if o.young_scale == 1.0}
    for closed in (False, True):
        reduced, none = by["contact", "reduced", closed], by["contact", "none", closed]
        assert none.rms_mm > 2.0 * reduced.rms_mm
    for one in result.outcomes:
        if one.young_scale != 1.0:
            assert (one.end_mm < 0.01 * 1e3 * LENGTH) == one.closed
