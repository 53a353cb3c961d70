"""Constraints by elimination: derivatives by finite differences, and files that make no sense."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from support.robots.bodies import box_mesh
from support.robots.small_bodies import (
    END,
    FIRST,
    GLUE,
    HINGE,
    LAST,
    MESH,
    MIDDLE,
    ROOT,
    RUBBER,
    SECOND,
    SLIDE,
    TOUCH,
    TURN,
    WINCH,
    constrained,
    moved,
    rigid_box,
)

from tauten.controller import Controller, Status
from tauten.model import Robot, Simulator, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.constraints.coordinates import Congruence
from tauten.model.materials import EXACT, NO_TANGENT
from tauten.model.numerics import Array, FactorisationError
from tauten.model.schema import RobotFileError


def pair(**changes: object) -> Robot[ConstrainedBody]:
    """Two boxes one after the other."""
    given = {"bodies": [FIRST, SECOND], "mesh": None, "fixed": [], "material": RUBBER, **changes}
    return constrained([MESH, MESH], **given)


def with_everything() -> Robot[ConstrainedBody]:
    """Glue, whose masters are partly in a rigid region; a servo, a slider and a hinge on the frame."""
    return pair(
        gravity=[0.0, 0.0, -9.81],
        attachments=[
            GLUE,
            HINGE,
        ],
        rigid=[{"name": "plate", "region": {**END, "body": "first"}}],
        drives=[
            {**TURN, "region": MIDDLE},
            {**SLIDE, "region": LAST},
        ],
        couplings=[WINCH],
        **TOUCH,
    )  # fmt: skip


@pytest.fixture(scope="module")
def robot() -> Robot[ConstrainedBody]:
    return with_everything()


@pytest.fixture(scope="module")
def state(robot: Robot[ConstrainedBody]) -> State:
    """Far from rest: frames turned by a fifth of a turn and more, nodes scattered."""
    rng = np.random.default_rng(1)
    frames = np.arange(robot.n) >= robot.n - robot.body.frames.n_velocities
    bent = moved(robot, robot.rest(), 2e-3 * rng.standard_normal(robot.n) * ~frames)
    return moved(robot, bent, np.where(frames, 0.02, 0.0) * rng.standard_normal(robot.n))


def derivative(robot: Robot[ConstrainedBody], state: State, value: object, d: Array) -> Array:
    step = 1e-6
    ahead, behind = (value(moved(robot, state, sign * step * d)) for sign in (1.0, -1.0))  # type: ignore[operator]
    return np.asarray((ahead - behind) / (2.0 * step))


@pytest.fixture(scope="module")
def direction(robot: Robot[ConstrainedBody]) -> Array:
    return np.random.default_rng(2).standard_normal(robot.n)


def test_velocities_of_nodes(robot: Robot[ConstrainedBody], state: State, direction: Array) -> None:
    found = derivative(robot, state, lambda at: robot.body.placed(at)[0], direction)
    T = robot.body.coordinates.matrix(robot.body.placed(state)[1].T)
    assert np.abs(T @ direction - found).max() < 1e-8 * np.abs(found).max()


@pytest.mark.parametrize("kind", ["effectors", "actuators", "contacts"])
def test_rows(robot: Robot[ConstrainedBody], state: State, direction: Array, kind: str) -> None:
    rows = getattr(robot.rows(state), kind)
    found = derivative(
        robot,
        state,
        lambda at: (
            getattr(getattr(robot.rows(at), kind), "rows", getattr(robot.rows(at), kind)).delta
        ),
        direction,
    )
    H = getattr(rows, "rows", rows).H
    assert len(found) > 0
    assert np.abs(H @ direction - found).max() < 1e-6 * np.abs(found).max()


def test_forces_are_the_derivative_of_the_potential(
    robot: Robot[ConstrainedBody], state: State, direction: Array
) -> None:
    slope = derivative(robot, state, robot.potential, direction)
    force, _ = robot.forces(state)
    assert -force @ direction == pytest.approx(float(slope), rel=1e-6)


def test_elements_that_cannot_deform_are_left_out(
    robot: Robot[ConstrainedBody], state: State
) -> None:
    """Those that are fixed or in one rigid region: at any state they have neither energy nor forces."""
    held, x = robot.body.tetrahedra, robot.body.nodes(state)
    every, some = (
        [len(part.nodes) for part in one.domains] for one in (held.elements, held.deforming)
    )
    assert 0 < sum(some) < 0.9 * sum(every)
    energies, forces = [], []
    for solid in (held.elements, held.deforming):
        force = np.zeros_like(x)
        energies.append(solid.assemble(x, NO_TANGENT, force, np.zeros(0)))
        forces.append(robot.body.placed(state)[1].forces(force[held.dof >= 0].ravel()))
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-12 * np.abs(forces[1]).max())


def test_a_wholly_rigid_body_has_no_elements_to_sum() -> None:
    box = rigid_box(material=RUBBER)
    assert box.body.tetrahedra.deforming.domains == ()
    assert box.body.n_elements == len(MESH.tets)
    turned = moved(box, box.rest(), np.array([0.01, 0.0, 0.0, 0.3, -0.2, 0.1]))
    assert box.potential(turned) == pytest.approx(box.potential(box.rest()), abs=1e-12)


def test_damping_in_one_pass(robot: Robot[ConstrainedBody], state: State) -> None:
    """The stiffness that damping is proportional to, summed beside the tangent, or alone."""
    force, K, D = robot.body.forces_and_stiffness(state, np.ones(robot.n_a))
    alone = robot.body.stiffness(state)
    np.testing.assert_allclose(D, alone, atol=1e-12 * np.abs(alone).max())
    np.testing.assert_array_equal(K, robot.forces(state, np.ones(robot.n_a), exact=True)[1])
    np.testing.assert_array_equal(force, robot.forces(state)[0])


def test_cables_that_hold_a_rigid_part_against_each_other_are_named() -> None:
    """One is wound and the other one held: no motion meets both positions, and the sentence says so."""
    cables = [
        {
            "name": name, "pull_point": [x, 0.01, 0.01], "points": [[0.1, 0.01, 0.01]],
            "max_tension": 5.0, "max_pull": 0.05, "max_rate": 1.0,
        }
        for name, x in (("ahead", 0.2), ("back", -0.2))
    ]  # fmt: skip
    simulator = Simulator(constrained(cables=cables, rigid=[{"name": "plate", "region": END}]))
    with pytest.raises(FactorisationError, match=r"(ahead|back) needed an effort .* 5 is allowed"):
        for step in range(100):
            simulator.move(position=[5e-4 * step, 0.0])


def test_the_tangent_is_the_derivative_of_the_forces(
    robot: Robot[ConstrainedBody], state: State, direction: Array
) -> None:
    """Of rigid rotations the symmetric part of it: without moment of forces on them it is all."""
    effort = np.zeros(robot.n_a)
    _, values = robot.forces(state, effort, exact=True)
    K = sp.csc_array(
        (values, robot.body.pattern.indices, robot.body.pattern.indptr), shape=(robot.n,) * 2
    )
    found = -derivative(robot, state, lambda at: robot.forces(at)[0], direction)
    first = 3 * len(robot.body.coordinates.free)
    turning = np.arange(first + 3, first + 6)
    difference = K @ direction - found
    # the antisymmetric part of the derivative is half of the cross product with the moment
    moment = robot.forces(state)[0][turning]
    difference[turning] += 0.5 * np.cross(moment, direction[turning])
    assert np.abs(difference).max() < 1e-6 * np.abs(found).max()


def test_the_semidefinite_tangent_is_that_of_the_nodes_and_of_levers_that_forces_hold(
    robot: Robot[ConstrainedBody], state: State
) -> None:
    """Of what turning levers add under forces, the nearest matrix without negative eigenvalues."""
    q, through = robot.body.placed(state)
    held, T = robot.body.tetrahedra, robot.body.coordinates.matrix(through.T).toarray()
    added = []
    for exact, kind in ((True, EXACT), (False, held.elements.semidefinite)):
        loads = robot.actuator_set.loads(robot.actuator_set.efforts(None), exact=exact)
        nodes = held.pattern.matrix(held.forces(kind, held.placed(q), loads)[1]).toarray()
        whole = robot.body.matrix(robot.forces(state, exact=exact)[1]).toarray()
        added.append(whole - T.T @ nodes @ T)
    values, vectors = np.linalg.eigh(added[0])  # N m, some of them negative
    expected = (vectors * np.maximum(values, 0.0)) @ vectors.T  # beside entries of up to 7e4
    assert values[0] < -0.1 and np.abs(added[1] - expected).max() < 5e-8


def test_the_mass_is_lumped_where_elements_deform_and_consistent_where_they_do_not(
    robot: Robot[ConstrainedBody], state: State
) -> None:
    body, x = robot.body, robot.body.mesh.nodes
    T = body.coordinates.matrix(body.placed(state)[1].T).toarray()[: body.tetrahedra.m]
    still, node = State(state.q, np.zeros(robot.n)), body.tetrahedra.dof // 3
    stretch = np.linalg.norm(x[:, None] - x, axis=2)
    y = body.nodes(still)
    carried = np.abs(np.linalg.norm(y[:, None] - y, axis=2) - stretch) < 1e-12
    lumped = np.diag(body.tetrahedra.mass[::3])
    for tet, volume in zip(body.mesh.tets, body.mesh.volumes, strict=True):
        if (node[tet] >= 0).all() and carried[np.ix_(tet, tet)].all():
            own = np.ix_(node[tet], node[tet])
            lumped[own] += RUBBER["density"] * volume * ((1.0 + np.eye(4)) / 20.0 - np.eye(4) / 4.0)
    mass = T.T @ np.kron(lumped, np.eye(3)) @ T
    found = body.matrix(body.masses(state)).toarray()
    assert np.abs(found - mass).max() < 1e-12 * mass.max()


def test_centripetal_accelerations(
    robot: Robot[ConstrainedBody], state: State, direction: Array
) -> None:
    """The second derivative of the nodes along a motion with constant velocities of the coordinates."""
    step = 1e-4
    q = [robot.body.placed(moved(robot, state, s * step * direction))[0] for s in (-1.0, 0.0, 1.0)]
    second = (q[0] - 2.0 * q[1] + q[2]) / step**2
    levers = robot.body.placed(state)[1].levers
    rate = robot.body.frames.centripetal(levers, direction[3 * len(robot.body.coordinates.free) :])
    found = robot.body.coordinates.gather.T @ rate.ravel()
    assert np.abs(found - second).max() < 1e-5 * np.abs(second).max()


def test_a_fork_and_a_load_keep_the_constraints(
    robot: Robot[ConstrainedBody], state: State
) -> None:
    other = robot.fork().loaded(np.array([0.0, 9.81, 0.0]), np.zeros(3))
    assert np.array_equal(other.body.nodes(state), robot.body.nodes(state))
    T = robot.body.coordinates.matrix(robot.body.placed(state)[1].T)
    weight = T.T @ (
        robot.body.tetrahedra.mass * np.tile([0.0, 9.81, 9.81], robot.body.tetrahedra.m // 3)
    )
    assert other.forces(state)[0] - robot.forces(state)[0] == pytest.approx(weight)


def servo(**changes: object) -> dict[str, object]:
    return {"drives": [{**TURN, "region": MIDDLE, **changes}]}


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_drive_may_turn_to_one_side_only(side: float) -> None:
    """It reaches what lies on its side, and stays at rest for what lies on the other."""
    one = (
        {"min_angle": -0.4, "max_angle": 0.0}
        if side < 0.0
        else {"min_angle": 0.0, "max_angle": 0.4}
    )
    robot = constrained(**servo(**one), cables=None)
    assert robot.limits.farthest_position[0] == 0.4 * side
    simulator = Simulator(robot, contact="none")
    goals = []
    for angle in (0.2 * side, -0.2 * side):
        assert simulator.settle(position=[angle]).converged
        goals.append(simulator.effector_values)
    for goal, expected in zip(goals, (0.2 * side, 0.0), strict=True):
        controller = Controller(robot)
        for _ in range(20):
            actuation = controller.step(goal)
            assert -1e-12 <= side * actuation.position[0] <= 0.4
        assert actuation.status is Status.OK  # stationary at the limit, too
        assert actuation.position[0] == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (servo(region=ROOT), "drives.servo: 9 of its 9 nodes are fixed; take them out of fixed"),
        (
            {**servo(), "rigid": [{"name": "plate", "region": MIDDLE}]},
            "drives.servo: 18 of its 18 nodes move with rigid.plate too, a node moves with one",
        ),
        (servo(through=None), "drives.0: a rotation needs a point `through`"),
        (servo(max_torque=None), "drives.0: a rotation needs max_torque"),
        (servo(max_travel=1.0), "drives.0: max_travel is given, but the motion is a rotation"),
        (servo(min_angle=0.1), "drives.0: min_angle 0.1 and max_angle 3 must have zero"),
        (servo(name="tendon"), "actuators: name 'tendon' is used twice"),
        (servo(region="wrist"), "drives.0.region: region 'wrist' is not defined"),
        (servo(axis=[0.0, 0.0, 0.0]), "drives.0.axis: a direction needs a component"),
        (
            {"attachments": [{"kind": "glue", "region": MIDDLE}]},
            "attachments.0: to is needed by glue",
        ),
        (
            {"attachments": [{"kind": "glue", "region": MIDDLE, "to": END, "radius": 0.1}]},
            "attachments.0: radius is not used by this glue",
        ),
        (
            {"attachments": [{"kind": "glue", "region": END, "to": {"kind": "all"}}]},
            "attachments.0: 18 nodes of region belong to tetrahedra of to; make the two apart",
        ),
    ],
)  # fmt: skip
def test_bad_drives_and_attachments_are_one_sentence(
    changes: dict[str, object], sentence: str
) -> None:
    with pytest.raises(RobotFileError, match=sentence):
        constrained(**changes)


SHORT = {"body": "second", "lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.02, 0.0]}
BACK = {
    "kind": "glue",
    "region": {"body": "first", "lower": [0.1, 0.0, 0.0], "upper": [0.1, 0.02, 0.02]},
    "to": {"kind": "all", "body": "second"},
}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"attachments": []}, "fixed: needs three nodes not on a line to hold the body 'second'"),
        (
            {"attachments": [GLUE, {**GLUE, "region": SHORT}]},
            "attachments.1.region: 3 of its 3 nodes are glued already; make the regions",
        ),
        (
            {"attachments": [GLUE, BACK]},
            "attachments.0: it is glued to nodes that attachments.1 glues; overlapping glue is not possible",
        ),
        (
            {"attachments": [GLUE], "bodies": [FIRST, {**SECOND, "fixed": [ROOT]}]},
            "attachments.0.region: 9 of its 9 nodes are fixed",
        ),
        (
            {"attachments": [GLUE], "bodies": [FIRST, {**SECOND, "rigid": True}]},
            "attachments.0.region: 9 of its 9 nodes move with a rigid region or a drive; exchange",
        ),
        (
            {"attachments": [GLUE], "bodies": [FIRST, {**SECOND, "position": [0.11, 0.0, 0.0]}]},
            "lies 0.01 m outside the mesh, allowed is 1e-06 m: .* max_distance",
        ),
    ],
)  # fmt: skip
def test_bad_pairs_are_one_sentence(changes: dict[str, object], sentence: str) -> None:
    with pytest.raises(RobotFileError, match=sentence):
        pair(**{"attachments": [GLUE], **changes})


def test_glue_does_not_need_matching_nodes() -> None:
    fine = box_mesh((0.1, 0.02, 0.02), (8, 3, 3))
    given = {"bodies": [FIRST, SECOND], "mesh": None, "fixed": [], "material": RUBBER}
    robot = constrained([MESH, fine], attachments=[GLUE], **given)
    rng = np.random.default_rng(0)
    x = robot.body.nodes(moved(robot, robot.rest(), 1e-3 * rng.standard_normal(robot.n)))
    glued = np.flatnonzero(np.isclose(robot.body.mesh.nodes[:, 0], 0.1))[9:]
    assert len(glued) == 16
    # the corners of both faces are nodes of both bodies
    corners = robot.body.mesh.nodes[:, 1:].reshape(-1, 2)
    for y in (0.0, 0.02):
        for z in (0.0, 0.02):
            same = np.flatnonzero(
                np.isclose(robot.body.mesh.nodes[:, 0], 0.1)
                & np.isclose(corners, [y, z]).all(axis=1)
            )
            assert len(same) == 2
            assert np.allclose(x[same[0]], x[same[1]], atol=1e-15)


@pytest.mark.parametrize("cable", [False, True])
def test_nodes_have_no_tangent_where_nothing_deforms(
    cable: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A rigid body does not multiply it with the derivative of its nodes, unless a cable bends it."""
    everything = {"lower": [0.0, 0.0, 0.0], "upper": [1.0, 1.0, 1.0]}
    given = {} if cable else {"cables": None}
    arm = constrained(fixed=[], drives=[{**TURN, "region": everything}], **given)
    body, state, effort = arm.body, arm.rest(), np.full(arm.n_a, 5.0)
    products, apply = list[Array](), Congruence.apply

    def counted(own: Congruence, K: Array, T: Array, size: int) -> Array:
        products.append(K)
        return apply(own, K, T, size)

    monkeypatch.setattr(Congruence, "apply", counted)
    body.forces(state, effort, exact=True)
    assert len(products) == cable
    assert all(K.any() for K in products)


def test_a_rigid_body_that_has_diverged_is_told_as_such() -> None:
    """Its quaternion has no length then, of which a ValueError left the control loop."""
    simulator = Simulator(rigid_box(), "none")
    at = simulator.state
    simulator.start_from(State(at.q, np.full_like(at.v, 1e200), at.memory))
    none = np.zeros(simulator.robot.n_a)
    with np.errstate(all="ignore"):
        simulator.step(effort=none)
        with pytest.raises(FactorisationError, match="not finite"):
            simulator.step(effort=none)
