"""Contact on the finger with its notches closed: what is left out, what balances, what repeats."""

import dataclasses

import numpy as np
import pytest

from benchmarks.contact_basis import solve_pgs
from tauten.model import Robot, Simulator
from tauten.model.contact import ContactPair, ContactSet, contact_rows
from tauten.model.numerics import Array, Ints, solve_lcp
from tauten.model.points import NodeMotion, Placed, points_at
from tauten.model.tetra import NodalBody

PULL = 0.022  # closes the mouths of all notches


def placed_nodes(x: Array, dof: Ints, n: int) -> Placed:
    """The nodes themselves at one state."""
    return NodeMotion(x, dof, n).placed(points_at(np.arange(len(x))))


@pytest.fixture(scope="module")
def closed(finger: Robot[NodalBody]) -> Simulator:
    sim = Simulator(finger, contact="full")
    assert sim.settle(position=[PULL]).converged
    return sim


def test_candidates_rest_on_the_faces(closed: Simulator) -> None:
    gaps, forces = closed.gaps, closed.lam_c
    assert gaps.min() > -1e-7
    assert forces.sum() > 0.1
    np.testing.assert_allclose(gaps[forces > 0.0], 0.0, atol=1e-7)


def test_no_candidate_is_left_out(closed: Simulator) -> None:
    """Rule 3 leaves out candidates whose triangle shares a vertex with the one below: the flanks share none.

    Given vertices of their own, the same candidates are in range.
    """
    finger = closed.robot
    n = len(finger.body.mesh.nodes)
    pairs = [dataclasses.replace(p, nodes=p.nodes + n) for p in finger.contacts.pairs]
    x = finger.body.nodes(closed.state)
    everywhere = ContactSet(pairs, 2 * n, finger.contacts.alarm_distance).detect(np.vstack([x, x]))
    found = finger.contacts.detect(x)
    assert len(found.slots) > 100
    np.testing.assert_array_equal(np.sort(everywhere.slots), np.sort(found.slots))


def test_contact_forces_balance(closed: Simulator) -> None:
    """Both faces belong to the body: contact exerts neither a net force nor a net moment on it."""
    finger = closed.robot
    x = finger.body.nodes(closed.state)
    everything_free = 3 * np.arange(len(x))
    rows = contact_rows(finger.contacts.detect(x), placed_nodes(x, everything_free, x.size))
    force = (rows.rows.H.T @ closed.lam_c[rows.slots]).reshape(-1, 3)  # (n_nodes, 3)
    assert np.abs(force).max() > 1e-2
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.cross(x, force).sum(axis=0), 0.0, atol=1e-9)


def test_both_solvers_on_the_finger(closed: Simulator) -> None:
    """All candidates in range at once, more of them than the faces have nodes."""
    finger = closed.robot
    rows = finger.rows(closed.state).contacts
    system = finger.linearise(closed.state)
    H = rows.rows.H.toarray()
    W = system.h**2 * H @ system.solve(H.T)
    W = 0.5 * (W + W.T)
    # squeezed by 10 µm more everywhere
    delta_free = rows.rows.delta - 1e-5
    exact = solve_lcp(W, delta_free)
    assert exact.converged
    assert exact.residual < 1e-12
    reference = solve_pgs(W, delta_free, tolerance=1e-8, max_sweeps=20_000)
    assert reference.converged
    np.testing.assert_allclose(exact.delta, reference.delta, atol=1e-6)


def test_mirrored_finger_has_mirrored_gaps(closed: Simulator) -> None:
    """Detection is invariant under reflection: the mirror image has the same gaps and mirrored normals."""
    mirror = np.array([1.0, -1.0, 1.0])
    finger = closed.robot
    x = finger.body.nodes(closed.state)
    detection = finger.contacts.detect(x)
    pairs = [
        ContactPair(p.name, p.nodes, p.weights, p.triangles[:, ::-1]) for p in finger.contacts.pairs
    ]
    mirrored = ContactSet(pairs, len(x), finger.contacts.alarm_distance).detect(x * mirror)
    assert len(detection) > 10
    np.testing.assert_array_equal(mirrored.slots, detection.slots)
    np.testing.assert_allclose(mirrored.gap, detection.gap, atol=1e-15)
    np.testing.assert_allclose(mirrored.normal, detection.normal * mirror, atol=1e-9)
