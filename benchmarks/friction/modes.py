"""What modes that normal and tangential forces share are worth in contact with friction.

λ_n = Ψ β and λ_t = Ψ τ with |τ_j| ≤ μ β_j: since Ψ ≥ 0 the force of every candidate is in its cone, and the
modes are contacts with friction themselves. Measured on forward steps under the efforts of a pointwise
simulation: what modes alone lose, and what they save where unit columns join them as they join nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import thread_time

import numpy as np

from tauten.model import EmptySpace, Robot, Simulator, State, one_blas_thread
from tauten.model.friction import FrictionProblem, solve_friction
from tauten.model.load import make_robot, robot_path
from tauten.model.numerics import Array, Ints
from tauten.model.schema import Changes, read_toml
from tauten.model.step import Forces, condense_step
from tauten.reduction.contact import ContactBasis
from tauten.reduction.state import StateBasis, reduced_robot
from tauten.service.process import HostInfo, host_info

FRICTION = 0.5
STEPS, EVERY = 48, 3  # of a motion, and which of them are measured
DEPTH, PER_PAIR, ROUNDS = 1e-8, 2, 80  # m; as the simulator has candidates join
BUDGET = 100  # Newton steps of a solve
CASES = {  # position of each actuator where the motion is farthest [m]
    ("finger", "reduced"): (0.022,),
    ("finger", "full"): (0.022,),
    ("manipulator", "reduced"): (0.06, -0.03, -0.03, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
}


@dataclass(frozen=True, slots=True)
class SolvedInColumns:
    """A step solved in columns that join where candidates are too deep.

    Attributes:
        r: (3 m,) forces on all candidates [N].
        first: (3 m,) those before a unit column joined.
        columns: unit columns that joined.
        newton: Newton steps of all rounds.
        ms: time of the thread in the solver [ms].
    """

    r: Array
    first: Array
    columns: int
    newton: int
    ms: float


@dataclass(frozen=True, slots=True)
class SharedModesCase:
    """A robot with friction in a motion; medians over the measured steps in which a contact pushes.

    Attributes:
        robot: its name.
        order: "full" or "reduced", of its states.
        steps: measured steps with contact.
        modes: in range.
        pushing: candidates with a force.
        lost: effect of the contacts on the effectors that modes alone do not have, share of the effect.
        depth: of the deepest candidate with modes alone [m].
        natural: natural map of all candidates with modes alone [m].
        left: natural map of all candidates where unit columns joined the modes [m].
        columns: unit columns without and with modes.
        newton: Newton steps without and with modes.
        ms: time in the solver without and with modes [ms].
    """

    robot: str
    order: str
    steps: int
    modes: float
    pushing: float
    lost: float
    depth: float
    natural: float
    left: float
    columns: tuple[float, float]
    newton: tuple[float, float]
    ms: tuple[float, float]


@dataclass(frozen=True, slots=True)
class SharedModesBench:
    """All cases.

    Attributes:
        machine: facts about it.
        cases: one of each robot and order.
    """

    machine: HostInfo
    cases: tuple[SharedModesCase, ...]


@dataclass(frozen=True, slots=True)
class Candidates:
    """All candidates in range of a step under given efforts.

    Attributes:
        problem: three rows of each.
        effect: (n_e, 3 m) of their forces on the effectors.
        pair: (m,) contact pair of each.
        slots: (m,) slot of each.
    """

    problem: FrictionProblem
    effect: Array
    pair: Ints
    slots: Ints


def bench_shared_modes(progress: Callable[[float, str], None]) -> SharedModesBench:
    """All cases.

    Args:
        progress: called with the share of the work that has just been done, and what comes next.
    """
    cases = []
    with one_blas_thread():
        for (name, order), farthest in CASES.items():
            cases.append(shared_modes_case(name, order, np.array(farthest)))
            progress(1.0 / len(CASES), f"{name}, {order}")
    return SharedModesBench(host_info(), tuple(cases))


def shared_modes_case(
    name: str, order: str, farthest: Array, steps: int = STEPS
) -> SharedModesCase:
    """There and back in time steps with pointwise contact, of which some are solved again.

    Args:
        name: of a shipped robot with bases.
        order: "full" or "reduced".
        farthest: (n_a,) positions in the middle of the motion [m].
        steps: of the motion.
    """
    robot = with_friction(name, order)
    Psi, rows = ContactBasis.load(name).fitted(robot).Psi, []
    simulator = Simulator(robot, "full")
    simulator.settle_start()
    for i in range(1, steps + 1):
        state, forces = simulator.state, simulator.forces
        simulator.step(position=farthest * np.sin(np.pi * i / steps) ** 2)
        if i % EVERY == 0 and simulator.contacts.normal_force.any():
            rows.append(_compared(all_candidates(robot, state, forces, simulator.effort), Psi))
    medians = np.median(np.array(rows), axis=0)
    pushing, modes, lost, depth, natural, left = medians[:6]
    return SharedModesCase(
        name, order, len(rows), modes, pushing, lost, depth, natural, left,
        columns=(medians[6], medians[7]), newton=(medians[8], medians[9]), ms=(medians[10], medians[11]),
    )  # fmt: skip


def with_friction(name: str, order: str) -> Robot:
    """A shipped robot whose contacts have friction.

    Args:
        name: of a shipped robot with a state basis.
        order: "full" or "reduced".
    """
    path = robot_path(name)
    contents = read_toml(path)
    for contact in contents["contacts"]:
        contact["friction"] = FRICTION
    robot = make_robot(contents, path, Changes())
    return reduced_robot(robot, StateBasis.load(name)) if order == "reduced" else robot


def all_candidates(robot: Robot, state: State, forces: Forces, effort: Array) -> Candidates:
    """A step with the rows of every candidate in range.

    Args:
        robot: with friction.
        state: where the step starts.
        forces: of the step before.
        effort: (n_a,) of the actuators in this step.
    """
    step = condense_step(robot, EmptySpace(robot.n_c), state, forces, True, True)
    found = step.rows.contacts.found
    step = step.with_unit_columns(np.setdiff1d(np.arange(len(found)), step.extra))
    W, free, at = step.compliance.W, step.compliance.delta_free, step.layout
    c = slice(at.n_e + at.n_a, None)
    problem = FrictionProblem(
        W[c, c], free[c] + W[c, at.actuators] @ effort, found.friction[step.extra]
    )
    return Candidates(problem, W[at.effectors, c], found.pair[step.extra], found.slots[step.extra])


def joined(candidates: Candidates, Psi: Array) -> SolvedInColumns:
    """Solve in modes; unit columns of the deepest candidates join until none is too deep.

    Args:
        candidates: of a step.
        Psi: (m, k) modes on them; k = 0: pointwise contact.
    """
    problem, m = candidates.problem, len(candidates.pair)
    modes, used = np.kron(Psi, np.eye(3)), list[int]()
    r, first, newton, seconds = np.zeros(3 * m), np.zeros(3 * m), 0, 0.0
    for round_ in range(ROUNDS):
        B = np.hstack([modes, np.kron(np.eye(m)[:, used], np.eye(3))])  # (3 m, 3 (k + used))
        if B.shape[1] > 0:
            mu = np.full(B.shape[1] // 3, problem.mu[0])
            reduced = FrictionProblem(B.T @ problem.W @ B, B.T @ problem.q, mu)
            begin = thread_time()
            found = solve_friction(reduced, budget=BUDGET)
            seconds += thread_time() - begin
            newton += found.newton
            r = B @ found.r
        if round_ == 0:
            first = r
        gaps = (problem.W @ r + problem.q)[::3]
        gaps[used] = 0.0
        deepest = np.argsort(gaps)
        deep = deepest[gaps[deepest] < -DEPTH]
        if len(deep) == 0:
            break
        for pair in np.unique(candidates.pair[deep]):
            used.extend(deep[candidates.pair[deep] == pair][:PER_PAIR].tolist())
    return SolvedInColumns(r, first, len(used), newton, 1e3 * seconds)


def _compared(candidates: Candidates, Psi: Array) -> list[float]:
    """A row of `shared_modes_case`, whose attributes are its medians."""
    problem, on_them = candidates.problem, Psi[candidates.slots]
    on_them = on_them[:, on_them.any(axis=0)]
    plain = joined(candidates, np.zeros((len(on_them), 0)))
    modes = joined(candidates, on_them)
    effect = candidates.effect @ plain.r
    lost = float(np.linalg.norm(candidates.effect @ modes.first - effect) / np.linalg.norm(effect))
    deepest = float(-(problem.W @ modes.first + problem.q)[::3].min())
    return [
        *(float((plain.r[::3] > 0.0).sum()), float(on_them.shape[1]), lost, deepest),
        *(problem.error(modes.first), problem.error(modes.r), plain.columns, modes.columns),
        *(plain.newton, modes.newton, plain.ms, modes.ms),
    ]
