"""How far equilibria on a mesh are from those on meshes that are finer or of higher order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.service.check.findings import Finding, Level, graded, worst
from tauten.service.check.mesh_variants import Load, LoadedState, Variant, VariantStates
from tauten.service.check.references import (
    Reference,
    reference_state,
    refined_references,
    sources_of,
)

MESH_ERROR = "error of the mesh"  # subject of a finding
FORCE = (0.03, 0.1)  # relative; from here on doubtful and wrong
TIP = (0.003, 0.01)  # of the robot's size
LEAST_FORCE = 0.25  # of the largest: smaller forces are compared with this


@dataclass(frozen=True, slots=True)
class LoadError:
    """Differences from the reference under one load; None where one of both was not found.

    Attributes:
        effort: difference of the tension that differs most, positive where the mesh is too stiff; relative
            to the largest tension of the reference, or to a quarter of its largest under any load.
        tip: largest difference of an effector's change since rest from that of the reference, in metres by
            the units of `EffectorLayout` [m].
        contact: relative difference of the contact force, as for tension; None where nothing touches.
    """

    effort: float | None
    tip: float | None
    contact: float | None


@dataclass(frozen=True, slots=True)
class VariantErrors:
    """Errors of one mesh.

    Attributes:
        variant: the mesh.
        nodes: its nodes.
        errors: one a load.
        effort, tip, contact: of greatest amount over all loads; None where there is none.
        unsettled: equilibria that were not found.
        level: fine, doubtful or wrong.
    """

    variant: Variant
    nodes: int
    errors: tuple[LoadError, ...]
    effort: float | None
    tip: float | None
    contact: float | None
    unsettled: int
    level: Level


@dataclass(frozen=True, slots=True)
class MeshErrorEstimate:
    """The error of a robot's mesh.

    Attributes:
        loads: what was compared.
        references: one a load; None where none was found.
        variants: errors of every mesh, the robot's own first.
        states: their equilibria.
        complete: whether all meshes were compared under all loads.
        verdict: one sentence.
        advice: what to change; "" where nothing is.
        effort_name: what the efforts are called, as tension or pressure.
    """

    loads: tuple[Load, ...]
    references: tuple[Reference | None, ...]
    variants: tuple[VariantErrors, ...]
    states: tuple[VariantStates, ...]
    complete: bool
    verdict: str
    advice: str
    effort_name: str

    @property
    def against(self) -> str:
        """How the references were found."""
        return sources_of(self.references)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """The verdict as a line among others, and a line for each mesh that could not be compared."""
        level = self.variants[0].level if self.variants else "doubtful"
        failed = [
            Finding("meshes to compare with", "doubtful", f"{item.variant.phrase}: {item.failure}")
            for item in self.states
            if item.failure
        ]
        return (Finding(MESH_ERROR, level, self.verdict, self.advice), *failed)


def estimate_error(
    loads: tuple[Load, ...],
    found: tuple[VariantStates, ...],
    size: float,
    complete: bool,
    effort_name: str,
) -> MeshErrorEstimate:
    """Compare meshes.

    Args:
        loads: the loads.
        found: equilibria of the meshes, the robot's own first.
        size: of the robot, which errors of the tip are compared with [m].
        complete: whether all meshes were compared under all loads.
        effort_name: what the efforts are called.
    """
    references = tuple(reference_state(found, index, effort_name) for index in range(len(loads)))
    variants = errors_against(references, found, size)
    refined = refined_references(found, references)
    if refined:
        others = errors_against(refined, found, size)
        if distance(others[0], size) > distance(variants[0], size):
            references, variants = refined, others
    verdict, advice = judged(variants, references, complete, effort_name)
    return MeshErrorEstimate(
        loads, references, variants, found, complete, verdict, advice, effort_name
    )


def errors_against(
    references: tuple[Reference | None, ...], found: tuple[VariantStates, ...], size: float
) -> tuple[VariantErrors, ...]:
    """Errors of every mesh.

    Args:
        references: one a load.
        found: equilibria of the meshes, the robot's own first.
        size: of the robot [m].
    """
    known = [item.state for item in references if item is not None]
    scales = tuple(
        max((value(state) for state in known), default=0.0)
        for value in (largest_effort, lambda state: state.contact_force)
    )
    return tuple(variant_errors(item, references, scales, size) for item in found)


def distance(errors: VariantErrors, size: float) -> float:
    """How far a mesh is from a reference, in parts of what is wrong; 0 where that is not known."""
    known = [(errors.effort, FORCE[1]), (errors.contact, FORCE[1]), (errors.tip, TIP[1] * size)]
    return max((abs(value) / scale for value, scale in known if value is not None), default=0.0)


def largest_effort(state: LoadedState) -> float:
    """The largest magnitude of the efforts of a state."""
    return max((abs(effort) for effort in state.effort), default=0.0)


def variant_errors(
    found: VariantStates,
    references: tuple[Reference | None, ...],
    scales: tuple[float, ...],
    size: float,
) -> VariantErrors:
    """Errors of one mesh.

    Args:
        found: its equilibria.
        references: one a load.
        scales: largest tension and contact force of the references [N].
        size: of the robot [m].
    """
    errors = tuple(
        load_error(state, None if reference is None else reference.state, scales)
        for state, reference in zip(found.states, references, strict=False)
    )
    effort, tip, contact = (
        max((getattr(item, name) for item in errors if getattr(item, name) is not None),
            key=abs, default=None)
        for name in ("effort", "tip", "contact")
    )  # fmt: skip
    levels = [graded(abs(value), *FORCE) for value in (effort, contact) if value is not None]
    levels += [] if tip is None else [graded(tip / size, *TIP)]
    unsettled = sum(not state.converged for state in found.states)
    level: Level = "wrong" if unsettled else "doubtful"
    if levels and not unsettled:
        level = worst(tuple(Finding("", item, "") for item in levels))
    return VariantErrors(found.variant, found.nodes, errors, effort, tip, contact, unsettled, level)


def load_error(
    state: LoadedState, reference: LoadedState | None, scales: tuple[float, ...]
) -> LoadError:
    """Differences of a state from the reference.

    Args:
        state: on a mesh.
        reference: under the same load.
        scales: largest tension and contact force of the references [N].
    """
    if reference is None or not state.converged:
        return LoadError(None, None, None)
    change = np.subtract(state.effort, reference.effort) * np.where(
        np.asarray(reference.effort) < 0.0, -1.0, 1.0
    )  # (n_a,) positive where this mesh resists more
    most = max(largest_effort(reference), LEAST_FORCE * scales[0], 1e-9)
    tips = np.subtract(state.tip, reference.tip).reshape(-1, 3)
    contact = None
    if scales[1] > 0.0:
        pushing = max(reference.contact_force, LEAST_FORCE * scales[1])
        contact = (state.contact_force - reference.contact_force) / pushing
    return LoadError(
        effort=float(change[np.abs(change).argmax()] / most),
        tip=float(np.linalg.norm(tips, axis=1).max()),
        contact=contact,
    )


def judged(
    variants: tuple[VariantErrors, ...],
    references: tuple[Reference | None, ...],
    complete: bool,
    effort_name: str,
) -> tuple[str, str]:
    """The verdict on the first mesh, and what to change."""
    sources = sources_of(references)
    if not variants or variants[0].effort is None or not sources:
        if not complete:
            return "stopped before a better mesh was compared", ""
        return (
            "under no load an equilibrium was found both on this mesh and on a better one",
            "smaller --share, or more --refinements",
        )
    own = variants[0]
    stiff = {"fine": "fine", "doubtful": "not accurate", "wrong": "wrong"}[own.level]
    if own.level != "fine" and own.effort is not None and own.effort > FORCE[0]:
        stiff = "too stiff"
    sentence = f"{own.variant.phrase} are {stiff}: {listed(own, effort_name)}, against {sources}"
    if own.level == "fine":
        return sentence, ""
    others = [item for item in variants[1:] if item.effort is not None and item.level == "fine"]
    if not others:
        return sentence, "refine the mesh where strain is large" + better_element(
            variants, effort_name
        )
    best = min(others, key=lambda item: (item.variant.relative_cost, item.nodes))
    advice = f"set mesh.element = {best.variant.element!r}"
    if best.variant.element == own.variant.element:
        advice = "refine the mesh"
    elif best.variant.refinements:
        advice += " and refine the mesh"
    phrase = best.variant.phrase
    if best.effort == 0.0 and any(item and item.source.startswith(phrase) for item in references):
        return sentence, f"{advice} (the reference itself; --refinements 2 measures its error)"
    return sentence, f"{advice} ({listed(best, effort_name)})"


def better_element(variants: tuple[VariantErrors, ...], effort_name: str) -> str:
    """What other elements on the mesh of the file leave of the error, "" where that is not half as much."""
    efforts = {item: abs(item.effort) for item in variants if item.effort is not None}
    same = [item for item in efforts if item.variant.refinements == 0]
    best = min(same, key=lambda item: efforts[item])
    if 2.0 * efforts[best] > efforts[variants[0]]:
        return ""
    return f"; mesh.element = {best.variant.element!r} alone leaves {listed(best, effort_name)}"


def listed(errors: VariantErrors, effort_name: str) -> str:
    """The largest errors of a mesh in words."""
    parts = errors_in_words(errors.effort, errors.tip, errors.contact, effort_name)
    if errors.unsettled:
        parts.append(f"{errors.unsettled} of {len(errors.errors)} equilibria not found")
    return ", ".join(parts)


def errors_in_words(
    effort: float | None, tip: float | None, contact: float | None, effort_name: str
) -> list[str]:
    """Those errors that are known; arguments as the attributes of `VariantErrors`.

    Args:
        effort: relative.
        tip: [m].
        contact: relative.
        effort_name: what the effort is called.
    """
    known = (
        (effort_name, effort, "{:+.1f} %", 1e2),
        ("tip", tip, "{:.2f} mm", 1e3),
        ("contact force", contact, "{:+.1f} %", 1e2),
    )
    return [
        f"{name} {text.format(scale * value)}"
        for name, value, text, scale in known
        if value is not None
    ]
