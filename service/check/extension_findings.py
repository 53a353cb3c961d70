"""Whether derivatives that functions of other packages give are those of their values."""

from __future__ import annotations

from collections.abc import Container, Iterator

import numpy as np

from tauten.model import Robot, is_own
from tauten.model.actuators import ActuatorSet
from tauten.model.numerics import Array
from tauten.service.check.findings import Finding, graded, worst

DIRECTIONS = 4  # in which derivatives are compared
MOVED = 1e-3  # of the robot's size, by which points are off their places at rest, where there may be a kink
STEP = 1e-4  # of the robot's size, of the differences
DOUBTFUL, WRONG = 0.01, 0.1  # relative error of a derivative


def extension_findings(robot: Robot, of_parts: Container[str] | None = None) -> Iterator[Finding]:
    """Derivatives of transmissions, of effectors of kind function, and of shapes of obstacles.

    Args:
        robot: the robot.
        of_parts: names of the obstacles of the file of a robot of parts, which alone are compared; None: it
            is a robot without parts.

    Raises:
        ExtensionError: a function fails.
    """
    errors = [
        (f"normals of {name}", error)
        for name, error in shape_errors(robot)
        if of_parts is None or name in of_parts
    ]
    if of_parts is None:
        errors = [*actuator_errors(robot), *effector_errors(robot), *errors]
    subject = "derivatives of extensions"
    lines = [Finding(subject, graded(error, DOUBTFUL, WRONG), name) for name, error in errors]
    if lines and worst(tuple(lines)) == "fine":
        largest = max(error for _, error in errors)
        names = ", ".join(name for name, _ in errors)
        yield Finding(subject, "fine", f"{names}: within {largest:.1g} of those by differences")
        return
    for line, (name, error) in zip(lines, errors, strict=True):
        if line.level != "fine":
            found = f"{name} is {100.0 * error:.3g} % off that by differences of the values"
            advice = "correct what the function returns: signs, units and the order of points"
            yield Finding(subject, line.level, found, advice)


def actuator_errors(robot: Robot) -> Iterator[tuple[str, float]]:
    """Relative errors of the first derivative of each transmission, and of the second where it has one."""
    actuators = robot.actuator_set
    functions = actuators.transmissions if isinstance(actuators, ActuatorSet) else None
    if functions is None:
        return
    y = near(robot, robot.motion(robot.rest()).placed(functions.points).y)
    here, step, ways = functions.at(y), STEP * robot.size, directions(len(y))
    ends = [(functions.at(y + step * d), functions.at(y - step * d)) for d in ways]
    for i, name in enumerate(functions.names):
        one, own = here[i], slice(functions.starts[i], functions.starts[i + 1])
        changes = [(up[i], down[i]) for up, down in ends]
        slopes = [(up.value - down.value) / (2.0 * step) for up, down in changes]
        expected = [np.vdot(one.gradient, d[own]) for d in ways]
        yield f"gradient of {name}", relative_error(np.array(expected), np.array(slopes))
        if one.curvature is not None:
            bends = [(up.gradient - down.gradient).ravel() / (2.0 * step) for up, down in changes]
            turned = [one.curvature @ d[own].ravel() for d in ways]
            yield f"curvature of {name}", relative_error(np.array(turned), np.array(bends))


def effector_errors(robot: Robot) -> Iterator[tuple[str, float]]:
    """Relative errors of the derivatives of effectors of kind function."""
    effectors = robot.effectors
    added = [i for i, kind in enumerate(effectors.layout.kinds) if kind == "function"]
    if not added:
        return
    y = near(robot, robot.motion(robot.rest()).placed(effectors.points).y)
    here, step, ways = effectors.measured(y), STEP * robot.size, directions(len(y))
    ends = [(effectors.measured(y + step * d), effectors.measured(y - step * d)) for d in ways]
    for i in added:
        own = slice(effectors.starts[i], effectors.starts[i + 1])
        slopes = [(up[i].delta[0] - down[i].delta[0]) / (2.0 * step) for up, down in ends]
        expected = [np.vdot(here[i].gradient, d[own]) for d in ways]
        name = effectors.layout.names[i]
        yield f"gradient of {name}", relative_error(np.array(expected), np.array(slopes))


def shape_errors(robot: Robot) -> Iterator[tuple[str, float]]:
    """Names of obstacles whose shape is of another package, and errors of normals of the median candidate."""
    places = robot.motion(robot.rest()).placed(robot.vertices).y
    for pair in robot.contacts.pairs:
        obstacle = pair.obstacle
        if obstacle is None or is_own(obstacle.shape):
            continue
        points = np.einsum("mk,mkd->md", pair.weights, places[pair.nodes])  # (m, 3)
        y = near(robot, (points - obstacle.start.position) @ obstacle.start.Q)
        normal, step, errors = obstacle.closest_own(y, np.inf)[1], STEP * robot.size, []
        for d in directions(len(y)):
            gaps = [obstacle.closest_own(y + by * d, np.inf)[0] for by in (step, -step)]
            slope = (gaps[0] - gaps[1]) / (2.0 * step)  # (m,)
            errors.append(np.abs((normal * d).sum(axis=1) - slope))
        # a few are where two sides of a shape are as near
        yield obstacle.name, float(np.median(errors))


def near(robot: Robot, y: Array) -> Array:
    """Places (p, 3) beside y (p, 3) [m], the same each time."""
    moved: Array = y + MOVED * robot.size * np.random.default_rng(0).normal(size=y.shape)
    return moved


def directions(p: int) -> list[Array]:
    """Directions (p, 3) of p points, of about length 1 each, the same each time."""
    rng = np.random.default_rng(1)
    return [rng.normal(size=(p, 3)) for _ in range(DIRECTIONS)]


def relative_error(expected: Array, found: Array) -> float:
    """The largest difference over the largest of both; infinite where one is not known."""
    size = max(np.abs(expected).max(), np.abs(found).max())
    error = np.abs(expected - found).max()
    if not np.isfinite(error):
        return np.inf
    return float(error / size) if size > 0.0 else 0.0
