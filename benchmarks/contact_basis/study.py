"""`python -m benchmarks contact-basis`: errors of contact bases on and off their training path."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TypeVar

import numpy as np

from benchmarks.contact_basis.gauss_seidel import solve_pgs
from benchmarks.contact_basis.held_out import held_out_design, sensitivity
from benchmarks.contact_basis.results import (
    CertificateCost,
    ContactBasisBench,
    HeldOutError,
    LcpCost,
    Smoothness,
    TrainingError,
)
from tauten.controller import Controller, ControllerSettings, decide, prepare
from tauten.model import Enrichment, Robot, default_enrichment, one_blas_thread, worst_rows
from tauten.model.numerics import (
    Array,
    LcpResult,
    complementarity,
    distances,
    solve_lcp,
)
from tauten.reduction import ContactBasis
from tauten.reduction.campaign import Design, Snapshots, run_campaign
from tauten.reduction.contact import (
    BasisMethod,
    ContactProblem,
    ReduceSettings,
    Weighting,
    contact_problems,
    factorise_each,
    fit_each,
    provenance,
    quality,
    snapshot_weights,
    tip_errors,
)
from tauten.service.plant import PathSettings, make_path
from tauten.service.process import Progress, StopFlag, host_info
from tauten.service.replay import spread

KS = (2, 5, 10, 15, 20, 25, 30, 40, 60)
METHODS: tuple[tuple[BasisMethod, Weighting], ...] = (
    ("energy", "equal"), ("hals", "equal"), ("hals-nndsvd", "equal"), ("greedy", "equal"),
    ("als", "equal"), ("als", "force"),
)  # fmt: skip
SMOOTHNESS = (1e-9, 1e-6, 1e-4, 1e-2)
_SWEEPS = 200  # of Gauss-Seidel, what a step may take
STABLE = 1e-3  # of the robot's size: farther apart, and the full-order run is no measure

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class ContactBasisInputs:
    """What is measured.

    Attributes:
        robot: the robot.
        basis: its contact basis.
        snapshots: converged ones of the training path.
        folder: of the held-out campaigns; campaigns in it are not run again.
        equilibria: of the training path, to settle for each basis.
        steps: of a held-out path.
        ks: numbers of modes.
        controller: settings of the controller whose certificate is timed; None: defaults.
    """

    robot: Robot
    basis: ContactBasis
    snapshots: Snapshots
    folder: Path
    equilibria: int
    steps: int
    ks: tuple[int, ...] = KS
    controller: ControllerSettings | None = None


def bench_contact_basis(
    inputs: ContactBasisInputs, stop: StopFlag, progress: Progress
) -> ContactBasisBench:
    """Measure; when `stop` is raised, the results so far.

    Args:
        inputs: what is measured.
        stop: read after each basis and path.
        progress: called with the share of the work just done and what comes next.
    """
    robot = inputs.robot
    progress(0.0, "certificate, LCP")
    with one_blas_thread():
        problems = contact_problems(robot, inputs.snapshots)
        certificate = certificate_cost(robot, inputs.basis, inputs.controller)
        lcp = lcp_costs(problems[:: max(1, len(problems) // 8)])
        smoothness = smoothness_of(problems)
        progress(0.1, "bases on the training path")
        training = training_errors(inputs, problems)
        trained = _until(training, stop, lambda: progress(0.45 / 54, "bases on the training path"))
        held_out = held_out_errors(inputs)
        checked = _until(held_out, stop, lambda: progress(0.45 / 36, "held-out paths"))
    origin = inputs.basis.provenance
    return ContactBasisBench(
        machine=host_info(),
        robot=robot.name,
        size_mm=1e3 * robot.size,
        tolerance_mm=1e3 * robot.tolerance,
        basis=f"{origin.method}, k = {origin.k}",
        campaign=inputs.snapshots.origin.campaign,
        complete=not stop.requested,
        training=trained,
        held_out=checked,
        certificate=certificate,
        lcp=lcp,
        smoothness=smoothness,
    )


def _until(results: Iterable[R], stop: StopFlag, done: Callable[[], None]) -> tuple[R, ...]:
    """The results until `stop` is raised."""
    found: list[R] = []
    remaining = iter(results)
    while not stop.requested and (result := next(remaining, None)) is not None:
        found.append(result)
        done()
    return tuple(found)


def training_errors(
    inputs: ContactBasisInputs, problems: tuple[ContactProblem, ...]
) -> Iterator[TrainingError]:
    """Every method with every k, on some equilibria of the path the modes were made from."""
    robot, snapshots = inputs.robot, inputs.snapshots
    chosen = np.linspace(0, len(snapshots) - 1, inputs.equilibria).round().astype(np.int64)
    some = snapshots.select(chosen)
    rank = int(np.linalg.matrix_rank(snapshots.lam))
    for method, weighting in METHODS:
        S = snapshots.lam * snapshot_weights(snapshots.lam, weighting)
        for fit in fit_each(S, problems, [k for k in inputs.ks if k <= rank], method):
            found = quality(fit.Psi, problems)
            settings = ReduceSettings(k=max(fit.k, 1), method=method, weighting=weighting)
            basis = ContactBasis(fit.Psi, provenance(robot, snapshots, settings, fit, found))
            force = fit.error
            if method == "energy":
                force = float(np.linalg.norm(distances(fit.Psi, S)) / np.linalg.norm(S))
            errors = _tip_errors(robot, some, basis, None)
            yield TrainingError(method, weighting, fit.requested, force, found.energy, *errors[:3])


def held_out_errors(inputs: ContactBasisInputs) -> Iterator[HeldOutError]:
    """The basis on paths with other gravity, with forces on the effectors, and released."""
    robot = inputs.robot
    design, names = held_out_design(robot, inputs.steps)
    usual = default_enrichment(robot.tolerance)
    for index, name in enumerate(names):
        folder = inputs.folder / f"held-out-{inputs.steps}" / f"{index:02d}"
        alone = Design(f"{design.description}, {name}", (design.runs[index],))
        path = run_campaign(robot, alone, folder)
        apart = float(np.nanmax(sensitivity(robot, path), initial=0.0))
        for enrichment in (None, usual):
            largest, mean, unsettled, extra = _tip_errors(robot, path, inputs.basis, enrichment)
            yield HeldOutError(
                path=name,
                enriched=enrichment is not None,
                stable_mm=1e3 * apart,
                stable=apart < STABLE * robot.size,
                max_mm=largest,
                mean_mm=mean,
                unsettled=unsettled,
                unsettled_full=int((~path.converged).sum()),
                extra_columns=extra,
            )


def _tip_errors(
    robot: Robot, path: Snapshots, basis: ContactBasis, enrichment: Enrichment | None
) -> tuple[float | None, float | None, int, int]:
    """Largest and mean effector error [mm], equilibria that did not settle, most extra columns."""
    found = tip_errors(robot, path, basis, enrichment)
    errors = 1e3 * found.error[~np.isnan(found.error)]
    unsettled = int((~found.converged).sum())
    if len(errors) == 0:
        return None, None, unsettled, 0
    extra = int(found.extra_columns.max(initial=0.0))
    return float(errors.max()), float(errors.mean()), unsettled, extra


def certificate_cost(
    robot: Robot, basis: ContactBasis, control: ControllerSettings | None, seconds: float = 4.0
) -> CertificateCost:
    """Follow what the cables reach and measure the time of the certificate where no gap is too deep.

    Args:
        robot: the robot.
        basis: its contact basis.
        control: settings of the controller; None: defaults.
        seconds: duration of the path.
    """
    controller = Controller(robot, basis, settings=control)
    path = make_path("reach", robot, PathSettings(period=seconds, fraction=0.9))
    settings = controller.settings
    robot, state, forces, position = (
        controller.robot,
        controller.state,
        controller.forces,
        controller.position,
    )
    steps, checks = [], []
    for time in np.arange(0.0, seconds, robot.h):
        start = perf_counter()
        prepared = prepare(controller.horizon, basis, state, forces, position, settings.enrichment)
        decision = decide(robot, prepared, path.at(time).ravel(), position, settings)
        predicted, position = decision.predicted, decision.position
        step = predicted.step
        state = robot.advance(step.state, step.system.v + predicted.dv, step.system.h)
        end = perf_counter()
        if len(step.extra) == 0 and time > 0.2:  # the first ones warm up
            gaps = step.rows.contacts.rows.after(step.system.h, step.system.v + predicted.dv)
            worst_rows(step.rows.contacts, gaps, settings.enrichment, step.extra)
            steps.append(1e3 * (end - start))
            checks.append(1e3 * (perf_counter() - end))
        forces = step.split(predicted.lam, basis.k)
    return CertificateCost(len(steps), spread(checks), spread(steps))


def lcp_costs(problems: tuple[ContactProblem, ...]) -> tuple[LcpCost, ...]:
    """The active set against Gauss-Seidel, from zero forces, on full contact problems."""
    solvers: dict[str, Callable[[Array, Array], LcpResult]] = {
        "active set": lambda W, delta: solve_lcp(W, delta),
        "Gauss-Seidel": lambda W, delta: solve_pgs(W, delta),
    }
    costs = []
    sizes = [len(problem.delta) for problem in problems]
    for name, solve in solvers.items():
        solve(problems[0].W, problems[0].delta)  # compiled
        times, results = [], []
        for problem in problems:
            start = perf_counter()
            results.append(solve(problem.W, problem.delta))
            times.append(1e3 * (perf_counter() - start))
        worst = max(result.residual for result in results)
        solved = sum(result.converged for result in results)
        rows = (min(sizes), max(sizes))
        costs.append(LcpCost(name, len(problems), rows, spread(times), worst, solved))
    return tuple(costs)


def smoothness_of(problems: tuple[ContactProblem, ...]) -> tuple[Smoothness, ...]:
    """How well forces of the same equilibria factor, found with more and more regularisation."""
    n_c = 1 + max(int(problem.slots.max()) for problem in problems)
    found = []
    for rho in (None, *SMOOTHNESS):
        S, residual = np.zeros((n_c, len(problems))), 0.0
        for j, problem in enumerate(problems):
            W, delta = problem.W, problem.delta
            result = (
                solve_pgs(W, delta, max_sweeps=_SWEEPS)
                if rho is None
                else solve_lcp(W, delta, rho=rho)
            )
            S[problem.slots, j] = result.lam
            gaps = delta + W @ result.lam
            residual = max(residual, complementarity(W, result.lam, gaps))
        S *= snapshot_weights(S, "equal")
        rank = int(np.linalg.matrix_rank(S))
        ks = [k for k in (5, 10, 20) if k <= rank]
        errors = {fit.k: fit.error for fit in factorise_each(S, ks)}
        name = f"Gauss-Seidel, {_SWEEPS} sweeps" if rho is None else f"active set, ρ = {rho:.0e}"
        found.append(Smoothness(name, errors, residual))
    return tuple(found)
