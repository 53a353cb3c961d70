"""Whether an equilibrium is stable, and along which direction it is left where it is not.

With the exact tangent K (tensions included) and the rows H of cables and contacts that are taut or touch, an
equilibrium is stable where xᵀ K x > 0 for all x ≠ 0 with H x = 0. A held actuator with a spring in series
constrains nothing, its spring adds Hᵀ H / flexibility to K. Where K has a Cholesky factor nothing needs to
be computed. Otherwise the smallest eigenvalue of

    Pᵀ K P x = κ K₊ x,   P = I − K₊⁻¹ Hᵀ (H K₊⁻¹ Hᵀ)⁻¹ H                               (S1)

decides, by Lanczos iterations; K₊ is the positive definite tangent whose factors the last step left, so that
eigenvalues are clustered at one and negative ones stand apart. How the normals of contacts turn is left
out of K, so that `way_on` does not judge robots whose contacts push.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from tauten.model.numerics import Array, Bools
from tauten.model.robot import Robot
from tauten.model.simulation.equilibrium import Ending
from tauten.model.step import PredictedStep

NEGATIVE = -1e-6  # κ below this is unstable; rounding and the last movement are smaller
ACCURACY = 1e-3  # of κ
PUSHES = (0.02, -0.05)  # of the body, by which an unstable equilibrium is left
FEWEST = 3  # degrees of freedom with which Lanczos iterations start


def unstable_direction(robot: Robot, solved: PredictedStep, held: Bools) -> Array | None:
    """A direction (n,) in which a robot leaves an equilibrium, as long as a body; None for a stable one.

    Args:
        robot: its workspace has the factors of `solved`, which stay.
        solved: the last quasi-static step.
        held: (n_a,) which positions of actuators are held; taut cables among them are constraints.
    """
    step, layout = solved.step, solved.step.layout
    factorised = step.system.tangent
    if step.system.exact or factorised is None or robot.n < FEWEST:
        return None
    acting = solved.lam[layout.acting] > 0.0
    acting[: layout.n_a] = held & (acting[: layout.n_a] | step.laws.bilateral)
    springs = step.laws.springs
    flexibility = np.zeros(layout.n_a) if springs is None else springs.flexibility
    sprung = np.flatnonzero(acting[: layout.n_a] & (flexibility > 0.0))
    B = step.compliance.H[layout.n_e + sprung] / np.sqrt(flexibility[sprung])[:, None]  # (s, n)
    acting[sprung] = False
    taut = layout.n_e + np.flatnonzero(acting)
    effort = solved.effort
    h, system = step.system.h, step.system
    K = robot.body.matrix(robot.forces(step.state, effort, exact=True)[1])
    M = robot.body.matrix(factorised)
    H, X = step.compliance.H[taut], h * h * step.compliance.X[taut]  # rows, and (K₊⁻¹ Hᵀ)ᵀ
    W = H @ X.T
    inverse = np.linalg.pinv(W, rcond=1e-10) if len(taut) > 0 else W

    def allowed(x: Array) -> Array:
        return x - X.T @ (inverse @ (H @ x))

    def stiffness(x: Array) -> Array:
        moved = allowed(np.ravel(x))
        y = K @ moved + B.T @ (B @ moved)
        projected: Array = y - H.T @ (inverse @ (X @ y))
        return projected

    def solve(b: Array) -> Array:
        answer: Array = h * h * np.ravel(system.solve(np.ravel(b)[:, None]))
        return answer

    shape = (robot.n, robot.n)
    try:
        kappa, vectors = eigsh(
            LinearOperator(shape, matvec=stiffness, dtype=float), k=1, M=M, which="SA", tol=ACCURACY,
            Minv=LinearOperator(shape, matvec=solve, dtype=float),
            v0=np.random.default_rng(0).standard_normal(robot.n),
        )  # fmt: skip
    except ArpackError:
        return None
    if kappa[0] > NEGATIVE:
        return None
    direction = allowed(vectors[:, 0])
    scaled: Array = direction * (robot.size / robot.displacement(step.state, direction))
    return scaled


def way_on(
    robot: Robot, result: PredictedStep, held: Bools, pushed: int
) -> tuple[Ending, Array | None]:
    """How a converged search ends; a velocity (n,) [m/s] that leaves an unstable equilibrium, or None.

    Where it came back to one after all pushes, it is named. Where contacts push, nothing is judged: the
    tangent leaves out how their normals turn, which is what holds many robots that touch themselves.

    Args:
        robot: the robot.
        result: the last step of the search.
        held: (n_a,) which positions of actuators are held.
        pushed: how often it was pushed away before.
    """
    if result.contacts_push:
        return Ending.SETTLED, None
    direction = unstable_direction(robot, result, held)
    if direction is None:
        return Ending.SETTLED, None
    if pushed < len(PUSHES):
        return Ending.OUT_OF_ITERATIONS, PUSHES[pushed] * direction / result.step.system.h
    return Ending.BUCKLED, None
