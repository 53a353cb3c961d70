"""Where the numbers of each part are among those of all parts, and what the parts assemble."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from tauten.model.body import Body
from tauten.model.numerics import Array
from tauten.model.parts.motion import slices
from tauten.model.state import Assembled, Augmentation, State, StepStart
from tauten.model.system import Integration


@dataclass(frozen=True, slots=True)
class Spans:
    """Where each part's numbers are among those of all parts.

    Attributes:
        columns: unknowns.
        configuration: numbers in `State.q`, and
        memory: in `State.memory`.
        stored: values of a matrix as bodies store them.
        shapes: of these.
    """

    columns: tuple[slice, ...]
    configuration: tuple[slice, ...]
    memory: tuple[slice, ...]
    stored: tuple[slice, ...]
    shapes: tuple[tuple[int, ...], ...]


def spans_of(bodies: Sequence[Body[Any]]) -> Spans:
    """Where the numbers of some bodies are, one after the other."""
    rest = [body.rest() for body in bodies]
    shapes = tuple(body.stored_shape for body in bodies)
    return Spans(
        columns=slices([body.n for body in bodies]),
        configuration=slices([len(state.q) for state in rest]),
        memory=slices([len(state.memory) for state in rest]),
        stored=slices([int(np.prod(shape)) for shape in shapes]),
        shapes=shapes,
    )


@lru_cache(maxsize=256)
def scheme_of_part(
    own: Integration, whole: Integration, given: Integration, ahead: float, floats: bool
) -> Integration:
    """The scheme of a part in a step of all parts.

    A part is static or dynamic as its file says, unless the step asks for another scheme than the robot's.

    Args:
        own: of the part.
        whole: of the robot.
        given: of the step.
        ahead: of the part in it, see `Integration`.
        floats: whether nothing holds a body of the part, whose velocity leads it in static steps too.
    """
    static = own.static if given.static == whole.static else given.static
    return dataclasses.replace(
        own,
        rate=given.rate,
        static=static,
        semidefinite=given.semidefinite,
        ahead=0.0 if static and not floats else ahead,
    )


def start_of_part(body: Body[Any], state: State) -> StepStart:
    """The start of a part in a step that is iterated, with its mass as the body stores a matrix."""
    start, mass = body.step_start(state), np.zeros(body.stored_shape)
    body.add_mass(mass, start.mass)
    return dataclasses.replace(start, mass=mass)


def advanced(body: Body[Any], state: State, v: Array, h: float, straight: bool) -> State:
    """The state of a part one step later: where steps are static, what does not float stands still.

    Args:
        body: of the part.
        state: before the step.
        v: (n,) velocity after it [m/s].
        h: its length [s].
        straight: see `Body.advance`.
    """
    after = body.advance(state, v, h, straight)
    if body.integration.static:
        return dataclasses.replace(after, v=body.floating_velocity(after))
    return after


def joined_state(states: list[State]) -> State:
    """The state of all parts."""
    if len(states) == 1:
        return states[0]
    return State(
        np.concatenate([state.q for state in states]),
        np.concatenate([state.v for state in states]),
        np.concatenate([state.memory for state in states]),
    )


def joined_forces(spans: Spans, forces: Sequence[Array | None]) -> Array | None:
    """Forces (n,) of those of each part, where None are zero; None where all are."""
    if all(force is None for force in forces):
        return None
    total = np.zeros(spans.columns[-1].stop)
    for span, force in zip(spans.columns, forces, strict=True):
        if force is not None:
            total[span] = force
    return total


@dataclass(frozen=True, slots=True)
class PartsAssembled(Assembled):
    """Forces and tangents of each part, as its body assembled them, beside the attributes of `Assembled`."""

    parts: tuple[Assembled, ...]

    def augmentation(self, H: Array, rho: Array) -> tuple[Augmentation, Array]:
        """What adds ρ_i h_iᵀ h_i to tangents, of rows that are those of one part; see `Assembled`."""
        blocks = [H[:, span] for span in slices([len(part.state.v) for part in self.parts])]
        of_part = np.array([block.any(axis=1) for block in blocks])  # (p, m)
        alone, added, parts = of_part.sum(axis=0) == 1, np.zeros_like(rho), []
        for part, block, own in zip(self.parts, blocks, of_part, strict=True):
            made, found = part.augmentation(block, np.where(own & alone, rho, 0.0))
            parts.append(made)
            added += found
        return tuple(parts), added
