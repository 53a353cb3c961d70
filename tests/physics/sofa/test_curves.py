"""Trunk, diamond and finger of SoftRobots on the curves of SOFA (reference data README), with cables.

Elements and points as SOFA has them leave only what its iterations leave, at most 2 nm a step. Our own points
outside the mesh, attached to the element with the nearest face, leave a few hundredths of a millimetre.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.sofa_fingers import finger_with_gravity
from support.robots.sofa_robots import robots_folder
from support.sofa.elements import MM, assemble_with, large_frames, points_as_in_sofa

from benchmarks.physics import diamond, trunk
from tauten.controller import Controller, ControllerSettings
from tauten.model import Robot, Simulator
from tauten.model.numerics import Array
from tauten.model.tetra import NodalBody
from tauten.model.tetra import solid as solid_module

SETTLED = 2e-6  # mm; rows of SOFA that moved more in their last step are no equilibria
DIGITS, FORCE_DIGITS = 3e-5, 5e-3  # mm and mN, where elements and points are those of SOFA
CABLES = ("L0", "L1", "S1")
slow = pytest.mark.slow


@pytest.fixture(scope="module")
def data(reference: Path) -> Path:
    return robots_folder(reference, "diamond_large_settled.csv")


def read_curve(file: Path) -> Array:
    curve: Array = np.genfromtxt(file, delimiter=",", names=True)
    return curve[curve["last_max_dx"] < SETTLED]


def vector(row: Array, name: str) -> Array:
    """The columns NAME_x, NAME_y, NAME_z."""
    return np.array([row[f"{name}_{axis}"] for axis in "xyz"])


def numbers(row: Array, names: list[str]) -> Array:
    return np.array([row[name] for name in names])


@dataclass(frozen=True, slots=True)
class Reached:
    """Where a target has led: tip (3,) [mm], shortenings [mm] and tensions [mN] of the cables."""

    tip: Array
    position: Array
    effort: Array


def follow(robot: Robot[NodalBody], targets: Array, regularisation: float) -> list[Reached]:
    """Follow each target (3,) [mm] until nothing moves any more."""
    still = robot.with_integration(replace(robot.integration, static=True))
    controller = Controller(still, settings=ControllerSettings(regularisation=regularisation))
    reached = []
    for target in targets:
        before = controller.effector[0]
        for _ in range(100):
            effort = controller.step(MM * target).effort
            moved = float(np.abs(controller.effector[0] - before).max())
            before = controller.effector[0]
            if moved < 1e-9:  # m
                break
        reached.append(Reached(before / MM, controller.position / MM, effort / MM))
    return reached


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=slow)])
def test_trunk_with_sofas_points_has_sofas_digits(data: Path, every: int) -> None:
    """17 states of one cable, of which SOFA settles 16, and 10 of three of which one is slack at times."""
    model = np.load(data / "trunk_model.npz")
    for cables, file in (((CABLES[0],), "trunk_L0_fpolar.csv"), (CABLES, "trunk_combo_fpolar.csv")):
        with points_as_in_sofa(model, *(f"cable_{name}" for name in cables), "tip"):
            simulator = Simulator(trunk(data, cables), contact="none")
        for row in read_curve(data / file)[every::every]:
            position = MM * numbers(row, [f"imposed_{name}" for name in cables])
            if position.max() > 0.04:
                continue  # not settled in SOFA
            assert simulator.settle(position=position, tolerance=1e-9).converged
            assert np.abs(simulator.effector[0] / MM - vector(row, "tip")).max() < DIGITS
            effort = numbers(row, [f"tension_{name}" for name in cables])
            assert np.abs(simulator.effort / MM - effort).max() < FORCE_DIGITS


def test_trunk_with_our_points_follows_the_curve_of_three_cables(data: Path) -> None:
    simulator = Simulator(trunk(data, CABLES), contact="none")
    for row in read_curve(data / "trunk_combo_fpolar.csv")[1::2]:
        position = MM * numbers(row, [f"imposed_{name}" for name in CABLES])
        assert simulator.settle(position=position).converged
        assert np.linalg.norm(simulator.effector[0] / MM - vector(row, "tip")) < 0.07
        effort = numbers(row, [f"tension_{name}" for name in CABLES])
        assert np.abs(simulator.effort / MM - effort).max() < 0.3


@pytest.mark.long
@pytest.mark.parametrize("states", [slice(4, 5), pytest.param(slice(1, None), marks=slow)])
def test_the_inverse_of_the_trunk_leads_back_along_its_curve(data: Path, states: slice) -> None:
    """Tips of SOFA are targets; taut cables get SOFA's shortenings and tensions."""
    model = np.load(data / "trunk_model.npz")
    with points_as_in_sofa(model, *(f"cable_{name}" for name in CABLES), "tip"):
        robot = trunk(data, CABLES)
    rows = read_curve(data / "trunk_combo_fpolar.csv")[states]
    targets = np.array([vector(row, "tip") for row in rows])
    for row, target, found in zip(rows, targets, follow(robot, targets, 1e-6), strict=True):
        assert np.linalg.norm(found.tip - target) < 1.5e-3
        effort = numbers(row, [f"tension_{name}" for name in CABLES])
        assert np.abs(found.effort - effort).max() < 0.4
        taut = effort > 0.0
        wound = numbers(row, [f"imposed_{name}" for name in CABLES])
        assert np.abs(found.position - wound)[taut].max() < 3e-3


@pytest.mark.long
@pytest.mark.parametrize("states", [slice(1, 2), pytest.param(slice(None), marks=slow)])
def test_diamond_with_sofas_elements_and_points_has_sofas_digits(
    data: Path, monkeypatch: pytest.MonkeyPatch, states: slice
) -> None:
    """The 17 settled states of SOFA's inverse: under its tensions the tip and all lengths are the same."""
    with points_as_in_sofa(np.load(data / "diamond_model.npz"), "pts"):
        robot = diamond(data)
    patched = assemble_with(large_frames, robot.body.mesh)
    monkeypatch.setattr(solid_module, "assemble_corotational", patched)
    simulator = Simulator(robot, contact="none")
    for row in read_curve(data / "diamond_large_settled.csv")[states]:
        effort = MM * numbers(row, [f"tension{i}" for i in range(4)])
        assert simulator.settle(effort=effort, tolerance=1e-9).converged
        assert np.abs(simulator.effector[0] / MM - vector(row, "tip")).max() < DIGITS
        wound = numbers(row, [f"L0L_{i}" for i in range(4)])
        assert np.abs(simulator.position / MM - wound).max() < DIGITS


@pytest.mark.parametrize("states", [slice(0, 2), pytest.param(slice(None), marks=slow)])
def test_the_inverse_of_the_diamond_errs_less_than_sofas(data: Path, states: slice) -> None:
    """17 targets, our elements against SOFA's 'large': lengths within 0.1 mm, tensions within 3 %."""
    with points_as_in_sofa(np.load(data / "diamond_model.npz"), "pts"):
        robot = diamond(data)
    rows = read_curve(data / "diamond_large_settled.csv")[states]
    targets = np.array([vector(row, "goal") for row in rows])
    for row, target, found in zip(rows, targets, follow(robot, targets, 1e-4), strict=True):
        assert np.linalg.norm(found.tip - target) < 0.25 * row["err"]
        wound = numbers(row, [f"L0L_{i}" for i in range(4)])
        assert np.abs(found.position - wound).max() < 0.1
        effort = numbers(row, [f"tension{i}" for i in range(4)])
        assert np.abs(found.effort - effort).max() < 0.03 * effort.max()


def test_stiff_finger_under_gravity_has_sofas_digits_until_its_notches_close(data: Path) -> None:
    """21 states to 28 N; beyond 20 mm its notches rub in SOFA."""
    simulator = Simulator(finger_with_gravity(data), contact="none")
    curve = read_curve(data / "selfcontact_fpolar.csv")
    free = curve[curve["active_rows"] == 0]
    assert len(free) == 21
    for row in free:
        assert simulator.settle(position=[MM * row["imposed"]], tolerance=1e-9).converged
        assert np.abs(simulator.effector[0] / MM - vector(row, "tip")).max() < DIGITS
        assert abs(simulator.effort[0] / MM - row["tension"]) < FORCE_DIGITS
