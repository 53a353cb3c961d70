"""Lee's frame: a hinged right angle that snaps through, under a dead force and under a cable.

Column and beam of length L, load at L / 5 from the corner. First limit load P L² / E I = 18.7 of Lee, Manuel
and Rossow, J. Engineering Mechanics Division ASCE 94, 1968; Simo and Vu-Quoc's elements, Computer Methods in
Applied Mechanics and Engineering 58, 1986, give 18.53. The robot has no hinges: a flexure of negligible
length and bending stiffness takes the place of each.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root
from support.robots.beam_robots import build, cable, path_of_beams, rectangle

from tauten.model import Ending, Robot, Simulator, State
from tauten.model.beams import BeamBody, bar
from tauten.model.numerics import Array

# Of the cross-section, for L = 1 m; wide, so that it moves in its plane.
HEIGHT, WIDTH = 1.0 / 60.0, 0.1
E = 7.2e6
SECTION = bar(WIDTH, HEIGHT)
EI, EA, GA = E * SECTION.bending[0], E * SECTION.area, 0.5 * E * SECTION.shear_area[1]  # ν = 0
PUBLISHED = 18.7
HINGE = 1e-3  # stiffness of a flexure, E I / L
BELOW = 80.0  # m, how far the winch is below the frame: its cable is nearly vertical


def frame(
    folder: Path, count: int, winch: bool = False, spring: float | None = None
) -> Robot[BeamBody]:
    """The frame in the plane z = 0 with `count` beams in column and beam each."""
    length = 1e-4 if winch else 1e-5  # of a flexure; the shortest beam is 1e-6 of the robot's size
    thin = HEIGHT * (HINGE * length) ** (1.0 / 3.0)
    along = np.linspace(0.0, 1.0, count + 1)
    column = np.stack([0.0 * along, along], axis=1)
    beam = np.stack([along, 0.0 * along + 1.0], axis=1)[1:]
    plane = np.vstack([[0.0, -length], column, beam, [1.0 + length, 1.0]])
    nodes = np.hstack([plane, np.zeros((len(plane), 1))])
    last, loaded = len(nodes) - 1, 1 + count + count // 5
    beams = path_of_beams(nodes, (0.0, 1.0, 0.0), "frame")
    for item in beams[: count + 1]:
        item["up"] = (1.0, 0.0, 0.0)
    beams[0]["profile"] = beams[-1]["profile"] = "hinge"
    held, more = [0, last], {}
    if winch:  # on a held node, which a beam between held nodes joins to the frame
        below = [0.2, 1.0 - BELOW, 0.0]
        nodes = np.vstack([nodes, below])
        beams.append({"ends": [0, last + 1], "profile": "frame", "up": (0.0, 0.0, 1.0)})
        held.append(last + 1)
        more["cables"] = [cable([below, nodes[loaded].tolist()])]
        if spring is not None:
            more["cables"][0]["spring"] = {"stiffness": spring}
    profiles = [rectangle("frame", WIDTH, HEIGHT), rectangle("hinge", WIDTH, thin)]
    return build(folder, nodes, beams, profiles, (E, 0.0, 1.0), held, loaded, **more)


@dataclass(frozen=True)
class ExactFrame:
    """Reissner's rod in the plane, integrated from flexure to flexure; units E I / L² and L."""

    EA: float = EA / EI
    GA: float = GA / EI

    def segment(self, start: Array, length: float, force: Array) -> Array:
        """x, y, angle and moment (4,) at the end of a piece with a constant force (2,) inside."""

        def slope(_: float, y: Array) -> list[float]:
            c, s = np.cos(y[2]), np.sin(y[2])
            stretch = 1.0 + (force[0] * c + force[1] * s) / self.EA
            shear = (force[1] * c - force[0] * s) / self.GA
            dx, dy = stretch * c - shear * s, stretch * s + shear * c
            return [dx, dy, y[3], dy * force[0] - dx * force[1]]

        return solve_ivp(slope, (0.0, length), start, method="DOP853", rtol=1e-9, atol=1e-11).y[
            :, -1
        ]

    def load(self, sag: float, guess: Array, from_winch: bool) -> tuple[float, Array, Array]:
        """The load at a vertical displacement of its point.

        Args:
            sag: how far the loaded point has come down.
            guess: (4,) reaction and angle at the foot, load.
            from_winch: the load points to the winch, else straight down.

        Returns:
            The load, the loaded point (2,), and what to guess next (4,).
        """
        at = np.zeros(2)

        def residual(u: Array) -> list[float]:
            inside = -u[:2]
            foot = np.array([0.0, 0.0, u[2], HINGE * (u[2] - 0.5 * np.pi)])
            corner = self.segment(foot, 1.0, inside)
            corner[2] -= 0.5 * np.pi
            middle = self.segment(corner, 0.2, inside)
            at[:] = middle[:2]
            to = np.array([0.2 - middle[0], 1.0 - BELOW - middle[1]])
            position = u[3] * (to / np.linalg.norm(to) if from_winch else np.array([0.0, -1.0]))
            end = self.segment(middle, 0.8, inside - position)
            return [end[0] - 1.0, end[1] - 1.0, end[3] + HINGE * end[2], middle[1] - 1.0 + sag]

        found = root(residual, guess, tol=1e-10)
        assert np.abs(found.fun).max() < 1e-8, "shooting has not found the frame's equilibrium"
        residual(found.x)
        return float(found.x[3]), at.copy(), found.x


def exact_path(sags: list[float], from_winch: bool) -> list[tuple[float, Array]]:
    """Loads and loaded points at growing vertical displacements, reached in small steps."""
    path, guess, before = [], np.array([0.3, 0.8, 0.5 * np.pi + 0.01, 0.5]), 0.004
    for sag in sags:
        for step in np.linspace(before, sag, 2 + int((sag - before) / 0.02))[1:]:
            load, point, guess = ExactFrame().load(float(step), guess, from_winch)
        path.append((load, point))
        before = sag
    return path


def exact_limit() -> float:
    """The first limit load, from a parabola through three loads near it."""
    sags = [0.39, 0.405, 0.42]
    loads = [load for load, _ in exact_path(sags, from_winch=False)]
    a, b, c = np.polyfit(sags, loads, 2)
    return float(c - b * b / (4.0 * a))


def carries(robot: Robot[BeamBody], load: float, start: State) -> State | None:
    """The equilibrium near a state under a dead load [E I / L²], None where the frame snaps through."""
    simulator = Simulator(robot.loaded(np.zeros(3), np.array([0.0, -load * EI, 0.0])), "none")
    simulator.start_from(start)
    report = simulator.settle(effort=[0.0], tolerance=1e-8, max_iterations=100)
    above = simulator.effector[0, 1] > 0.5  # beyond the limit the load comes to rest at 0.23 m
    return simulator.state if report.converged and above else None


def limit_load(robot: Robot[BeamBody]) -> float:
    """Largest dead load that the frame carries before it snaps through, by bisection [E I / L²]."""
    state = robot.rest()
    for load in (5.0, 10.0, 15.0, 18.0):
        found = carries(robot, load, state)
        assert found is not None, load
        state = found
    low, high = 18.0, 19.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        found = carries(robot, middle, state)
        if found is None:
            high = middle
        else:
            low, state = middle, found
    return low


@pytest.mark.slow
def test_first_limit_load_of_a_dead_force(tmp_path: Path) -> None:
    limits = np.array([limit_load(frame(tmp_path, count)) for count in (5, 10)])
    exact = exact_limit()
    assert limits[1] == pytest.approx(PUBLISHED, rel=0.01)
    errors = limits - exact
    assert errors[1] < 0.3 * errors[0], (
        "a halved element leaves at most about a quarter of the error"
    )
    assert limits[1] == pytest.approx(exact, rel=1e-4)


@pytest.mark.long
def test_cable_follows_the_frame_beyond_its_limit_load(tmp_path: Path) -> None:
    """A pulled length controls the displacement: the tension rises to the limit load and falls again.

    At a pull of 0.51 m the displacement itself turns back; the frame snaps and the cable, which only
    pulls, gets slack, wherever rounding leads the search on its way.
    """
    simulator = Simulator(frame(tmp_path, 40, winch=True), "none")
    efforts, points = [], []
    for position in (0.05, 0.2, 0.3, 0.38, 0.41, 0.45, 0.5):
        assert simulator.settle(position=[position], tolerance=1e-8).converged
        efforts.append(simulator.effort[0] / EI)
        points.append(simulator.effector[0, :2])
    assert max(efforts) == pytest.approx(PUBLISHED, rel=0.01)
    assert efforts[-1] < 0.85 * max(efforts)
    exact = exact_path([1.0 - float(point[1]) for point in points], from_winch=True)
    for effort, point, (load, place) in zip(efforts, points, exact, strict=True):
        assert effort == pytest.approx(load, rel=3e-3)
        np.testing.assert_allclose(point, place, atol=3e-3)
    before, snapped = (simulator.state, simulator.forces), []
    rounding = 1e-13 * np.random.default_rng(0).standard_normal((6, before[0].q.size))
    for position, change in zip(3 * [0.515, 0.53], rounding, strict=True):
        simulator.start_from(State(before[0].q * (1.0 + change), before[0].v), before[1])
        assert simulator.settle(position=[position], tolerance=1e-8).converged
        assert simulator.effort[0] == 0.0
        assert simulator.position[0] > 0.6
        snapped.append(simulator.effector[0])
    np.testing.assert_allclose(snapped, 6 * [snapped[0]], atol=1e-6)


def test_an_anchor_far_away_does_not_make_the_robot_larger(tmp_path: Path) -> None:
    """Steps of searches and tolerances of decisions are shares of the size."""
    assert frame(tmp_path, 5, winch=True).size == pytest.approx(np.sqrt(2.0), rel=1e-3)


@pytest.mark.parametrize(("stiffness", "stays"), [(1e3, True), (2.0, False)])
def test_a_soft_spring_in_the_cable_does_not_hold_the_frame_beyond_its_limit_load(
    tmp_path: Path, stiffness: float, stays: bool
) -> None:
    """There the tension falls by some 9 N/m: a winch without spring or with a stiff one holds the frame, one
    with a softer spring does not, though every force is in balance.
    """
    held = Simulator(frame(tmp_path, 20, winch=True), "none")
    for position in (0.2, 0.38, 0.45):
        assert held.settle(position=[position], tolerance=1e-8).converged
    sprung = Simulator(frame(tmp_path, 20, winch=True, spring=stiffness), "none")
    sprung.start_from(held.state, held.forces)
    report = sprung.settle(position=[0.45 + held.effort[0] / stiffness], tolerance=1e-8)
    moved = float(np.linalg.norm(sprung.effector[0] - held.effector[0]))
    assert (report.converged and moved < 1e-6) is stays
    assert stays or report.ending is Ending.BUCKLED or moved > 0.1
