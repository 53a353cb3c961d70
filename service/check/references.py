"""What equilibria on a mesh are compared with: the best of other meshes, or their limit."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from tauten.model.numerics import Array
from tauten.service.check.mesh_variants import AnyElement, LoadedState, VariantStates

LEAST_ORDER, LARGEST_ORDER = 1.0, 4.0  # observed orders that are extrapolated with


@dataclass(frozen=True, slots=True)
class Reference:
    """What the answer of an exact mesh under a load is taken to be.

    Attributes:
        state: tensions, tips and contact force.
        source: how it was found: the meshes that were extrapolated, or the mesh.
        order: observed order of convergence of the tension where it was extrapolated, otherwise None.
    """

    state: LoadedState
    source: str
    order: float | None


def reference_state(
    found: tuple[VariantStates, ...], index: int, effort_name: str
) -> Reference | None:
    """The extrapolated limit of what shows an order over three refinements, the rest of the best mesh.

    That is the finest quadratic one, and of beams the finest.
    """
    if not found:
        return None
    own = found[0].variant.element
    settled = [item for item in found if len(item.states) > index and item.states[index].converged]
    settled.sort(key=lambda item: item.variant.refinements)
    levels = [item.states[index] for item in settled if item.variant.element == own][-3:]
    quadratic = [item for item in settled if item.variant.element == "quadratic"]
    better = (
        [item for item in settled if item.variant.refinements > 0] if own == "beam" else quadratic
    )
    finest = better[-1] if better and better[-1] is not found[0] else None
    if len(levels) == 3:
        extrapolated = extrapolated_state(levels, own, finest, index, effort_name)
        if extrapolated is not None:
            return extrapolated
    if finest is None:
        return None
    source = finest.variant.phrase
    if len(levels) == 3:
        source += f" ({own} meshes show no order of convergence)"
    return Reference(finest.states[index], source, None)


def sources_of(references: tuple[Reference | None, ...]) -> str:
    """How the references were found; "" without one. Of several ways that of most loads comes first."""
    counts = Counter(item.source for item in references if item is not None)
    first, *others = [source for source, _ in counts.most_common()] or [""]
    return f"{first}; under other loads {' or '.join(others)}" if others else first


def refined_references(
    found: tuple[VariantStates, ...], references: tuple[Reference | None, ...]
) -> tuple[Reference | None, ...]:
    """Smoothed elements on a refined mesh as references beside quadratic ones, which have as many nodes.

    Quadratic elements are too stiff and smoothed ones may be too soft: neither is nearer to the truth on
    every body. So the one that is farther from the robot's own mesh is what that is compared with. None where
    the references are extrapolated, or the robot has other elements.
    """
    smoothed = [item for item in found if item.variant.element == "smoothed"]
    extrapolated = any(item is not None and item.order is not None for item in references)
    if not smoothed or smoothed[0] is not found[0] or extrapolated:
        return ()
    finest = max(smoothed, key=lambda item: item.variant.refinements)
    if finest is found[0]:
        return ()
    phrase = finest.variant.phrase
    states = [item if item.converged else None for item in finest.states]
    states += [None] * (len(references) - len(states))
    return tuple(None if item is None else Reference(item, phrase, None) for item in states)


def extrapolated_state(
    levels: list[LoadedState],
    own: AnyElement,
    finest: VariantStates | None,
    index: int,
    effort_name: str,
) -> Reference | None:
    """Richardson extrapolation of three states, each on a mesh twice as fine as the one before.

    Args:
        levels: from coarse to fine.
        own: what their meshes are made of.
        finest: mesh from which quantities without an order of convergence are taken.
        index: of the load.
        effort_name: what the efforts are called.

    Returns:
        None where the effort has no order of convergence, or there is no such mesh where one is needed.
    """
    names = {"effort": effort_name, "tip": "tip", "contact_force": "contact force"}
    limits: dict[str, tuple[Array, float | None]] = {}
    for name in names:
        found = richardson(*(np.atleast_1d(getattr(state, name)) for state in levels))
        if found is not None:
            limits[name] = found
    missing = [text for name, text in names.items() if name not in limits]
    source = f"{own} meshes extrapolated"
    state = levels[-1]
    if missing:
        if finest is None or effort_name in missing:
            return None
        source += f" ({' and '.join(missing)}: {finest.variant.phrase})"
        state = finest.states[index]
    changed = {name: tuple(limit.tolist()) for name, (limit, _) in limits.items()}
    contact = changed.get("contact_force", (state.contact_force,))
    state = LoadedState(
        True, changed["effort"], changed.get("tip", state.tip), max(contact[0], 0.0)
    )
    return Reference(state, source, limits["effort"][1])


def richardson(coarse: Array, middle: Array, fine: Array) -> tuple[Array, float | None] | None:
    """The limit of a quantity on meshes of sizes 4 h, 2 h and h, with its observed order.

    The order is log2 |middle − coarse| / |fine − middle| (Roache 1994).

    Args:
        coarse: (m,) with size 4 h.
        middle: (m,) with size 2 h.
        fine: (m,) with size h.

    Returns:
        The limit (m,) and the order; no order where the quantity does not change any more. None where the
        order is not between `LEAST_ORDER` and `LARGEST_ORDER`.
    """
    first, second = float(np.linalg.norm(middle - coarse)), float(np.linalg.norm(fine - middle))
    if second <= 1e-9 * float(np.linalg.norm(fine)):
        return fine, None
    if not second * 2.0**LEAST_ORDER <= first <= second * 2.0**LARGEST_ORDER:
        return None
    ratio = first / second
    return fine + (fine - middle) / (ratio - 1.0), float(np.log2(ratio))
