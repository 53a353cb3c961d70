"""Beams beside soft and rigid bodies, pins and hinges, against beam theory, statics and rigid-body mechanics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from support.robots.joined import PLASTIC, ROD, joined, push, rod

from tauten.controller import Controller
from tauten.model import Simulator, State
from tauten.model.body import natural_frequencies
from tauten.model.constraints import ConstrainedRobot

E, DIAMETER, L = 2e9, 2e-3, 0.1
EI = E * np.pi / 64.0 * DIAMETER**4  # N m²
LINE = [[0.0, 0.0, 0.0], [L, 0.0, 0.0]]
STILL = {"max_angle": 7.0, "max_torque": 100.0, "max_rate": 100.0}
G = 9.81


def node(x: float, body: str = "rod", y: float = 0.0, z: float = 0.0) -> dict[str, object]:
    """The node of a beam at a place, in the coordinates of its body."""
    return {"body": body, "kind": "sphere", "centre": [x, y, z], "radius": 1e-6}


def everywhere(body: str) -> dict[str, object]:
    return {"kind": "all", "body": body}


def tip(robot: ConstrainedRobot, tension: list[float]) -> np.ndarray:
    """Where the first effector is in equilibrium under efforts."""
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(tension=tension).converged
    position: np.ndarray = robot.effector(simulator.state)[0]
    return position


def cantilever(**changes: object) -> ConstrainedRobot:
    given = {
        "forces": [push("push", LINE[1], [0.0, 0.0, 1.0])],
        "effectors": [{"name": "tip", "point": LINE[1]}],
        **changes,
    }
    return joined([rod("rod", LINE, fixed=[node(0.0)])], **given)


def test_a_beam_bends_as_the_elastica_does() -> None:
    """Mattiasson 1981: P L² / E I = 2 gives w / L = 0.49346 and a shortening of 0.16064."""
    force = 2.0 * EI / L**2
    x = tip(cantilever(), [force])
    assert x[2] / L == pytest.approx(0.49346, abs=2e-3)
    assert (L - x[0]) / L == pytest.approx(0.16064, abs=2e-3)


def test_a_beam_vibrates_as_a_cantilever_does() -> None:
    """Euler and Bernoulli's 1.8751² / (2 π L²) sqrt(E I / ρ A), and 2.5 % below it for masses on 8 nodes."""
    robot = cantilever()
    found = natural_frequencies(robot, robot.rest(), 2)
    line = PLASTIC["density"] * np.pi / 4.0 * DIAMETER**2
    expected = 1.8751**2 / (2.0 * np.pi * L**2) * np.sqrt(EI / line)
    assert found == pytest.approx([expected, expected], rel=0.025)


def test_beams_joined_by_a_rigid_disc_bend_as_a_stepped_beam() -> None:
    disc = ((0.01, 0.02, 0.02), (1, 2, 2))
    half, thick = 0.05, 0.01
    robot = joined(
        [
            rod("a", [[0.0, 0.0, 0.0], [half, 0.0, 0.0]], fixed=[node(0.0, "a")]),
            rod("b", [[0.0, 0.0, 0.0], [half, 0.0, 0.0]], position=[half + thick, 0.0, 0.0]),
            {"name": "disc", "rigid": True, "position": [half, -0.01, -0.01]},
        ],
        {"disc": disc},
        attachments=[
            {"kind": "glue", "region": node(half, "a"), "to": everywhere("disc")},
            {"kind": "glue", "region": node(0.0, "b"), "to": everywhere("disc")},
        ],
        forces=[push("push", [0.11, 0.0, 0.0], [0.0, 0.0, 1.0])],
        effectors=[{"name": "tip", "point": [0.11, 0.0, 0.0]}],
    )
    force, whole = 1e-4, 2 * half + thick
    bending = ((whole**3 - (whole - half) ** 3) + half**3) / 3.0 / EI
    shear = 2.0 * half / (E / 2.6 * 0.9 * np.pi / 4.0 * DIAMETER**2)
    assert tip(robot, [force])[2] == pytest.approx(force * (bending + shear), rel=1e-5)


def test_a_beam_glued_to_a_beam_is_one_beam() -> None:
    """Two halves, glued node to node, against the whole under a large force."""
    halves = joined(
        [
            rod("a", [[0.0, 0.0, 0.0], [0.05, 0.0, 0.0]], elements=4, fixed=[node(0.0, "a")]),
            rod("b", [[0.05, 0.0, 0.0], [0.1, 0.0, 0.0]], elements=4),
        ],
        attachments=[{"kind": "glue", "region": node(0.05, "b"), "to": everywhere("a")}],
        forces=[push("push", LINE[1], [0.0, 0.0, 1.0])],
        effectors=[{"name": "tip", "point": LINE[1]}],
    )
    force = 2.0 * EI / L**2
    assert tip(halves, [force]) == pytest.approx(tip(cantilever(), [force]), abs=1e-9)


def silicone(line: list[list[float]], attachments: list[dict[str, object]]) -> ConstrainedRobot:
    """A soft bar, 0.1 m long, 10 mm wide and high, whose end is pushed up, and a rod."""
    x, y, z = line[0]
    end = {"body": "soft", "lower": [0.1, 0.0, 0.0], "upper": [0.1, 0.01, 0.01]}
    load = {"max_force": 1.0, "max_travel": 1.0, "max_rate": 1.0}
    root = {"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.01, 0.01]}
    return joined(
        [
            {"name": "soft", "position": [0.0, -0.005, -0.005], "fixed": [root]},
            rod("rod", line, elements=20, fixed=[node(x, y=y, z=z)]),
        ],
        {"soft": ((0.1, 0.01, 0.01), (20, 4, 4))},
        attachments=attachments,
        forces=[{"name": "push", "region": end, "direction": [0.0, 0.0, 1.0], **load}],
        effectors=[{"name": "tip", "kind": "centre", "region": end}],
    )  # fmt: skip


def test_the_stiffnesses_of_a_rod_and_of_the_silicone_around_it_add() -> None:
    inside = {"body": "rod", "kind": "half_space", "point": [1e-4, 0, 0], "normal": [1, 0, 0]}
    pins = [{"kind": "pin", "region": inside, "to": everywhere("soft")}]
    force = 1e-3
    beside = tip(silicone([[0.0, 0.0, 0.1], [L, 0.0, 0.1]], []), [force])[2]
    within = tip(silicone(LINE, pins), [force])[2]
    assert force / within - force / beside == pytest.approx(3.0 * EI / L**3, rel=2e-3)


def test_a_soft_end_glued_to_a_rod_is_clamped() -> None:
    """The rod goes on beyond the bar: the bar's end follows position and rotation of its node."""
    end = {"body": "soft", "lower": [0.1, 0.0, 0.0], "upper": [0.1, 0.01, 0.01]}
    line = [[0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]
    glue = {"kind": "glue", "region": end, "to": node(0.1), "max_distance": 0.02}
    # the corners beside the node make up the tetrahedron that the region selects by its centre
    glue["to"] = {**node(0.1), "radius": 2e-3}
    robot = joined(
        [
            {
                "name": "soft", "position": [0.0, -0.005, -0.005],
                "fixed": [{"lower": [0.0, 0.0, 0.0], "upper": [0.0, 0.01, 0.01]}],
            },
            rod("rod", line, elements=4),
        ],
        {"soft": ((0.1, 0.01, 0.01), (10, 2, 2))},
        attachments=[glue],
        forces=[push("push", line[1], [0.0, 0.0, 1.0])],
        effectors=[
            {"name": "tip", "point": line[1]},
            {"name": "face", "kind": "frame", "region": end},
        ],
    )  # fmt: skip
    simulator = Simulator(robot, contact="none")
    force = 1e-4
    assert simulator.settle(tension=[force]).converged
    values = robot.effector_values(simulator.state)
    position, quaternion = values[3:6], values[6:10]
    slope = 2.0 * np.arcsin(np.linalg.norm(quaternion[1:]))
    assert slope > 1e-3
    bent = force * L**3 / 3.0 / EI
    assert values[2] == pytest.approx(position[2] + np.sin(slope) * L + bent, rel=2e-4)


def arms(joint: dict[str, object], **changes: object) -> ConstrainedRobot:
    """A rigid arm that a servo turns about y at the origin, and a second one that a joint at x = 0.1 holds."""
    bar = ((0.1, 0.02, 0.02), (2, 1, 1))
    middle = [0.0, -0.01, -0.01]
    servo = {"name": "servo", "region": everywhere("upper"), "axis": [0, 1, 0], "through": [0, 0, 0]}
    return joined(
        [
            {"name": "upper", "position": middle},
            {"name": "lower", "rigid": True, "position": [0.1, *middle[1:]]},
        ],
        {"upper": bar, "lower": bar},
        attachments=[{"region": everywhere("lower"), "to": everywhere("upper"), **joint}],
        drives=[{**servo, **STILL}],
        **{
            "forces": [push("push", [0.2, 0.0, 0.0], [0.0, 0.0, 1.0])],
            "effectors": [{"name": "tip", "point": [0.2, 0.0, 0.0]}],
            "gravity": [0.0, 0.0, -G],
            **changes,
        },
    )  # fmt: skip


HINGE = {"kind": "hinge", "axis": [0.0, 1.0, 0.0], "through": [0.1, 0.0, 0.0]}
MASS = 1000.0 * 0.1 * 0.02 * 0.02  # kg, of each arm


@pytest.mark.parametrize("angle", [0.0, 0.5, -1.2])
def test_forces_and_torques_about_a_hinge_balance_on_levers(angle: float) -> None:
    """The second arm is level: half of its weight on the force, half on the hinge, and so on the servo."""
    robot = arms(HINGE)
    simulator = Simulator(robot, contact="none")
    height = -0.1 * np.sin(angle)  # of the hinge, and of the end that is lifted with it
    assert simulator.settle(pull=[angle, height], tension=[np.nan, np.nan]).converged
    lifted = robot.effector(simulator.state)[0]
    assert lifted == pytest.approx([0.1 * np.cos(angle) + 0.1, 0.0, height], abs=1e-6)
    torque, force = simulator.tension
    assert force == pytest.approx(0.5 * MASS * G, rel=1e-6)
    lever = 0.1 * np.cos(angle)
    assert torque == pytest.approx(-MASS * G * (0.5 * lever + 0.5 * lever), rel=1e-6)


def test_a_hinge_bears_moments_across_its_axis() -> None:
    """A sideways force tilts the bearing by its moment over the tilt stiffness, and turns nothing else."""
    stiffness, force = 50.0, 0.2
    robot = arms(
        {**HINGE, "tilt_stiffness": stiffness},
        gravity=[0.0, 0.0, 0.0],
        forces=[push("push", [0.2, 0.0, 0.0], [0.0, 1.0, 0.0])],
    )
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(pull=[0.0, np.nan], tension=[np.nan, force]).converged
    tilted = robot.effector(simulator.state)[0]
    assert tilted[1] == pytest.approx(0.1 * force * 0.1 / stiffness, rel=1e-5)
    assert tilted[2] == pytest.approx(0.0, abs=1e-9)


def test_a_double_pendulum_has_the_frequencies_of_its_links() -> None:
    """Both arms hang; the upper one turns on a hinge at the frame, the lower one on a hinge at the upper."""
    bar = ((0.1, 0.02, 0.02), (2, 1, 1))
    down = {"axis": [0.0, 1.0, 0.0], "angle_deg": 90.0}
    robot = joined(
        [
            {"name": "upper", "position": [-0.01, -0.01, 0.0], "rotation": down},
            {"name": "lower", "rigid": True, "position": [-0.01, -0.01, -0.1], "rotation": down},
        ],
        {"upper": bar, "lower": bar},
        gravity=[0.0, 0.0, -G],
        attachments=[
            {"kind": "hinge", "region": everywhere("upper"), "axis": [0, 1, 0], "through": [0, 0, 0]},
            {
                "kind": "hinge", "region": everywhere("lower"), "to": everywhere("upper"),
                "axis": [0, 1, 0], "through": [0, 0, -0.1], "tilt_stiffness": 1e4,
            },
        ],
        forces=[push("push", [0.0, 0.0, -0.2], [1.0, 0.0, 0.0])],
        effectors=[{"name": "tip", "point": [0.0, 0.0, -0.2]}],
    )  # fmt: skip
    mass = robot.raw.mass[::3]
    x = robot.mesh.nodes
    upper, lower = x[:, 2] > -0.1 + 1e-9, x[:, 2] < -0.1 - 1e-9
    split = len(x) // 2  # nodes of the upper arm come first
    m, c, inertia = [], [], []
    for part in (np.arange(split), np.arange(split, len(x))):
        m.append(mass[part].sum())
        c.append(np.average(x[part], axis=0, weights=mass[part]))
        r = x[part] - c[-1]
        inertia.append(float(mass[part] @ (r[:, 0] ** 2 + r[:, 2] ** 2)))
    assert upper.any() and lower.any()
    a, b, s = -c[0][2], -0.1 - c[1][2], 0.1
    M = [[inertia[0] + m[0] * a**2 + m[1] * s**2, m[1] * s * b],
         [m[1] * s * b, inertia[1] + m[1] * b**2]]  # fmt: skip
    K = np.diag([(m[0] * a + m[1] * s) * G, m[1] * b * G])
    expected = np.sqrt(eigh(K, M, eigvals_only=True)) / (2.0 * np.pi)
    found = natural_frequencies(robot, robot.rest(), 2)
    assert found == pytest.approx(expected, rel=2e-3)


def test_a_ball_joint_bears_no_moment() -> None:
    """Under a sideways and a downward force the pinned arm ends along the force."""
    robot = arms({"kind": "pin", "through": [0.1, 0.0, 0.0]}, gravity=[0.0, 0.0, 0.0],
                 forces=[push("push", [0.2, 0.0, 0.0], [1.0, 0.4, 0.3])])  # fmt: skip
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(pull=[0.0, np.nan], tension=[np.nan, 1.0]).converged
    along = (robot.effector(simulator.state)[0] - [0.1, 0.0, 0.0]) / 0.1
    assert along == pytest.approx(np.array([1.0, 0.4, 0.3]) / np.linalg.norm([1.0, 0.4, 0.3]), abs=1e-6)


def test_a_beam_in_a_servo_turns_with_it() -> None:
    """A bent rod, turned about the line through its root: its end goes round a circle."""
    servo = {"name": "servo", "region": node(0.0), "axis": [1.0, 0.0, 0.0], "through": [0, 0, 0]}
    robot = joined(
        [rod("rod", [[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.05, 0.0, 0.05]], elements=3)],
        drives=[{**servo, **STILL}],
        effectors=[{"name": "tip", "point": [0.05, 0.0, 0.05]}],
    )
    simulator = Simulator(robot, contact="none")
    for angle in (0.7, 2.0):
        assert simulator.settle(pull=[angle], tension=[np.nan]).converged
        expected = [0.05, -0.05 * np.sin(angle), 0.05 * np.cos(angle)]
        assert robot.effector(simulator.state)[0] == pytest.approx(expected, abs=1e-9)


def test_a_tendon_through_discs_on_a_rod_is_controlled_to_a_target() -> None:
    """A continuum robot: rod, two rigid discs, two tendons beside the rod; its tip reaches a target."""
    disc = ((0.004, 0.02, 0.02), (1, 2, 2))
    places = {"middle": 0.05, "end": 0.1}
    tendons = [
        {
            "name": name, "points": [[0.0, 0.0, z], [0.052, 0.0, z], [0.102, 0.0, z]],
            "max_outside": 0.01, "max_tension": 20.0, "max_pull": 0.02, "max_rate": 1.0,
        }
        for name, z in (("lower", -0.008), ("upper", 0.008))
    ]  # fmt: skip
    robot = joined(
        [
            rod("rod", LINE, elements=8, fixed=[node(0.0)]),
            *(
                {"name": name, "rigid": True, "position": [x, -0.01, -0.01]}
                for name, x in places.items()
            ),
        ],
        dict.fromkeys(places, disc),
        attachments=[
            {"kind": "glue", "region": node(x), "to": everywhere(name)} for name, x in places.items()
        ],
        cables=tendons,
        effectors=[{"name": "tip", "point": [0.1, 0.0, 0.0], "weight": [0.0, 0.0, 1.0]}],
        integration={"scheme": "implicit-euler", "rayleigh_stiffness": 0.02},
        controller={"rate": 100.0},
    )  # fmt: skip
    controller = Controller(robot)
    target = np.array([0.1, 0.0, 0.02])
    for _ in range(200):
        decision = controller.decide(target)
        assert decision.status.usable
        controller.advance()
    reached = robot.effector(controller.state)[0]
    assert reached[2] == pytest.approx(0.02, abs=2e-4)
    curved = Simulator(robot, contact="none")
    assert curved.settle(tension=[0.0, 2.0]).converged
    moment = 2.0 * 0.008  # constant along the rod where discs guide the tendon, to first order
    assert robot.effector(curved.state)[0, 2] == pytest.approx(moment * L**2 / 2.0 / EI, rel=0.1)


def test_a_beam_steps_in_time_as_its_energy_allows() -> None:
    """Released from a bend it swings back; without damping implicit Euler only loses energy."""
    robot = cantilever(integration={"scheme": "implicit-euler"}, controller={"rate": 2000.0})
    bent = Simulator(cantilever(), contact="none")
    assert bent.settle(tension=[0.05]).converged
    state = State(bent.state.q, np.zeros(robot.n))
    energy, heights = [robot.potential(state)], [robot.effector(state)[0, 2]]
    for _ in range(100):
        system = robot.linearise(state)
        state = robot.advance(state, system, system.v_free - state.v)
        kinetic = 0.5 * float(state.v @ (robot.mass_matrix(state) @ state.v))
        energy.append(robot.potential(state) + kinetic)
        heights.append(robot.effector(state)[0, 2])
    assert min(heights) < -0.2 * heights[0]
    assert max(energy) <= energy[0] * (1.0 + 1e-9)


assert ROD["outer"] == DIAMETER
