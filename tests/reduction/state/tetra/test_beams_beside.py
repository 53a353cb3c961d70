"""State bases of robots with beams beside bodies of tetrahedra: the full robots, and beam theory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.robots.joined import PLASTIC, ROD, joined, push, rod
from support.state_bases import basis_of, projected

from tauten.model import Robot, Simulator, State
from tauten.model.constraints import ConstrainedBody
from tauten.model.numerics import Array
from tauten.reduction.state import ReducedBody, StateBasisError, reduced_robot, reducible
from tauten.reduction.state.modes import pod, with_own, without_own

MODES = 9
L = 0.1
LINE = [[0.0, 0.0, 0.0], [L, 0.0, 0.0]]
BAR = ((L, 0.01, 0.01), (10, 2, 2))
ROOT = {"body": "soft", "lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.01, 0.01]}
END = {"body": "soft", "lower": [L, 0.0, 0.0], "upper": [L, 0.01, 0.01]}
LOAD = {"max_force": 1e3, "max_travel": 1.0, "max_rate": 10.0}
EI = PLASTIC["young_modulus"] * np.pi / 64.0 * float(ROD["outer"]) ** 4


def node(x: float, body: str = "rod", radius: float = 1e-6) -> dict[str, object]:
    """The node of a beam along the axis."""
    return {"kind": "sphere", "centre": [x, 0.0, 0.0], "radius": radius, "body": body}


def everywhere(body: str) -> dict[str, object]:
    return {"kind": "all", "body": body}


def pushes(region: dict[str, object]) -> list[dict[str, object]]:
    """Forces on a region along all axes."""
    axes = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}
    return [
        {"name": name, "region": region, "direction": axis, **LOAD} for name, axis in axes.items()
    ]


def wire(elements: int = 5, **changes: object) -> Robot[ConstrainedBody]:
    """A soft bar and a rod along its axis, clamped with it and pinned into it."""
    inside = {"body": "rod", "kind": "half_space", "point": [1e-4, 0, 0], "normal": [1, 0, 0]}
    return joined(
        [
            {"name": "soft", "position": [0.0, -0.005, -0.005], "fixed": [ROOT]},
            rod("rod", LINE, elements=elements, fixed=[node(0.0)]),
        ],
        {"soft": BAR},
        attachments=[{"kind": "pin", "region": inside, "to": everywhere("soft")}],
        forces=pushes(END),
        effectors=[{"name": "tip", "kind": "centre", "region": END}],
        **changes,
    )


def dense_wire() -> Robot[ConstrainedBody]:
    """More pins than the tetrahedra around them have independent displacements."""
    return wire(40)


def carried(**changes: object) -> Robot[ConstrainedBody]:
    """A rod that is clamped, and a soft bar glued to its end."""
    glue = {"kind": "glue", "region": ROOT, "to": node(L, radius=2e-3), "max_distance": 0.02}
    return joined(
        [
            {"name": "soft", "position": [L, -0.005, -0.005]},
            rod("rod", LINE, elements=4, fixed=[node(0.0)]),
        ],
        {"soft": BAR},
        attachments=[glue],
        forces=pushes(END),
        effectors=[
            {"name": "tip", "kind": "centre", "region": END},
            {"name": "node", "point": [L, 0.0, 0.0]},
        ],
        **changes,
    )


def turned(**changes: object) -> Robot[ConstrainedBody]:
    """A rod in a servo, a rigid disc glued to its end, a soft bar glued to that, a cable through all."""
    disc = ((0.004, 0.02, 0.02), (1, 2, 2))
    servo = {"name": "servo", "region": node(0.0), "axis": [1.0, 0.0, 0.0], "through": [0, 0, 0]}
    limits = {"max_torque": 1.0, "max_angle": 2.0, "max_rate": 1.0}
    return joined(
        [
            rod("rod", LINE, elements=3),
            {"name": "disc", "rigid": True, "position": [L, -0.01, -0.01]},
            {"name": "soft", "position": [L + 0.004, -0.005, -0.005]},
        ],
        {"disc": disc, "soft": BAR},
        drives=[{**servo, **limits}],
        attachments=[
            {"kind": "glue", "region": node(L), "to": everywhere("disc")},
            {"kind": "glue", "region": ROOT, "to": everywhere("disc")},
        ],
        cables=[
            {
                "name": "tendon", "points": [[0.0, 0.0, 0.0], [L + 0.002, 0.0, 0.004], [0.2, 0.0, 0.004]],
                "max_outside": 0.01, "max_tension": 10.0, "max_pull": 0.02, "max_rate": 0.1,
            }
        ],
        forces=[push("push", [0.2, 0.0, 0.0], [0.0, 1.0, 0.0])],
        effectors=[{"name": "tip", "kind": "frame", "region": END}],
        **changes,
    )  # fmt: skip


def reduced(robot: Robot, Phi: Array) -> Robot[ReducedBody]:
    """The robot in some modes, with all elements."""
    every = np.arange(reducible(robot).n_elements)
    return reduced_robot(robot, basis_of(robot, Phi, every, np.ones(len(every))))


def random_modes(robot: Robot[ConstrainedBody]) -> Array:
    """Orthonormal modes, as deviations of random configurations are: without the robot's own coordinates."""
    body, rng = reducible(robot), np.random.default_rng(0)
    rates = body.rates(robot.rest().q, rng.normal(size=(robot.n, MODES)))
    return with_own(body, pod(without_own(body, rates), body.weight, MODES).Phi)


@pytest.fixture(scope="module", params=[wire, dense_wire, carried, turned])
def robot(request: pytest.FixtureRequest) -> Robot[ConstrainedBody]:
    found = request.param()
    assert isinstance(found.body, ConstrainedBody)
    return found


@pytest.fixture(scope="module")
def small(robot: Robot[ConstrainedBody]) -> Robot[ReducedBody]:
    return reduced(robot, random_modes(robot))


@pytest.fixture(scope="module")
def state(small: Robot[ReducedBody]) -> State:
    """Frames turned by a third, nodes moved by millimetres, all moving."""
    rng, motion = np.random.default_rng(1), small.body.own_motion
    scale = np.full(small.n, 1e-3)
    scale[motion.straight :] = scale[motion.modes : motion.modes + motion.drives] = 0.3
    return State(*(factor * scale * rng.normal(size=small.n) for factor in (1.0, 20.0)))


def velocities(small: Robot[ReducedBody]) -> Array:
    """Velocities of the full robot (n_full, n) of those of the reduced one."""
    body = small.body
    return np.stack([body.chart.velocity(mode) for mode in body.Phi.T], axis=1)


def test_a_state_comes_back_from_the_full_robot(small: Robot[ReducedBody], state: State) -> None:
    back = projected(small, small.body.lifted(state))
    np.testing.assert_allclose(back.q, state.q, atol=1e-12)
    np.testing.assert_allclose(back.v, state.v, atol=1e-10)
    np.testing.assert_allclose(
        small.points(state), small.body.full.points(small.body.lifted(state)), atol=1e-14
    )


def test_forces_tangent_mass_and_rows_are_those_of_the_full_robot(
    robot: Robot[ConstrainedBody], small: Robot[ReducedBody], state: State
) -> None:
    lifted, B = small.body.lifted(state), velocities(small)
    effort = np.array([0.5, 0.2, 0.4])[: robot.n_a]
    for exact in (False, True):
        force, K = small.forces(state, effort, exact)
        full_force, values = robot.forces(lifted, effort, exact)
        expected = B.T @ (robot.body.matrix(values) @ B)
        np.testing.assert_allclose(force, B.T @ full_force, atol=1e-9 * np.abs(force).max())
        np.testing.assert_allclose(K, expected, atol=1e-9 * np.abs(K).max())
    mass = B.T @ (robot.body.matrix(robot.body.masses(lifted)) @ B)
    np.testing.assert_allclose(small.body.masses(state), mass, atol=1e-12 * mass.max())
    spun, known = small.body.inertia_at(state), robot.body.inertia_at(lifted)
    np.testing.assert_allclose(spun, B.T @ known, atol=1e-10 * max(np.abs(spun).max(), 1e-6))
    found, full = small.rows(state), robot.rows(lifted)
    np.testing.assert_allclose(found.actuators.delta, full.actuators.delta, atol=1e-13)
    np.testing.assert_allclose(found.actuators.dense(), full.actuators.dense() @ B, atol=1e-11)
    np.testing.assert_allclose(found.effectors.dense(), full.effectors.dense() @ B, atol=1e-10)
    work = small.potential(state) - small.potential(small.rest())
    assert work == pytest.approx(robot.potential(lifted) - robot.potential(robot.rest()), rel=1e-9)


def test_forces_are_the_derivative_of_the_energy(small: Robot[ReducedBody], state: State) -> None:
    direction, step = np.random.default_rng(2).normal(size=small.n), 1e-6
    ends = [small.advance(state, sign * direction, step) for sign in (1.0, -1.0)]
    power = (small.potential(ends[0]) - small.potential(ends[1])) / (2.0 * step)
    assert -power == pytest.approx(float(small.forces(state)[0] @ direction), rel=1e-6)
    motion = small.body.own_motion
    rate = (motion.beta(ends[0].q) - motion.beta(ends[1].q)) / (2.0 * step)
    np.testing.assert_allclose(
        motion.jacobian(motion.beta(state.q)).rates(direction), rate, atol=1e-7
    )
    back = small.body.velocity(state, ends[0]) * small.h / step
    np.testing.assert_allclose(back, direction, atol=1e-6)


def trained(make: Callable[..., Robot[ConstrainedBody]], sizes: Array) -> Array:
    """Modes (m, r) of equilibria under random forces of some sizes (3,)."""
    robot, found = make(), []
    simulator, rng = Simulator(robot, "none"), np.random.default_rng(4)
    for _ in range(20):
        assert simulator.settle(effort=sizes * rng.uniform(-1.0, 1.0, 3)).converged
        found.append(simulator.state.q)
    body = reducible(robot)
    modes = pod(without_own(body, body.deviations(np.array(found).T)), body.weight, 18)
    return with_own(body, modes.Phi)


@pytest.mark.long
@pytest.mark.parametrize(
    ("make", "sizes"),
    [(wire, [0.3, 0.05, 0.05]), (carried, [0.03, 0.03, 0.03])],
)
def test_it_rests_and_moves_as_the_full_robot(
    make: Callable[..., Robot[ConstrainedBody]], sizes: list[float]
) -> None:
    """Under forces that the basis has not seen; the errors are within a thousandth of the way."""
    size = np.array(sizes)
    Phi, robot = trained(make, size), make()
    full, small = Simulator(robot, "none"), Simulator(reduced(robot, Phi), "none")
    rest, way, error = robot.effector(robot.rest()), 0.0, 0.0
    for force in np.random.default_rng(5).uniform(-0.8, 0.8, size=(3, 3)) * size:
        assert full.settle(effort=force).converged
        assert small.settle(effort=force).converged
        way = max(way, np.linalg.norm(full.effector - rest, axis=1).max())
        error = max(error, np.linalg.norm(full.effector - small.effector, axis=1).max())
    assert way > 0.003
    assert error < 1e-3 * way
    damped = {"scheme": "implicit-euler", "rayleigh_stiffness": 0.01}
    moving = make(integration=damped, controller={"rate": 100.0})
    full, small = Simulator(moving, "none"), Simulator(reduced(moving, Phi), "none")
    way, error = 0.0, 0.0
    for tick in range(40):
        force = size * np.array([0.2, 0.8, -0.6]) * np.sin(tick / 8.0)
        full.step(effort=force)
        small.step(effort=force)
        way = max(way, np.linalg.norm(full.effector - rest, axis=1).max())
        error = max(error, np.linalg.norm(full.effector - small.effector, axis=1).max())
    assert way > 0.003
    assert error < 5e-3 * way


def test_the_stiffnesses_of_a_wire_and_of_the_silicone_around_it_add() -> None:
    """In modes of the silicone alone the wire would stretch where it bends, and be far stiffer."""
    force = 1e-3
    Phi, robot = trained(wire, np.array([0.0, 1e-3, 1e-3])), wire()
    within = Simulator(reduced(robot, Phi), "none")
    assert within.settle(effort=[0.0, 0.0, force]).converged
    bodies = [
        {"name": "soft", "position": [0.0, -0.005, -0.005], "fixed": [ROOT]},
        rod("rod", [[0.0, 0.0, 0.1], [L, 0.0, 0.1]], fixed=[{**node(0.0), "centre": [0, 0, 0.1]}]),
    ]
    end = [{"name": "tip", "kind": "centre", "region": END}]
    apart = joined(bodies, {"soft": BAR}, forces=pushes(END), effectors=end)
    beside = Simulator(apart, "none")
    assert beside.settle(effort=[0.0, 0.0, force]).converged
    stiffness = force / within.effector[0, 2] - force / beside.effector[0, 2]
    assert stiffness == pytest.approx(3.0 * EI / L**3, rel=0.02)


@pytest.mark.long
def test_a_rod_with_a_soft_end_bends_as_a_cantilever() -> None:
    """A force on the soft bar bends the rod by the force and by the moment of its arm."""
    force = 1e-3
    Phi, robot = trained(carried, np.array([2e-3, 2e-3, 2e-3])), carried()
    simulator = Simulator(reduced(robot, Phi), "none")
    assert simulator.settle(effort=[0.0, 0.0, force]).converged
    shear = L / (PLASTIC["young_modulus"] / 2.6 * 0.9 * np.pi / 4.0 * float(ROD["outer"]) ** 2)
    expected = force * (
        L**3 / 3.0 / EI + L * L**2 / 2.0 / EI + shear
    )  # the arm is as long as the rod
    assert simulator.effector[1, 2] == pytest.approx(expected, rel=1e-3)


TURNS = {"max_angle": 1.0, "max_torque": 1.0, "max_rate": 1.0}


def test_beams_and_drives_leave_nothing_to_reduce() -> None:
    servo = {"name": "servo", "region": node(0.0), "axis": [1.0, 0.0, 0.0]}
    robot = joined([rod("rod", LINE)], drives=[{**servo, "through": [0.0, 0.0, 0.0], **TURNS}])
    with pytest.raises(StateBasisError, match="nothing of it can be reduced, as beams, drives"):
        reducible(robot)
