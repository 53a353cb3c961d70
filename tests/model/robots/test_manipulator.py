"""The manipulator: rows, power, contact that stiffens, files that cannot be used."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.linalg import eigh
from support.robots.examples import shipped_robot

from benchmarks.robots.arm import ArmShape, make_network
from benchmarks.robots.make_manipulator import make_file
from tauten.model import Robot, Simulator, State, load_robot
from tauten.model.beams import BeamBody
from tauten.model.body import SparseAssembled
from tauten.model.numerics import Array
from tauten.model.schema import RobotFileError

INNER = [0, 3, 6]  # one tendon of each section, 40° apart


@pytest.fixture(scope="module")
def arm() -> Robot[BeamBody]:
    robot = shipped_robot("manipulator_1290")
    assert isinstance(robot.body, BeamBody)
    return robot


def efforts(value: float) -> Array:
    effort = np.zeros(9)
    effort[INNER] = value
    return effort


@pytest.fixture(scope="module")
def bent(arm: Robot[BeamBody]) -> Simulator:
    """Pulled far beyond the first touch."""
    simulator = Simulator(arm, contact="full")
    for value in (15.0, 30.0, 45.0, 60.0):
        assert simulator.settle(effort=efforts(value)).converged
    return simulator


def moved(arm: Robot[BeamBody], state: State, dq: Array) -> State:
    """The state with its nodes moved and turned by dq (n,)."""
    return arm.advance(state, dq, 1.0)


@pytest.mark.long
def test_the_semidefinite_tangent_of_a_time_step_is_not_stiffer_than_the_arm(
    arm: Robot[BeamBody],
) -> None:
    """All tendons pull: what their tension adds to the stiffness, compression takes from that of the spine.

    A tangent with the first of them alone has a lowest frequency six times that of the arm.
    """
    simulator = Simulator(arm, contact="none")
    assert simulator.settle(effort=np.full(9, 40.0)).converged
    at = arm.body.assemble(simulator.state, simulator.effort)
    assert isinstance(at, SparseAssembled)
    tangents = at.K, arm.body.semidefinite(at, arm.integration)
    M = arm.body.matrix(at.mass).toarray()
    exact, semidefinite = (
        float(eigh(arm.body.matrix(K).toarray(), M, eigvals_only=True, subset_by_index=[0, 0])[0])
        for K in tangents
    )
    assert exact > 0.0
    assert exact / 4.0 < semidefinite < 4.0 * exact  # (rad/s)²


@pytest.mark.long
def test_sizes() -> None:
    fine = shipped_robot("manipulator")
    assert isinstance(fine.body, BeamBody)
    assert (fine.n_a, fine.layout.n_e, fine.n_c) == (9, 3, 4500)
    assert shipped_robot("manipulator_1290").n_c == 1290
    assert len(fine.pairs) == 15
    assert fine.pairs[14].end == 4500
    assert np.ptp(fine.body.beams.nodes[:, 2]) == pytest.approx(0.8)
    assert fine.effector(fine.rest()) == pytest.approx(np.array([[0.0, 0.0, -0.82]]))
    assert 0.3 < fine.body.beams.mass.sum() < 1.5  # kg of printed plastic


def test_shipped_files_are_what_the_generator_makes() -> None:
    folder = Path(__file__).parents[3] / "model" / "robots"
    shape = ArmShape()
    assert json.loads((folder / "manipulator.json").read_text()) == json.loads(
        json.dumps(make_network(shape))
    )
    for name, candidates in (("manipulator", 4500), ("manipulator_1290", 1290)):
        assert (folder / f"{name}.toml").read_text() == make_file(shape, name, candidates)


def test_rows_are_derivatives(arm: Robot[BeamBody], bent: Simulator) -> None:
    state = bent.state
    rows, eps = arm.rows(state), 1e-7
    assert len(rows.contacts) > 200
    for seed in range(3):
        d = np.random.default_rng(seed).standard_normal(arm.n)
        ahead, behind = (arm.rows(moved(arm, state, sign * eps * d)) for sign in (1.0, -1.0))
        for name in ("effectors", "actuators"):
            found = getattr(rows, name).H @ d
            difference = getattr(ahead, name).delta - getattr(behind, name).delta
            np.testing.assert_allclose(found, difference / (2 * eps), atol=1e-5 * abs(found).max())
        up, down = (r.contacts.found.gaps()[rows.contacts.slots] for r in (ahead, behind))
        gaps = (up - down) / (2 * eps)
        found = rows.contacts.rows.H @ d
        # beyond a triangle's edge the gap of a flat face goes on; at the rim candidates come and go
        assert np.isclose(found, gaps, atol=1e-4 * np.abs(found).max()).mean() > 0.98


def test_settled_arm_is_in_balance(arm: Robot[BeamBody], bent: Simulator) -> None:
    """Elastic, gravity, tendon and contact forces add up to nothing on every node."""
    rows = arm.rows(bent.state)
    force, _ = arm.forces(bent.state)
    pushing = bent.lam_c[rows.contacts.slots]
    tendons = rows.actuators.H.T @ bent.effort
    residual = force + tendons + rows.contacts.rows.H.T @ pushing
    assert pushing.sum() > 100.0
    assert np.abs(residual).max() < 1e-4 * np.abs(tendons).max()
    assert bent.gaps.min() > -1e-6


def test_base_carries_weight_and_nothing_else(arm: Robot[BeamBody]) -> None:
    """Tendons are anchored in the base: what holds the arm up is its weight."""
    hanging = Simulator(arm, contact="none")
    assert hanging.settle(effort=np.zeros(9)).converged
    weightless = arm.loaded(np.zeros(3), np.zeros(3))
    inner, _ = weightless.forces(hanging.state)
    carried = inner.reshape(-1, 6)[:, 2].sum()
    free = arm.body.dof >= 0
    assert carried == pytest.approx(9.81 * arm.body.beams.mass[free].sum(), rel=1e-6)


def test_tangent_of_tendons_is_their_derivative(arm: Robot[BeamBody], bent: Simulator) -> None:
    """−∂(H_aᵀ λ_a)/∂q along random directions, the symmetric part: dᵀ K d."""
    state, eps = bent.state, 1e-6
    effort = np.linspace(5.0, 40.0, 9)
    plain, curved = (arm.forces(state, held, exact=True)[1] for held in (None, effort))
    K = sp.csc_array((curved - plain, arm.body.pattern.indices, arm.body.pattern.indptr))
    for seed in range(3):
        d = np.random.default_rng(seed).standard_normal(arm.n)
        positions = [
            arm.rows(moved(arm, state, sign * eps * d), contacts=False).actuators.H.T @ effort
            for sign in (1.0, -1.0)
        ]
        difference = -d @ (positions[0] - positions[1]) / (2 * eps)
        assert d @ (K @ d) == pytest.approx(difference, rel=1e-5)


def test_ribs_collide_well_before_the_limits_and_stiffen_the_arm(
    arm: Robot[BeamBody], bent: Simulator
) -> None:
    first = Simulator(arm, contact="full")
    assert first.settle(effort=efforts(20.0)).converged
    assert first.lam_c.sum() == 0.0
    for value in (25.0, 30.0, 35.0):
        assert first.settle(effort=efforts(value)).converged
    assert first.lam_c.sum() > 1.0, "touches at less than half of the largest tension"
    assert (first.position < 0.5 * arm.limits.position_max).all()
    through = Simulator(arm, contact="none")
    for value in np.arange(5.0, 61.0, 5.0):
        assert through.settle(effort=efforts(value), max_iterations=400).converged
    apart = float(np.linalg.norm(through.effector - bent.effector))
    assert apart > 0.2, "bends much further without ribs"
    assert (bent.position[INNER] < through.position[INNER]).all()


def test_pull_and_tension_hold_the_same_equilibrium(arm: Robot[BeamBody]) -> None:
    by_tension, by_pull = Simulator(arm), Simulator(arm)
    assert by_tension.settle(effort=efforts(25.0), tolerance=1e-8).converged
    assert by_pull.settle(position=by_tension.position, tolerance=1e-8).converged
    np.testing.assert_allclose(by_pull.effector, by_tension.effector, atol=1e-6)
    np.testing.assert_allclose(by_pull.effort, by_tension.effort, atol=1e-3)


@pytest.mark.long
def test_released_arm_swings_and_comes_to_rest(arm: Robot[BeamBody]) -> None:
    """Implicit steps dissipate: bent and let go, the arm ends where it hangs."""
    simulator = Simulator(arm, contact="full")
    assert simulator.settle(effort=efforts(15.0)).converged
    height = simulator.effector[0, 2]
    for _ in range(400):
        assert simulator.step(effort=np.zeros(9)).converged
    assert height > -0.79
    np.testing.assert_allclose(simulator.effector[0], [0.0, 0.0, -0.82], atol=2e-3)


def test_robot_survives_pickling(arm: Robot[BeamBody], bent: Simulator) -> None:
    other = pickle.loads(pickle.dumps(arm))
    assert other.digest == arm.digest
    system, again = arm.linearise(bent.state), other.linearise(bent.state)
    np.testing.assert_allclose(again.v_free, system.v_free, rtol=1e-9, atol=1e-12)


@pytest.mark.long
def test_different_robots_have_different_digests(arm: Robot[BeamBody], tmp_path: Path) -> None:
    assert load_robot("manipulator_1290").digest == arm.digest
    assert shipped_robot("manipulator").digest != arm.digest
    assert load_robot("manipulator_1290", young_scale=1.01).digest != arm.digest


@pytest.mark.long
def test_halved_beams_are_the_same_body(arm: Robot[BeamBody]) -> None:
    """Mass and equilibrium under gravity; the spring of the whole is that of its parts in series."""
    halved = load_robot("manipulator_1290", refinements=1)
    assert isinstance(halved.body, BeamBody)
    assert halved.n_nodes == arm.n_nodes + len(arm.body.beams.ends)
    assert halved.body.beams.mass.sum() == pytest.approx(arm.body.beams.mass.sum(), rel=1e-12)
    tips = []
    for robot in (arm, halved):
        simulator = Simulator(robot, contact="none")
        assert simulator.settle(effort=np.zeros(robot.n_a)).converged
        tips.append(simulator.effector[0])
    np.testing.assert_allclose(tips[0], tips[1], atol=1e-5)


# ---- files that cannot be used


def test_a_file_with_the_table_beams_says_what_to_write(tmp_path: Path) -> None:
    old = make_file(SMALL, "small", 90).replace(
        '[[bodies]]\nname = "arm"\nbeam = { file = "manipulator.json" }',
        '[beams]\nfile = "manipulator.json"',
    )
    assert "[beams]" in old
    with pytest.raises(RobotFileError, match=r"small\.toml: beams: .*\[\[bodies\]\].*discs.*group"):
        load_robot(written(tmp_path, lambda network: None, old))


SMALL = ArmShape(length=0.16, sections=1, joints=3)


def written(folder: Path, change: Callable[[dict], None], text: str = "") -> Path:  # type: ignore[type-arg]
    network = json.loads(json.dumps(make_network(SMALL)))
    change(network)
    (folder / "manipulator.json").write_text(json.dumps(network))
    path = folder / "small.toml"
    path.write_text(text or make_file(SMALL, "small", 90))
    return path


def test_small_arm_loads(tmp_path: Path) -> None:
    robot = load_robot(written(tmp_path, lambda network: None))
    assert (robot.n_a, robot.n_c) == (3, 90)


def shorten(network: dict) -> None:  # type: ignore[type-arg]
    a, b = network["beams"][4]["ends"]
    network["nodes"][b] = network["nodes"][a]


def cut(network: dict) -> None:  # type: ignore[type-arg]
    del network["beams"][2]


def lose(network: dict) -> None:  # type: ignore[type-arg]
    network["beams"][3]["ends"] = [0, 999]


def thread(network: dict) -> None:  # type: ignore[type-arg]
    network["beams"][0]["profile"] = "thread"


def crooked(network: dict) -> None:  # type: ignore[type-arg]
    network["surfaces"][0]["nodes"].pop()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            shorten,
            r"small\.toml: bodies\.0\.beam: beams\.4 from node \d+ to node \d+ has a length of 0 m",
        ),
        (cut, r"small\.toml: bodies\.0\.beam: node \d+ is not connected to node 0: .* 2 parts"),
        (lose, r"manipulator\.json: beams\.3: ends \(0, 999\), there are nodes 0 to"),
        (
            thread,
            r"manipulator\.json: beams\.0: profile 'thread' is not one of .* has rib, spine",
        ),
        (crooked, r"surface 'feet1' has 54 points and 53 nodes"),
        (lambda s: s.pop("nodes"), r"manipulator\.json: nodes: Field required"),
    ],
)
def test_networks_that_cannot_be_used(
    tmp_path: Path,
    change: Callable[[dict], None],
    message: str,  # type: ignore[type-arg]
) -> None:
    with pytest.raises(RobotFileError, match=message):
        load_robot(written(tmp_path, change))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "[0.028000, 0.000000, -0.053333]",
            "[0.058000, 0.000000, -0.053333]",
            r"cables\.0\.points: point 1 at \[0\.058, .*\] m lies 0\.008 m outside of the nearest disc "
            r"'vertebra1', allowed is 0 m",
        ),
        ("inner = 6.0e-3", "inner = 9.5e-3", r"inner 0\.0095 must be less than outer 0\.009"),
        (
            "height = 6.0e-3",
            "height = 6e-15",
            r"profiles\.1\.bar\.height: allowed is at least 1e-06 and at most 10 m, found 6e-15",
        ),
        (
            "inner = 6.0e-3",
            "inner = 8.9999e-3",
            r"inner 0\.0089999 and outer 0\.009 differ by less",
        ),
        ('against = "disc2"', 'against = "disk2"', r"surface 'disk2' is not defined"),
        ("lower = [-1e-6, -1e-6, -1e-6]", "lower = [1e-7, 0.0, 0.0]", r"fixed\.0: no node in"),
        ('file = "manipulator.json"', 'file = "arm.json"', r"arm\.json: cannot be read"),
        ("young_modulus = 1.65e9", "young_modulus = -1.0", r"material\.young_modulus"),
    ],
)
def test_files_that_cannot_be_used(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = make_file(SMALL, "small", 90)
    assert old in text
    with pytest.raises(RobotFileError, match=message):
        load_robot(written(tmp_path, lambda network: None, text.replace(old, new, 1)))
