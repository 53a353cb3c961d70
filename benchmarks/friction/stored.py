"""Stored inverse problems with Coulomb friction, and how they are solved."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tauten.controller.friction import (
    FrictionInverse,
    FrictionSettings,
    InverseSolution,
    solve_friction_inverse,
)
from tauten.controller.qpcc import Qpcc
from tauten.model.numerics import Array

WARM = FrictionSettings(warm=True, path_steps=25, forwards=1)


@dataclass(frozen=True, slots=True)
class StoredInverse:
    """A stored problem.

    Attributes:
        name: of its file.
        problem: to solve.
        lam: (n_a,) efforts before the step.
        forces: (3 k,) contact forces before the step.
        effectors: (n_e, n_a + 3 k) motion of the effectors by efforts and contact forces.
        weight: (n_e,) of the effectors' rows.
        held: objective of holding.
        best: lowest objective that is known.
    """

    name: str
    problem: FrictionInverse
    lam: Array
    forces: Array
    effectors: Array
    weight: Array
    held: float
    best: float

    @property
    def rank(self) -> int:
        """Rank of the contacts' compliance."""
        return int(np.linalg.matrix_rank(self.problem.program.M[:, len(self.lam) :], tol=1e-9))

    def excess(self, objective: float) -> float:
        """(f − f_best) / max(f_best, 0.01 f_hold)."""
        return (objective - self.best) / max(self.best, 0.01 * self.held)


def read_inverse(folder: Path) -> list[StoredInverse]:
    """The problems of a folder with `problems.csv`; see the README beside it."""
    with (folder / "problems.csv").open() as table:
        return [_read(folder, row) for row in csv.DictReader(table)]


def read_reduced(folder: Path, name: str, unknowns: int) -> StoredInverse:
    """A problem on the unknowns that move its effectors, actuators and contacts most; no best is known.

    Args:
        folder: of the problems.
        name: of the problem.
        unknowns: how many are left.
    """
    with (folder / "problems.csv").open() as table:
        row = next(row for row in csv.DictReader(table) if row["name"] == name)
    return _read(folder, row | {"f_hold": "nan", "f_best": "nan"}, unknowns)


def _read(folder: Path, row: dict[str, str], unknowns: int | None = None) -> StoredInverse:
    with np.load(folder / f"{row['name']}.npz") as data:
        G_e, G_a, G_c = data["G_e"], data["G_a"], data["G_c"]
        if unknowns is not None:
            _, _, modes = np.linalg.svd(np.concatenate([G_e, G_a, G_c]), full_matrices=False)
            G_e, G_a, G_c = (G @ modes[:unknowns].T for G in (G_e, G_a, G_c))
        weight, error = data["Q"], data["d0_e"] - data["target"]
        G = np.concatenate([G_a, G_c])
        E, n_a = G_e @ G.T, len(G_a)
        Q = (E.T * weight) @ E
        Q[:n_a, :n_a] += float(data["eps"]) * (G_a @ G_a.T)
        program = Qpcc(
            Q=Q,
            c=E.T @ (weight * error),
            lb=data["lam_min"],
            ub=data["lam_max"],
            G=G_a @ G.T,
            g_lo=data["delta_min"] - data["d0_a"],
            g_hi=data["delta_max"] - data["d0_a"],
            M=G_c @ G.T,
            m=data["d0_c"],
            constant=0.5 * float(weight @ error**2),
        )
        problem = FrictionInverse(program, data["mu"])
        start = data["lam_start"], data["r_start"]
        known = float(row["f_hold"]), float(row["f_best"])
        return StoredInverse(row["name"], problem, *start, E, weight, *known)


def solve_stored(stored: StoredInverse, settings: FrictionSettings) -> InverseSolution:
    """Solve a stored problem from what was before its step."""
    return solve_friction_inverse(stored.problem, stored.lam, stored.forces, settings)


def violation(stored: StoredInverse, found: InverseSolution) -> float:
    """By which an answer exceeds the limits at most, in their unit."""
    p = stored.problem.program
    rows = p.G @ np.concatenate([found.lam_a, found.forces])
    beyond = np.concatenate([rows - p.g_hi, p.g_lo - rows, found.lam_a - p.ub, p.lb - found.lam_a])
    return max(0.0, float(beyond.max()))
