"""Beam elements and points attached to them: derivatives, invariance, profiles."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.beam_frames import Frame, chain

from tauten.model.beams import (
    BeamArrays,
    BeamError,
    Material,
    bar,
    element,
    make_beams,
    natural_stiffness,
    stretch_functions,
    tube,
    turn_functions,
)
from tauten.model.numerics import Array, rotation_vector, turned
from tauten.model.points import (
    Entries,
    PoseMotion,
    attach_between,
    attach_to_nodes,
    join_attached_points,
)

STEEL = Material(2e11, 0.3, 7800.0)
D = np.array([50.0, 20.0, 15.0, 2.0, 3.0, 5.0])  # of the same order, so that no term hides
LENGTH = 1.3


def quaternion(r: Rotation) -> Array:
    return np.roll(r.as_quat(), 1)


def strained(seed: int, angle: float) -> tuple[Array, Array, Array]:
    """Nodes x (2, 3) and Q (2, 4), ends turned by an angle against each other, and axes (4,)."""
    rng = np.random.default_rng(seed)
    axis = rng.standard_normal(3)
    first = Rotation.random(random_state=seed)
    second = first * Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    Q = np.stack([quaternion(first), quaternion(second)])
    return rng.standard_normal((2, 3)), Q, quaternion(Rotation.random(random_state=seed + 9))


def evaluate(
    x: Array, Q: Array, axes: Array, dq: Array, exact: bool = True
) -> tuple[float, Array, Array]:
    moved, part = x + dq.reshape(2, 2, 3)[:, 0], dq.reshape(2, 2, 3)[:, 1].copy()
    force, K = np.empty(12), np.empty((12, 12))
    beam = BeamArrays(np.array([[0, 1]]), axes[None], D[None], np.array([LENGTH]))
    energy = element(moved, turned(Q, part), beam, 0, exact, force, K)
    return energy, force, K


@pytest.mark.parametrize("angle", [0.0, 1e-4, 0.09, 0.11, 1.0, 2.5])
def test_forces_and_tangent_are_derivatives(angle: float) -> None:
    x, Q, axes = strained(3, angle)
    _, force, K = evaluate(x, Q, axes, np.zeros(12))
    eps = 1e-5
    gradient, hessian = np.zeros(12), np.zeros((12, 12))
    for j, d in enumerate(eps * np.eye(12)):
        (up, f_up, _), (down, f_down, _) = evaluate(x, Q, axes, d), evaluate(x, Q, axes, -d)
        gradient[j] = (up - down) / (2.0 * eps)
        hessian[:, j] = -(f_up - f_down) / (2.0 * eps)
    np.testing.assert_allclose(force, -gradient, atol=1e-8)
    np.testing.assert_allclose(K, 0.5 * (hessian + hessian.T), atol=1e-7)


def test_series_meet_the_closed_forms() -> None:
    for functions, limit in ((stretch_functions, 0.3), (turn_functions, 0.1)):
        np.testing.assert_allclose(functions(limit - 1e-9), functions(limit), rtol=2e-8)


def test_plain_tangent_is_positive_semidefinite() -> None:
    for seed in range(5):
        x, Q, axes = strained(seed, 1.5)
        values = np.linalg.eigvalsh(evaluate(x, Q, axes, np.zeros(12), exact=False)[2])
        assert values[0] > -1e-10 * values[-1]
        assert (values > 1e-6 * values[-1]).sum() == 6, "six natural modes, six rigid motions"


def test_rigid_motion_changes_nothing() -> None:
    x, Q, axes = strained(1, 0.8)
    turn, shift = Rotation.from_rotvec([0.5, 2.0, -1.0]), np.array([0.3, -0.2, 0.1])
    energy, force, K = evaluate(x, Q, axes, np.zeros(12))
    moved = np.stack([quaternion(turn * Rotation.from_quat(np.roll(q, -1))) for q in Q])
    turned_energy, turned_force, turned_K = evaluate(
        turn.apply(x) + shift, moved, axes, np.zeros(12)
    )
    blocks = np.kron(np.eye(4), turn.as_matrix())
    assert turned_energy == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(turned_force, blocks @ force, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose(turned_K, blocks @ K @ blocks.T, atol=1e-12 * np.abs(K).max())


def test_internal_forces_balance() -> None:
    x, Q, axes = strained(2, 1.2)
    _, force, _ = evaluate(x, Q, axes, np.zeros(12))
    f = force.reshape(2, 2, 3)
    np.testing.assert_allclose(f[:, 0].sum(axis=0), 0.0, atol=1e-12)
    moment = f[:, 1].sum(axis=0) + np.cross(x, f[:, 0]).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-11)


def test_rotations_turn_about_fixed_axes() -> None:
    rng = np.random.default_rng(0)
    Q = np.stack([quaternion(Rotation.random(random_state=i)) for i in range(4)])
    step = rng.standard_normal((4, 3))
    found = turned(Q, step)
    for q, r, result in zip(Q, step, found, strict=True):
        wanted = Rotation.from_rotvec(r) * Rotation.from_quat(np.roll(q, -1))
        apart = Rotation.from_quat(np.roll(result, -1)) * wanted.inv()
        assert apart.magnitude() < 1e-12
        back = rotation_vector(tuple(result))
        expected = Rotation.from_quat(np.roll(result, -1)).as_rotvec()
        np.testing.assert_allclose(back, expected, atol=1e-12)


def test_attached_points_move_as_their_velocity_map() -> None:
    """J is the derivative, and forces through its transpose have the same power."""
    body = chain(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0.5, 0]]), [0, 0, 1], tube(0.1), STEEL)
    frame = Frame(body)
    rng = np.random.default_rng(5)
    rest = rng.standard_normal((6, 3))
    along = attach_between(body.nodes, body.ends[[0, 1, 1]], rng.random(3), rest[3:])
    points = join_attached_points(
        [attach_to_nodes(body.nodes, np.array([0, 1, 2]), rest[:3]), along]
    )
    np.testing.assert_allclose(points.place(frame.x, frame.Q)[0], rest)
    frame.move(rng.standard_normal(12))
    dof = frame.pattern.dof[::2]
    placed = PoseMotion(frame.x, frame.Q, dof, 12).placed(points)
    J = placed.motion()
    x, Q, v, eps = frame.x, frame.Q, rng.standard_normal(12), 1e-6
    moved = []
    for sign in (1.0, -1.0):
        frame.x, frame.Q = x, Q
        frame.move(sign * eps * v)
        moved.append(points.place(frame.x, frame.Q)[0])
    velocity = (moved[0] - moved[1]) / (2.0 * eps)
    np.testing.assert_allclose(J @ v, velocity.ravel(), atol=1e-8)
    f = rng.standard_normal((6, 3))
    one_row = placed.rows(Entries(np.array([0, 6]), np.arange(6), f))
    assert one_row.nnz == 12, "every node once"
    assert (one_row @ v)[0] == pytest.approx((f * velocity).sum(), abs=1e-7)


def test_profiles_against_known_values() -> None:
    rod = tube(0.02)
    assert rod.bending[0] == pytest.approx(np.pi * 0.01**4 / 4)
    assert rod.torsion == pytest.approx(np.pi * 0.01**4 / 2)
    square = bar(0.01, 0.01)
    assert square.torsion == pytest.approx(0.1406 * 0.01**4, rel=4e-3)  # Timoshenko and Goodier
    flat = bar(0.1, 0.01)
    assert flat.torsion == pytest.approx(0.3123 * 0.1 * 0.01**3, rel=4e-3)
    assert flat.bending == pytest.approx((0.1 * 0.01**3 / 12, 0.01 * 0.1**3 / 12))
    outline = flat.outline
    assert np.ptp(outline, axis=0) == pytest.approx([0.1, 0.01])


def test_cantilever_of_one_element_is_timoshenkos() -> None:
    """Tip force and moment on one element: the exact deflection, shear included."""
    L, profile = 0.3, bar(0.02, 0.05)
    frame = Frame(chain(np.array([[0.0, 0, 0], [L, 0, 0]]), [0, 0, 1], profile, STEEL))
    E, G = STEEL.young_modulus, STEEL.shear_modulus
    I, A = profile.bending[0], profile.shear_area[1]  # noqa: E741  symbol of the field
    F = 1e-3
    frame.solve(np.array([0.0, 0.0, F, 0.0, 0.0, 0.0]))
    assert frame.x[1, 2] == pytest.approx(F * (L**3 / (3 * E * I) + L / (G * A)), rel=1e-9)
    assert natural_stiffness(profile, STEEL, L)[4] == pytest.approx(E * I / L)


def test_bodies_that_are_none() -> None:
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0]])
    up, rod = np.array([0.0, 0, 1]), tube(0.1)
    with pytest.raises(BeamError, match=r"beams\.1 from node 1 to node 2 has a length of 0 m"):
        chain(nodes, up, rod, STEEL)
    with pytest.raises(BeamError, match=r"node 2 is not connected to node 0: .* 3 parts"):
        make_beams(nodes, np.array([[0, 1]]), up[None], [rod], STEEL)
    with pytest.raises(BeamError, match=r"beams\.0: up \[1\.0, 0\.0, 0\.0\] lies along the beam"):
        chain(nodes[:2], np.array([1.0, 0, 0]), rod, STEEL)
    with pytest.raises(BeamError, match="ends among the nodes 0 to 1"):
        make_beams(nodes[:2], np.array([[0, 2]]), up[None], [rod], STEEL)
