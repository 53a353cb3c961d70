"""Pinocchio's ADMM on problems of contact with friction, where Pinocchio (`pip install pin`) is installed.

The solver of Carpentier, Le Lidec and Montaut, From Compliant to Rigid Contact Simulation (RSS 2024).
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass

import numpy as np

from tauten.model.friction import FrictionProblem

TOLERANCE = 1e-10  # of feasibility and complementarity, relative to the largest |q|
ITERATIONS = 5000  # at most


@dataclass(frozen=True, slots=True)
class AdmmRun:
    """A problem as ADMM solves it from a cold start.

    Attributes:
        iterations: of ADMM.
        error: of the natural map, relative to the largest |q|.
        ms: time by its own clock [ms].
    """

    iterations: int
    error: float
    ms: float


def pinocchio_is_installed() -> bool:
    """Whether ADMM can run."""
    return importlib.util.find_spec("pinocchio") is not None


def admm(problem: FrictionProblem) -> AdmmRun:
    """Solve with ADMM.

    Args:
        problem: contacts with three rows each; Pinocchio has the normal last.
    """
    import pinocchio as pin

    count, largest = len(problem.mu), float(np.abs(problem.q).max())
    order = np.arange(3 * count).reshape(count, 3)[:, [1, 2, 0]].ravel()
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    models, data = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for mu in problem.mu:
        point = pin.PointContactConstraintModel(model, joint, pin.SE3.Identity())
        point.setFriction(float(mu))
        point.setCompliance(np.zeros(3))
        models.append(pin.ConstraintModel(point))
        data.append(models[len(models) - 1].createData())
    settings, found = pin.ADMMSolverSettings(), pin.ADMMSolverResult()
    settings.max_iterations, settings.solve_ncp, settings.measure_timings = ITERATIONS, True, True
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = TOLERANCE * largest
    settings.relative_feasibility_tol = settings.relative_complementarity_tol = TOLERANCE
    solver = pin.ADMMConstraintSolver(3 * count)
    delassus = pin.DelassusOperatorDense(np.ascontiguousarray(problem.W[order[:, None], order]))
    solver.solve(delassus, problem.q[order], models, data, settings, found)
    r = np.zeros(3 * count)
    r[order] = found.retrieveConstraintImpulses()
    return AdmmRun(found.iterations, problem.error(r) / largest, 1e-3 * solver.getElapsedTime())
