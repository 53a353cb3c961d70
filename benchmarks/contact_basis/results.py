"""What `python -m benchmarks contact-basis` finds, as it goes into JSON."""

from __future__ import annotations

from dataclasses import dataclass

from tauten.service.process import HostInfo
from tauten.service.replay import Spread


@dataclass(frozen=True, slots=True)
class TrainingError:
    """One method with one k on the training path.

    Attributes:
        method, weighting, k: which modes.
        force: ‖S − Ψ B‖_F / ‖S‖_F over the weighted snapshots, B of the factorisation; for "energy",
            which has none, the best B ≥ 0.
        energy: √ of the lost share of the contact energy.
        max_mm, mean_mm: effector error of settled equilibria without enrichment; None when none settled.
        unsettled: equilibria that did not settle.
    """

    method: str
    weighting: str
    k: int
    force: float
    energy: float
    max_mm: float | None
    mean_mm: float | None
    unsettled: int


@dataclass(frozen=True, slots=True)
class HeldOutError:
    """The shipped basis on one path it was not made from, without or with enrichment.

    Attributes:
        path: its name.
        enriched: whether unit columns joined.
        stable_mm: how far a perturbation of 1e-6 moves the full-order run at most.
        stable: whether that is less than 0.1 % of the robot's size.
        max_mm, mean_mm: effector error; None when nothing settled.
        unsettled: equilibria that did not settle, those of the full-order run beside them.
        unsettled_full: equilibria at which the full-order run did not settle.
        extra_columns: largest number of unit columns in play.
    """

    path: str
    enriched: bool
    stable_mm: float
    stable: bool
    max_mm: float | None
    mean_mm: float | None
    unsettled: int
    unsettled_full: int
    extra_columns: int


@dataclass(frozen=True, slots=True)
class CertificateCost:
    """Time of checking all gaps in a control step that violates none, and of the whole step [ms]."""

    steps: int
    certificate_ms: Spread
    step_ms: Spread


@dataclass(frozen=True, slots=True)
class LcpCost:
    """One way of solving the full contact problems of recorded equilibria.

    Attributes:
        solver: its name.
        problems: how many.
        rows: (least, most) rows of one.
        time_ms: of a solution.
        residual_m: largest complementarity residual [m].
        solved: how many met 1e-9 m.
    """

    solver: str
    problems: int
    rows: tuple[int, int]
    time_ms: Spread
    residual_m: float
    solved: int


@dataclass(frozen=True, slots=True)
class Smoothness:
    """Effect of the regularisation of λ on the factorisation: relative error of HALS against k.

    Attributes:
        forces: how the forces of the same equilibria were found.
        errors: k to ‖S − Ψ B‖_F / ‖S‖_F.
        residual_m: largest complementarity residual of those forces [m].
    """

    forces: str
    errors: dict[int, float]
    residual_m: float


@dataclass(frozen=True, slots=True)
class ContactBasisBench:
    """Everything `python -m benchmarks contact-basis` measures; `complete` is False after Ctrl-C."""

    machine: HostInfo
    robot: str
    size_mm: float
    tolerance_mm: float
    basis: str
    campaign: str
    complete: bool
    training: tuple[TrainingError, ...]
    held_out: tuple[HeldOutError, ...]
    certificate: CertificateCost
    lcp: tuple[LcpCost, ...]
    smoothness: tuple[Smoothness, ...]
