"""The manipulator's benchmark: postures, the paper's solver, tables."""

from __future__ import annotations

import dataclasses
from timeit import repeat

import numpy as np
import pytest
from support.robots.examples import shipped_robot

from benchmarks.control.still import random_goals
from benchmarks.manipulator import (
    KINDS,
    ArmBench,
    PostureError,
    Speed,
    arm_in_equilibrium,
    bent_tensions,
    gauss_seidel_step,
    measure_speed,
    parse_ks,
    posture_error,
    random_postures,
)
from benchmarks.plots import draw_posture_errors
from benchmarks.robots.arm import ArmShape, bending_tensions, tendon_angle
from benchmarks.steps import STAGES, WHOLE, StepTimes
from benchmarks.tables import arm_page
from tauten.controller import Controller, load_controller_settings
from tauten.model import Forces, Robot
from tauten.reduction import ContactBasis
from tauten.reduction.campaign import run_campaign
from tauten.service.bench import Comparison
from tauten.service.plant.paths import directions
from tauten.service.process import host_info
from tauten.service.replay import Spread


@pytest.fixture(scope="module")
def arm() -> Robot:
    return shipped_robot("manipulator_1290")


def test_bending_tensions_bend_towards_their_angle() -> None:
    shape, rng = ArmShape(), np.random.default_rng(0)
    for _ in range(20):
        angles, forces = rng.uniform(-7.0, 7.0, 3), rng.uniform(1.0, 50.0, 3)
        effort = bending_tensions(shape, angles, forces).reshape(3, 3)
        assert (effort >= 0.0).all()
        assert ((effort > 0.0).sum(axis=1) <= 2).all()
        for section in range(3):
            at = np.array([tendon_angle(shape, section, k) for k in range(3)])
            position = effort[section] @ np.stack([np.cos(at), np.sin(at)], axis=1)
            towards = np.array([np.cos(angles[section]), np.sin(angles[section])])
            np.testing.assert_allclose(position, forces[section] * towards, atol=1e-9)


def test_cables_pull_the_tip_to_where_they_run(arm: Robot) -> None:
    shape = ArmShape()
    expected = [tendon_angle(shape, s, k) for s in range(3) for k in range(3)]
    np.testing.assert_allclose(directions(arm, 0), expected, atol=1e-3)


def test_gauss_seidel_finds_the_same_forces(arm: Robot) -> None:
    there = arm_in_equilibrium(arm, bent_tensions())
    assert there.lam_c.sum() > 50.0
    forces, sweeps, _ = gauss_seidel_step(there, bent_tensions(), there.lam_c)
    assert sweeps >= 1
    assert forces.sum() == pytest.approx(there.lam_c.sum(), rel=0.05)


def test_speed_is_measured(arm: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three steps instead of hundreds."""
    monkeypatch.setattr(
        "benchmarks.manipulator.speed.times",
        lambda work, *_, **__: np.array(repeat(work, number=1, repeat=3)),
    )
    basis = ContactBasis.load("manipulator_1290")
    basis.check_robot(arm)
    straight = measure_speed(arm, basis, np.zeros(9), "straight")
    assert (straight.in_range, straight.pushing) == (0, 0)
    assert 0.0 < straight.control_reduced_ms <= straight.control_reduced_p99_ms


@pytest.mark.slow
def test_certified_basis_follows_the_full_arm(
    arm: Robot, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Held-out postures: within the tolerance in millimetres, far from them without certificate."""
    design = random_postures(arm, count=2, steps=5, seed=3)
    runs = run_campaign(arm, design, tmp_path_factory.mktemp("held"))
    assert runs.converged.all()
    assert np.isnan(design.runs[0].position).all()
    np.testing.assert_allclose(runs.effort[:, 4], design.runs[0].effort[:, -1])
    assert runs.lam[:, 4].sum() > 10.0
    basis = ContactBasis.load("manipulator_1290")
    certified = posture_error(arm, basis, runs, "held-out", True)
    alone = posture_error(arm, basis, runs, "held-out", False)
    assert certified.max_mm < 1.0
    assert certified.unsettled == 0
    assert alone.max_mm > certified.max_mm
    assert certified.extra_columns > 0


def served(arm: Robot, regularisation: float | None = None) -> Controller:
    """A controller with the arm's own basis and settings, so with the default horizon.

    Args:
        arm: the robot.
        regularisation: another one than in the file; None: that of the file.
    """
    settings = load_controller_settings("manipulator_1290")
    if regularisation is not None:
        settings = settings.model_copy(update={"regularisation": regularisation})
    return Controller(arm, ContactBasis.load("manipulator_1290"), settings=settings)


@pytest.mark.slow
@pytest.mark.parametrize("regularisation", [None, 1e-6])
def test_arm_with_ribs_in_contact_stands_still(arm: Robot, regularisation: float | None) -> None:
    """Tensions become constant, near the least that hold the tip, and the arm never runs away.

    With a tangent that is many times too stiff in motion it went on for ever, and with the regularisation of
    the file swung by a quarter of its length.
    """
    effort = 0.8 * bent_tensions()
    there = arm_in_equilibrium(arm, effort)
    controller = served(arm, regularisation)
    none = np.zeros(0, dtype=np.int64)
    forces = Forces(there.effort, np.zeros(controller.space.k), none, np.zeros(0))
    controller.start_from(there.state, forces, there.position)
    assert controller.position == pytest.approx(there.position)
    goal, efforts, away = there.effector, [], 0.0
    for _ in range(500):
        efforts.append(controller.step(goal).effort)
        away = max(away, float(np.linalg.norm(controller.effector - goal)))
    controller.prepare()
    assert len(controller.contacts) > 100
    assert away < 0.02
    assert np.linalg.norm(controller.effector - goal) < 5e-4
    last = np.array(efforts[-50:])
    assert np.abs(np.diff(last, axis=0)).max() < 0.05  # N
    assert last[-1].sum() < 1.5 * effort.sum()


@pytest.mark.slow
def test_arm_stands_still_far_away(arm: Robot) -> None:
    """A random target, to which the arm gets with limits of tension and slack tendons."""
    *_, goal = random_goals(arm, np.random.default_rng(0), 6)
    controller = served(arm)
    assert controller.settle_start().converged
    positions = np.array([controller.step(goal).position for _ in range(300)])
    assert np.ptp(positions[-50:], axis=0).max() < 1e-5  # m


@pytest.mark.long
def test_tables_and_figure(arm: Robot, tmp_path) -> None:  # type: ignore[no-untyped-def]
    errors = [
        PostureError(method, k, certified, name, 1.0, 2.0 / k, 3.0, 4, 0)
        for method, _, certified in KINDS
        for k in (5, 23)
        for name in ("training", "held-out")
    ]
    draw_posture_errors(errors, tmp_path / "errors.png")
    assert (tmp_path / "errors.png").stat().st_size > 10_000
    speed = Speed(4500, "bent", 2250, 50, 1000.0, 1000, False, 20.0, 5.0, 40.0, 10.0, 15.0)
    contact = Comparison("manipulator", ([], []), ([], []), [300.0], 50, 400.0, 20.0, (1.0, 1.0))
    one = Spread(1.0, 2.0, 3.0)
    stages = StepTimes(
        "reduced, k = 23", 200, dict.fromkeys(STAGES, one), dict.fromkeys(WHOLE, one), 40.0, 2250.0,
        one, -0.001, {"OK": 200},
    )  # fmt: skip
    result = ArmBench(
        host_info(), (speed,), stages, contact, "a campaign", 1400, (errors[0],), tuple(errors)
    )
    page = tmp_path / "page.md"
    page.write_text("<!-- python -m benchmarks manipulator --><!-- end -->", encoding="utf-8")
    arm_page(result).put_into(page)
    text = page.read_text(encoding="utf-8")
    assert "| 4,500, bent | 2,250 | 1 * | 50 | 200 | 200.0 | 4.00 | 25 | 100 |" in text
    assert "2,250 candidates in range, reduced, k = 23, 40 contact rows" in text
    assert "Contact moves the tip 300 mm; 50 candidates push with 400 N" in text
    assert "| held-out | als | 5 | no | 1.00 | 0.40 | 3.00 | 4 | 0 |" in text
    assert dataclasses.asdict(result)["contact"]["apart_mm"] == [300.0]


def test_numbers_of_modes_are_read() -> None:
    assert parse_ks("5, 23") == (5, 23)
    for text in ("", "5,x", "23,5", "0,5"):
        with pytest.raises(ValueError, match="modes are"):
            parse_ks(text)
