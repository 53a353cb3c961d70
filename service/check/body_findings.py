"""What a robot's body says about itself: mass, sag, vibration, thickness of its walls."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tauten.model import ActuatorKind, Robot, Simulator
from tauten.model.body import natural_frequencies
from tauten.model.mesh import wall_thickness
from tauten.model.numerics import FactorisationError
from tauten.service.check.findings import Finding, graded

SAG = (0.1, 0.5)  # of the size; from here on doubtful and wrong
VIBRATION = "natural frequencies"  # subject of a finding
FREQUENCIES = 3
LIGHT = 20.0  # kg/m³; the lightest foams, and a density that was written in g/cm³ is less
STEPS_A_PERIOD = 10.0  # that resolve the first vibration


def body_findings(
    robot: Robot, free: tuple[str, ...] = (), density: float | None = None
) -> Iterator[Finding]:
    """Mass, sag under gravity, natural frequencies.

    Args:
        robot: the robot.
        free: bodies that only contact holds.
        density: the least of its materials [kg/m³]; None where none is given.
    """
    yield mass(robot, density)
    if free:
        yield Finding("sag and natural frequencies", "fine", not_held(free))
    else:
        yield sag(robot)
        yield vibration(robot)


def mass(robot: Robot, density: float | None) -> Finding:
    """What moves, and whether its density is that of something solid; arguments as of `body_findings`."""
    subject, found = "moving mass", f"{1e3 * robot.body.moving_mass:.4g} g"
    if density is None or density >= LIGHT:
        return Finding(subject, "fine", found)
    advice = "check density [kg/m³]: a silicone of 1.07 g/cm³ has 1070"
    return Finding(subject, "doubtful", f"{found} with a density of {density:.3g} kg/m³", advice)


def not_held(free: tuple[str, ...]) -> str:
    """Why equilibria without contact are not looked at where some bodies are free."""
    return f"not looked at: by the robot file nothing holds {', '.join(free)} but contact"


def sag(robot: Robot) -> Finding:
    """Displacement under gravity with drives at rest and no other effort, relative to the body's size."""
    subject = "sag under gravity"
    if not robot.gravity.any():
        return Finding(subject, "fine", "no gravity in the robot file")
    advice = "check young_modulus [Pa], density [kg/m³], gravity and mesh.length_unit"
    simulator = Simulator(robot, contact="none")
    motors = (ActuatorKind.DRIVE, ActuatorKind.SLIDE)
    held = np.array([kind in motors for kind in robot.actuators.kinds])
    position, effort = np.where(held, 0.0, np.nan), np.where(held, np.nan, 0.0)
    if not simulator.settle(position, effort, tolerance=1e-6).converged:
        return Finding(subject, "wrong", "the body does not come to rest", advice)
    points = simulator.robot.points(simulator.state) - robot.points(robot.rest())  # (P, 3)
    moved = float(np.linalg.norm(points, axis=1).max())
    level = graded(moved / robot.size, *SAG)
    found = f"{1e3 * moved:.3g} mm, {100.0 * moved / robot.size:.2g} % of the size"
    return Finding(subject, level, found, "" if level == "fine" else advice)


def vibration(robot: Robot) -> Finding:
    """The lowest natural frequencies against the control rate."""
    subject = VIBRATION
    try:
        frequencies = natural_frequencies(robot.body, robot.rest(), FREQUENCIES)
    except FactorisationError:
        return Finding(subject, "wrong", "the body is not held", "check fixed")
    scheme = robot.integration
    listed = ", ".join(f"{value:.3g}" for value in frequencies)
    found = f"{listed} Hz at {scheme.rate:g} Hz of control"
    first = float(frequencies[0])
    if scheme.static:
        if first < scheme.rate:
            advice = 'integration.scheme = "quasi-static" leaves the first vibration out'
            return Finding(subject, "doubtful", found, advice)
        return Finding(subject, "fine", found)
    if scheme.rate >= STEPS_A_PERIOD * first:
        return Finding(subject, "fine", found)
    advice = (
        f"a period of the first vibration has {scheme.rate / first:.2g} decisions, which do not see it; "
        f"controller.rate = {STEPS_A_PERIOD * first:.3g} would resolve it, controller.substeps = "
        f"{math.ceil(STEPS_A_PERIOD * first / scheme.rate)} in the model alone"
    )
    return Finding(subject, "doubtful", found, advice)


def thin_walls(robot: Robot, alarm_distance: float) -> Finding:
    """Thickness of the body behind the surfaces that may touch, against the alarm distance."""
    subject = "walls that may touch"
    pairs = robot.contacts.pairs
    if not pairs:
        return Finding(subject, "fine", "no contacts in the robot file")
    if not any(len(pair.triangles) for pair in pairs):
        return Finding(subject, "fine", "all contacts are with obstacles")
    nodes, drawn = robot.motion(robot.rest()).placed(robot.vertices).y, robot.triangles
    boundary = drawn[(drawn < len(nodes)).all(axis=1)]  # outlines of beams are no walls
    triangles = np.unique(np.concatenate([pair.triangles for pair in pairs]), axis=0)
    thickness = wall_thickness(nodes, boundary, triangles)  # (t,)
    thin = int((thickness < alarm_distance).sum())
    at = int(thickness.argmin())
    where = ", ".join(f"{value:.4g}" for value in nodes[triangles[at]].mean(axis=0))
    found = (
        f"{1e3 * thickness[at]:.3g} mm at least, at ({where}) m; {thin} of {len(triangles)} triangles "
        f"thinner than the alarm distance of {1e3 * alarm_distance:g} mm"
    )
    if not thin:
        return Finding(subject, "fine", found)
    advice = f"set contact.alarm_distance below {thickness[at]:.2g} m"
    return Finding(subject, "wrong", found, advice)
