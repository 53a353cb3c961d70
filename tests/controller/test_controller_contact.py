"""The controller on the finger, whose notches close: the certificate predicts the gaps of the next step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.bodies import beam_robot, box_mesh

from tauten.controller import Controller
from tauten.controller.qpcc import Status
from tauten.model import Enrichment, Robot, Simulator
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array

CHECKED = Enrichment(tolerance=5e-5, rounds=5, per_pair=2)


@pytest.fixture(scope="module")
def bent(finger: Robot) -> Array:
    """Where the tip is when the cable is pulled by 24 mm and the notches are closed."""
    simulator = Simulator(finger, contact="full")
    assert simulator.settle(position=[0.024]).converged
    tip: Array = simulator.effector[0]
    return tip


def bend(controller: Controller, target: Array, steps: int, *, exact: bool = False) -> list[float]:
    """Follow a target from rest; the deepest gap predicted at each step [m].

    Args:
        controller: at rest.
        target: of the tip at the end (3,) [m].
        steps: how many; it is there after seven tenths of them.
        exact: whether every decision must be stationary, not only usable.
    """
    tip, gaps = controller.effector[0], []
    for share in np.minimum(np.arange(1, steps + 1) / (0.7 * steps), 1.0):
        actuation = controller.step(tip + share * (target - tip))
        assert actuation.status is Status.OK if exact else actuation.status.usable
        gaps.append(actuation.certificate.deepest_gap)
    return gaps


@pytest.mark.long
def test_a_controller_without_contact_predicts_no_gap(finger: Robot, bent: Array) -> None:
    blind = Controller(finger, "none")
    gaps = bend(blind, bent, 60)
    assert np.all(np.isinf(gaps))
    assert finger.rows(blind.state).contacts.found.gaps().min() < -5e-4


@pytest.mark.long
def test_enrichment_adds_columns_until_the_gaps_are_kept(finger: Robot, bent: Array) -> None:
    controller = Controller(finger, "none", CHECKED)
    tip = controller.effector[0]
    columns = []
    for share in np.minimum(np.arange(1, 51) / 35, 1.0):
        actuation = controller.step(tip + share * (bent - tip))
        certificate = actuation.certificate
        columns.append(certificate.extra_columns)
        assert actuation.status.usable
        assert certificate.deepest_gap >= -CHECKED.tolerance
        # rows are linearised: what is predicted happens, but for what their normals turn in a step
        actual = finger.rows(controller.state).contacts.found.gaps().min()
        assert actual >= min(certificate.deepest_gap, 0.0) - 1e-4
    assert columns[0] == 0
    assert max(columns) >= 5


def test_without_rounds_the_certificate_still_reports_the_deepest_gap(
    finger: Robot, bent: Array
) -> None:
    unchecked = Enrichment(tolerance=np.inf, rounds=1, per_pair=1)
    controller = Controller(finger, "none", unchecked)
    gaps = bend(controller, bent, 45)
    assert min(gaps) < -5e-4
    assert gaps[-1] == pytest.approx(
        finger.rows(controller.state).contacts.found.gaps().min(), abs=2e-4
    )


@pytest.mark.long
def test_reaching_a_target_reproduces_the_equilibrium_with_contact(
    finger: Robot, bent: Array
) -> None:
    """Every decision on the way is stationary.

    daqp took pieces whose contacts are redundant for empty: the cable stayed where it was in that tick.
    """
    controller = Controller(finger, "full")
    bend(controller, bent, 89, exact=True)
    actuation = controller.step(bent)
    assert actuation.status is Status.OK
    assert np.linalg.norm(controller.effector[0] - bent) < 2e-4
    np.testing.assert_allclose(controller.position, [0.024], atol=3e-4)
    assert np.any(controller.forces.extra_beta > 0.0)


@pytest.mark.long
def test_holding_with_contact_keeps_gaps(finger: Robot, bent: Array) -> None:
    controller = Controller(finger, "none", CHECKED)
    bend(controller, bent, 40)
    position = controller.position.copy()
    for _ in range(10):
        actuation = controller.hold()
        controller.advance()
        np.testing.assert_array_equal(actuation.position, position)
        assert actuation.certificate.deepest_gap >= -CHECKED.tolerance
    assert actuation.status is Status.OK


def test_limits_are_kept_in_contact(finger: Robot) -> None:
    rng = np.random.default_rng(2)
    controller, limits = Controller(finger, "none", CHECKED), finger.limits
    tip, position = controller.effector[0], controller.position
    for step in range(60):
        if step % 15 == 0:
            target = tip + rng.normal(size=3) * [0.1, 0.01, 0.1]
        actuation = controller.step(target)
        assert np.all(actuation.effort >= limits.effort_min)
        assert np.all(actuation.effort <= limits.effort_max)
        assert np.all(actuation.position <= limits.position_max + 1e-9)
        assert np.all(np.abs(actuation.position - position) <= limits.rate * finger.h * (1 + 1e-6))
        position = actuation.position


@pytest.mark.parametrize("scheme", ["quasi-static", "implicit-euler"])
def test_a_finger_that_lies_on_a_table_without_weight_is_decided_for(scheme: str) -> None:
    """All gaps are rounding, which the solver took for gaps that no force closes: its answer was to hold."""
    size, turn = (0.1, 0.01, 0.01), Rotation.from_rotvec([0.3, 0.2, -0.5]).as_matrix()
    straight, corner = box_mesh(size, (10, 1, 1)), np.array([0.013, 0.02, 0.007])

    def at(x: float, z: float) -> list[float]:
        return [float(one) for one in corner + turn @ [x, 0.005, z]]

    table = {"point": at(0.05, 0.0), "normal": turn[:, 2].tolist()}
    limits = {"max_tension": 20.0, "max_pull": 0.02, "max_rate": 0.1}
    robot = beam_robot(
        TetMesh(corner + straight.nodes @ turn.T, straight.tets), size, integration={"scheme": scheme},
        fixed=[{"kind": "half_space", "point": at(1e-4, 0.0), "normal": (-turn[:, 0]).tolist()}],
        cables=[
            {"name": name, "points": [at(0.01, z), at(0.1, z)], **limits}
            for name, z in (("lower", 0.001), ("upper", 0.009))
        ],
        effectors=[{"name": "tip", "point": at(0.1, 0.005)}],
        regions=[{"name": "below", "kind": "normal", "direction": (-turn[:, 2]).tolist()}],
        obstacles=[{"name": "table", "shape": "plane", "parameters": table}],
        contacts=[{"candidates": "below", "against": "table", "points": 3}],
    )  # fmt: skip
    controller = Controller(robot)
    assert controller.step(controller.tip + turn @ [0.0, 0.0, -5e-3]).status is Status.OK
    decision = controller.last_decision
    assert decision is not None and decision.problem is not None
    assert decision.predicted.deepest_gap > -robot.tolerance
