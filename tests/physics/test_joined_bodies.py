"""Beams beside other bodies, pins and hinges, against beam theory, statics and rigid-body mechanics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation
from support.robots.joined import PLASTIC, ROD, joined, push, rod

from tauten.controller import Controller
from tauten.model import Robot, Simulator, State
from tauten.model.body import natural_frequencies
from tauten.model.constraints import ConstrainedBody

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


def tip(robot: Robot[ConstrainedBody], effort: list[float]) -> np.ndarray:
    """Where the first effector is in equilibrium under efforts."""
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(effort=effort).converged
    position: np.ndarray = robot.effector(simulator.state)[0]
    return position


def cantilever(**changes: object) -> Robot[ConstrainedBody]:
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
    found = natural_frequencies(robot.body, robot.rest(), 2)
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


@pytest.mark.parametrize("element", ["linear", "smoothed"])
@pytest.mark.parametrize("across", [3, 4])
def test_a_finer_half_glued_to_a_coarser_one_stretches_as_one_bar(
    element: str, across: int
) -> None:
    """F l / E A without lateral contraction; two cells across in the half that is followed."""
    half, side, force = 0.05, 0.02, 0.01
    mesh = {"file": "box.vtu", "element": element}
    start, end = {"lower": [-1e-6] * 3, "upper": [1e-6, 1.0, 1.0]}, {"body": "fine"}
    end |= {"lower": [half - 1e-6, -1.0, -1.0], "upper": [1.0, 1.0, 1.0]}
    limits = {"max_force": 1.0, "max_travel": 1.0, "max_rate": 1.0}
    robot = joined(
        [
            {"name": "coarse", "mesh": mesh, "fixed": [start]},
            {"name": "fine", "mesh": mesh, "position": [half, 0.0, 0.0]},
        ],
        {
            "coarse": ((half, side, side), (5, 2, 2)),
            "fine": ((half, side, side), (5, across, across)),
        },
        material={"young_modulus": 1e6, "poisson_ratio": 0.0, "density": 1000.0},
        attachments=[
            {"kind": "glue", "region": {"body": "fine", **start}, "to": everywhere("coarse")}
        ],
        forces=[{"name": "pull", "region": end, "direction": [1.0, 0.0, 0.0], **limits}],
        effectors=[{"name": "tip", "kind": "centre", "region": end}],
    )
    longer = tip(robot, [force])[0] - 2.0 * half
    assert longer == pytest.approx(force * 2.0 * half / (1e6 * side**2), rel=5e-3)


def silicone(
    line: list[list[float]], attachments: list[dict[str, object]]
) -> Robot[ConstrainedBody]:
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
    near = {**node(0.1), "radius": 2e-3}  # around the corners beside the node
    glue = {"kind": "glue", "region": end, "to": near, "max_distance": 0.02}
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
    force = 1e-3
    assert simulator.settle(effort=[force]).converged
    values = robot.effector_values(simulator.state)
    position, quaternion = values[3:6], values[6:10]
    along = Rotation.from_quat(np.roll(quaternion, -1)).apply([L, 0.0, 0.0])
    assert along[2] > 5e-4
    bent = force * L**3 / 3.0 / EI
    assert values[2] == pytest.approx(position[2] + along[2] + bent, rel=2e-4)


def arms(
    joint: dict[str, object], direction: list[float], aside: float = 0.0, **changes: object
) -> Robot[ConstrainedBody]:
    """A rigid arm along x that a servo turns about y, and one that hangs from its end and is pushed.

    At the end of the hanging arm is a rod along x, so long [m], where `aside` is not zero.
    """
    end = [L, 0.0, -L]
    rods, glue = [], {"kind": "glue", "region": node(L, z=-L)}
    if aside > 0.0:
        rods = [rod("rod", [end, [L + aside, 0.0, -L]], elements=4)]
    bar = ((L, 0.02, 0.02), (2, 1, 1))
    servo = {
        "name": "servo",
        "region": everywhere("upper"),
        "axis": [0, 1, 0],
        "through": [0, 0, 0],
    }
    down = {"axis": [0.0, 1.0, 0.0], "angle_deg": 90.0}
    return joined(
        [
            {"name": "upper", "position": [0.0, -0.01, -0.01]},
            {"name": "lower", "rigid": True, "position": [L - 0.01, -0.01, 0.0], "rotation": down},
            *rods,
        ],
        {"upper": bar, "lower": bar},
        attachments=[
            {
                "region": everywhere("lower"), "to": everywhere("upper"), "through": [L, 0.0, 0.0],
                "max_distance": 0.02, **joint,
            },
            *({**glue, "to": everywhere("lower")} for _ in rods),
        ],
        drives=[{**servo, **STILL}],
        forces=[push("push", end, direction)],
        effectors=[{"name": "end", "point": end}],
        gravity=[0.0, 0.0, -G],
        **changes,
    )  # fmt: skip


HINGE = {"kind": "hinge", "axis": [0.0, 1.0, 0.0]}
WEIGHT = 1000.0 * L * 0.02 * 0.02 * G  # N, of each arm


@pytest.mark.parametrize("angle", [0.0, 0.5, -1.2])
def test_forces_and_torques_about_a_hinge_balance_on_levers(angle: float) -> None:
    """The hanging arm turns until force and weight balance on it; the hinge bears both, and no moment."""
    robot = arms(HINGE, [1.0, 0.0, 0.0])
    simulator = Simulator(robot, contact="none")
    force = 0.3 * WEIGHT
    assert simulator.settle(position=[angle, np.nan], effort=[np.nan, force]).converged
    x, z = L * np.cos(angle), -L * np.sin(angle)  # of the hinge
    aside = np.arctan(2.0 * force / WEIGHT)
    expected = [x + L * np.sin(aside), 0.0, z - L * np.cos(aside)]
    assert robot.effector(simulator.state)[0] == pytest.approx(expected, abs=1e-7)
    load = z * force + (0.5 * x + x) * WEIGHT
    assert simulator.effort[0] == pytest.approx(-load, rel=1e-6)


@pytest.mark.parametrize("joint", ["hinge", "pin"])
def test_a_rod_that_is_glued_to_a_hanging_arm_turns_it_by_its_weight(joint: str) -> None:
    """A hinged body that a beam is glued to is still one body; its file was refused."""
    aside = 0.08
    robot = arms(HINGE if joint == "hinge" else {"kind": "pin"}, [1.0, 0.0, 0.0], aside)
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[0.0, np.nan], effort=[np.nan, 0.0]).converged
    weight = PLASTIC["density"] * np.pi * 1e-6 * aside * G  # of the rod, N
    turned = np.arctan2(0.5 * aside * weight, (0.5 * WEIGHT + weight) * L)
    expected = [L - L * np.sin(turned), 0.0, -L * np.cos(turned)]
    assert L * turned > 1e-4
    assert robot.effector(simulator.state)[0] == pytest.approx(expected, abs=1e-6)


def test_a_hinge_bears_moments_across_its_axis() -> None:
    """A force along the axis tilts the bearing until its stiffness and the weight balance it."""
    stiffness, force = 5.0, 0.2
    robot = arms({**HINGE, "tilt_stiffness": stiffness}, [0.0, 1.0, 0.0])
    simulator = Simulator(robot, contact="none")
    assert simulator.settle(position=[0.0, np.nan], effort=[np.nan, force]).converged
    tilt = force * L / (stiffness + 0.5 * WEIGHT * L)
    assert robot.effector(simulator.state)[0, :2] == pytest.approx([L, tilt * L], rel=1e-5)


def test_a_pin_bears_no_moment() -> None:
    """The hanging arm swings, damped, into the plane of force and weight; no search found where it rests."""
    damped = {"scheme": "implicit-euler", "rayleigh_mass": 10.0}
    robot = arms({"kind": "pin"}, [1.0, 2.0, 0.0], integration=damped, controller={"rate": 50.0})
    swinging, force = Simulator(robot, contact="none"), 0.2 * WEIGHT
    for _ in range(150):
        swinging.step(position=[0.0, np.nan], effort=[np.nan, force])
    still = Simulator(arms({"kind": "pin"}, [1.0, 2.0, 0.0]), contact="none")
    assert still.settle(position=[0.0, np.nan], effort=[np.nan, force]).converged
    along = np.array([0.2 / np.sqrt(5.0), 0.4 / np.sqrt(5.0), -0.5])  # of the weight
    expected = [L, 0.0, 0.0] + L * along / np.linalg.norm(along)
    np.testing.assert_allclose([swinging.tip, still.tip], [expected, expected], atol=1e-5)


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
    inertia, a, s = (0.1**2 + 0.02**2) / 12.0, 0.05, 0.1  # all of it times the mass of an arm
    M = [[inertia + a**2 + s**2, s * a], [s * a, inertia + a**2]]
    K = np.diag([(a + s) * G, a * G])
    expected = np.sqrt(eigh(K, M, eigvals_only=True)) / (2.0 * np.pi)
    found = natural_frequencies(robot.body, robot.rest(), 2)
    assert found == pytest.approx(expected, rel=2e-3)


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
        assert simulator.settle(position=[angle], effort=[np.nan]).converged
        expected = [0.05, -0.05 * np.sin(angle), 0.05 * np.cos(angle)]
        assert robot.effector(simulator.state)[0] == pytest.approx(expected, abs=1e-7)


@pytest.mark.long
def test_a_tendon_through_discs_on_a_rod_is_controlled_to_a_target() -> None:
    """A continuum robot: rod, two rigid discs, two tendons beside the rod; its tip reaches a target."""
    disc = ((0.004, 0.02, 0.02), (1, 2, 2))
    places = {"middle": 0.05, "end": 0.1}
    tendons = [
        {
            "name": name, "points": [[0.0, 0.0, z], [0.052, 0.0, z], [0.102, 0.0, z]],
            "max_outside": 0.01, "max_tension": 20.0, "min_pull": -0.02, "max_pull": 0.02,
            "max_rate": 1.0,
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
    assert curved.settle(effort=[0.0, 0.02]).converged
    moment = 0.02 * 0.008  # constant along the rod, as long as it bends little between the discs
    assert robot.effector(curved.state)[0, 2] == pytest.approx(moment * L**2 / 2.0 / EI, rel=0.02)


def test_a_beam_steps_in_time_as_its_energy_allows() -> None:
    """Released from a bend it swings back; without damping implicit Euler only loses energy."""
    robot = cantilever(integration={"scheme": "implicit-euler"}, controller={"rate": 2000.0})
    bent = Simulator(cantilever(), contact="none")
    assert bent.settle(effort=[0.05]).converged
    state = State(bent.state.q, np.zeros(robot.n))
    energy, heights = [robot.potential(state)], [robot.effector(state)[0, 2]]
    for _ in range(100):
        system = robot.linearise(state)
        state = robot.advance(state, system.v_free, system.h)
        kinetic = 0.5 * float(state.v @ (robot.body.matrix(robot.body.masses(state)) @ state.v))
        energy.append(robot.potential(state) + kinetic)
        heights.append(robot.effector(state)[0, 2])
    assert min(heights) < -0.2 * heights[0]
    assert max(energy) <= energy[0] * (1.0 + 1e-9)


assert ROD["outer"] == DIAMETER
