"""What a robot's body says about itself: mass, sag, vibration, thickness of its walls."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tauten.model import Integration, Robot, Simulator
from tauten.model.body import LIGHT_DAMPING, damping_ratios, natural_frequencies
from tauten.model.numerics import Array, FactorisationError
from tauten.service.check.actuator_findings import motors
from tauten.service.check.findings import Finding, graded

SAG = (0.1, 0.5)  # of the size; from here on doubtful and wrong
VIBRATION = "natural frequencies"  # subject of a finding
FREQUENCIES = 3
LIGHT = 20.0  # kg/m³; the lightest foams, and a density that was written in g/cm³ is less
STEPS_A_PERIOD = 10.0  # that resolve the first vibration
DAMPED = 0.1  # share of critical damping that advice asks for
LOWEST = 0.01  # Hz; what vibrates more slowly is held by rounding


def body_findings(
    robot: Robot,
    free: tuple[str, ...] = (),
    lone: tuple[str, ...] = (),
    density: float | None = None,
    shipped: bool = False,
) -> Iterator[Finding]:
    """Mass, sag under gravity, natural frequencies.

    Args:
        robot: the robot.
        free: bodies that only contact holds.
        lone: those of them that no contact touches.
        density: the least of its materials [kg/m³]; None where none is given.
        shipped: whether its file is that of a shipped robot, which is not to be changed.
    """
    yield mass(robot, density)
    if free:
        yield free_bodies(robot, free, lone)
    else:
        alone = frequencies_of(robot)
        springs = robot.spring_rows(robot.rest())
        hung = sag(robot, alone is not None)
        yield hung
        frequencies = frequencies_of(robot, springs) if len(springs) > 0 else alone
        carried = bool(robot.gravity.any()) and hung.level == "fine"
        yield vibration(robot, frequencies, carried, shipped)


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


def free_bodies(robot: Robot, free: tuple[str, ...], lone: tuple[str, ...]) -> Finding:
    """Whether something may hold the bodies that are free; arguments as of `body_findings`."""
    subject = "sag and natural frequencies"
    if not (lone and robot.gravity.any()):
        return Finding(subject, "fine", not_held(free))
    names = ", ".join(lone)
    found = f"{names}: free, and touched by no contact of the robot file"
    advice = f"[[contacts]] with a surface of {names}, which else falls unless actuators carry it"
    return Finding(subject, "doubtful", found, advice)


def sag(robot: Robot, alone: bool) -> Finding:
    """Displacement under gravity with drives at rest and no other effort, relative to the body's size.

    Args:
        robot: the robot.
        alone: whether the body is held where cables are slack. Links on hinges are not, and would fall:
            cables stay where they are, too, then.
    """
    subject = "sag under gravity"
    if not robot.gravity.any():
        return Finding(subject, "fine", "no gravity in the robot file")
    advice = (
        "check young_modulus [Pa], density [kg/m³], gravity, and mesh.length_unit or profiles [m]"
    )
    simulator = Simulator(robot, contact="none")
    held = motors(robot) if alone else ~robot.actuators.laws.held_by_force
    position, effort = np.where(held, 0.0, np.nan), np.where(held, np.nan, 0.0)
    if not simulator.settle(position, effort, tolerance=1e-6).converged:
        return Finding(subject, "wrong", "the body does not come to rest", advice)
    points = simulator.robot.points(simulator.state) - robot.points(robot.rest())  # (P, 3)
    moved = float(np.linalg.norm(points, axis=1).max())
    level = graded(moved / robot.size, *SAG)
    found = f"{1e3 * moved:.3g} mm, {100.0 * moved / robot.size:.2g} % of the size"
    return Finding(subject, level, found, "" if level == "fine" else advice)


def frequencies_of(robot: Robot, springs: Array | None = None) -> Array | None:
    """The lowest natural frequencies, `springs` as of `natural_frequencies`; None: the body is not held."""
    try:
        found = natural_frequencies(robot.body, robot.rest(), FREQUENCIES, springs)
    except FactorisationError:
        return None
    return found if found[0] > LOWEST else None


def vibration(
    robot: Robot, frequencies: Array | None, carried: bool, shipped: bool = False
) -> Finding:
    """The lowest natural frequencies against the control rate.

    Args:
        robot: the robot.
        frequencies: (k,) [Hz], None where the body is not held, as of `frequencies_of`.
        carried: whether it stands still under gravity.
        shipped: as of `body_findings`.
    """
    if frequencies is None:
        if carried:
            return Finding(VIBRATION, "fine", "not looked at: nothing but cables holds the body")
        return Finding(VIBRATION, "wrong", "the body is not held", "check fixed")
    scheme = robot.integration
    listed = ", ".join(f"{value:.3g}" for value in frequencies)
    found = f"{listed} Hz at {scheme.rate:g} Hz of control"
    first = float(frequencies[0])
    if scheme.static:
        if first < scheme.rate:
            advice = 'integration.scheme = "quasi-static" leaves the first vibration out'
            return Finding(VIBRATION, "doubtful", found, advice)
        return Finding(VIBRATION, "fine", found)
    if scheme.rate >= STEPS_A_PERIOD * first:
        return light_damping(scheme, frequencies) or Finding(VIBRATION, "fine", found)
    advice = f"a period of the first vibration has {scheme.rate / first:.2g} decisions, which do not see it; "
    if shipped:
        advice += f"tauten serve --rate {STEPS_A_PERIOD * first:.3g} would resolve it"
    else:
        advice += (
            f"controller.rate = {STEPS_A_PERIOD * first:.3g} would resolve it, controller.substeps = "
            f"{math.ceil(STEPS_A_PERIOD * first / scheme.rate)} in the model alone"
        )
    return Finding(VIBRATION, "doubtful", found, advice)


def light_damping(scheme: Integration, frequencies: Array) -> Finding | None:
    """Rayleigh damping so light that decisions may keep the model swinging; None where it is not, or is none.

    It is that of the vibrations with the lowest natural frequencies (k,) [Hz].
    """
    omega, shares = 2.0 * np.pi * frequencies, damping_ratios(scheme, frequencies)  # (k,)
    least = int(shares.argmin())
    if scheme.viscous or not 0.0 < shares[least] < LIGHT_DAMPING:
        return None
    needed = float(((2.0 * DAMPED - scheme.rayleigh_mass / omega) / omega).max())
    percent = 100.0 * shares[least]
    found = f"the vibration of {frequencies[least]:.3g} Hz has {percent:.2g} % of critical damping"
    advice = (
        f"the robot swings long after its actuators have come to rest, and with controller.substeps above 0 "
        f"targets out of reach may keep the model swinging; integration.rayleigh_stiffness = {needed:.2g} "
        "damps it"
    )
    return Finding(VIBRATION, "doubtful", found, advice)
