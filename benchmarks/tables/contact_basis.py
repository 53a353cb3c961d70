"""The numbers of `python -m benchmarks contact-basis` as tables, for the terminal and for the docs."""

from __future__ import annotations

from benchmarks.contact_basis import ContactBasisBench, HeldOutError, TrainingError
from tauten.service.tables import Numbers, Page


def contact_basis_page(result: ContactBasisBench) -> Page:
    """Setting, tables and the certificate's cost."""
    parts = (
        _against_k(result, "force", "Force error ‖S − ΨB‖ / ‖S‖ against k"),
        _against_k(result, "energy", "√ of the contact energy lost against k"),
        _against_k(
            result, "max_mm",
            "Largest tip error in mm against k, training path, no enrichment (equilibria not settled)",
        ),
        _against_k(result, "mean_mm", "Mean tip error in mm against k, the same"),
        _held_out(result),
        _lcp(result),
        _smoothness(result),
        certificate(result),
    )  # fmt: skip
    return Page("python -m benchmarks contact-basis", setting(result), parts)


def setting(result: ContactBasisBench) -> str:
    """What was measured on what."""
    facts = result.machine
    ended = "" if result.complete else " Ended early: what is missing was not measured."
    return (
        f"Robot {result.robot}; training path: {result.campaign}; basis of the held-out paths: "
        f"{result.basis}. {facts.processor}, {facts.cores} cores, BLAS on one thread, load "
        f"{facts.load:.1f}.{ended}"
    )


def certificate(result: ContactBasisBench) -> str:
    """Times of checking all gaps."""
    cost = result.certificate
    if not cost.certificate_ms.p50 or not cost.step_ms.p50:
        return "Certificate: no control step without violation."
    share = cost.certificate_ms.p50 / cost.step_ms.p50
    return (
        f"Certificate, over {cost.steps} control steps that violate nothing: "
        f"{cost.certificate_ms.p50:.3f} ms of {cost.step_ms.p50:.2f} ms (medians), {share:.1%}."
    )


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}" if value < 10.0 else f"{value:.1f}"


def by_method(result: ContactBasisBench) -> dict[str, list[TrainingError]]:
    """Errors on the training path by the method's name, with its weighting where that is not equal."""
    found: dict[str, list[TrainingError]] = {}
    for error in result.training:
        name = error.method if error.weighting == "equal" else f"{error.method}, {error.weighting}"
        found.setdefault(name, []).append(error)
    return found


def _against_k(result: ContactBasisBench, what: str, title: str) -> Numbers:
    ks = sorted({error.k for error in result.training})
    body = []
    for name, errors in by_method(result).items():
        cells = {error.k: _number(getattr(error, what)) for error in errors}
        if what.endswith("mm"):
            late = {error.k: f" ({error.unsettled})" for error in errors if error.unsettled}
            cells = {k: cell + late.get(k, "") for k, cell in cells.items()}
        body.append((name, *(cells.get(k, "") for k in ks)))
    return Numbers(title, ("method", *map(str, ks)), tuple(body))


def pairs_of(result: ContactBasisBench) -> list[tuple[HeldOutError, HeldOutError]]:
    """Without and with enrichment, path by path."""
    bare = [error for error in result.held_out if not error.enriched]
    rich = {error.path: error for error in result.held_out if error.enriched}
    return [(error, rich[error.path]) for error in bare if error.path in rich]


def _held_out(result: ContactBasisBench) -> Numbers:
    columns = (
        "path", "perturbed", "without: mean", "max", "unsettled", "enriched: mean", "max",
        "unsettled", "extra columns", "full unsettled",
    )  # fmt: skip
    body = [
        (
            bare.path, f"{bare.stable_mm:.4f}" + ("" if bare.stable else " unstable"),
            _number(bare.mean_mm), _number(bare.max_mm), str(bare.unsettled),
            _number(rich.mean_mm), _number(rich.max_mm), str(rich.unsettled),
            str(rich.extra_columns), str(rich.unsettled_full),
        )
        for bare, rich in pairs_of(result)
    ]  # fmt: skip
    title = f"Tip error in mm on held-out paths, {result.basis}; full-order run perturbed by 1e-6"
    return Numbers(title, columns, tuple(body))


def _lcp(result: ContactBasisBench) -> Numbers:
    columns = (
        "solver", "problems", "rows", "median, ms", "p99, ms", "worst residual, m", "to 1e-9 m",
    )  # fmt: skip
    body = [
        (
            cost.solver, str(cost.problems), f"{cost.rows[0]} to {cost.rows[1]}",
            _number(cost.time_ms.p50), _number(cost.time_ms.p99), f"{cost.residual_m:.1e}",
            f"{cost.solved} of {cost.problems}",
        )
        for cost in result.lcp
    ]  # fmt: skip
    return Numbers("Full contact problems of the training path, from zero", columns, tuple(body))


def _smoothness(result: ContactBasisBench) -> Numbers:
    ks = sorted({k for row in result.smoothness for k in row.errors})
    columns = ("forces", *(f"k = {k}" for k in ks), "worst residual, m")
    body = [
        (row.forces, *(_number(row.errors.get(k)) for k in ks), f"{row.residual_m:.1e}")
        for row in result.smoothness
    ]
    title = "HALS error of the same equilibria's forces, by how the forces were found"
    return Numbers(title, columns, tuple(body))
