"""What all bodies of tetrahedra have, whatever coordinates move their nodes."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

from tauten.model.body import SparseBody
from tauten.model.effectors import Effectors
from tauten.model.mesh import TetMesh
from tauten.model.numerics import Array, Ints
from tauten.model.points import MeanPoints, NodeMotion, NodePoints, points_at
from tauten.model.state import State
from tauten.model.tetra.tetrahedra import Tetrahedra

Points = NodePoints | MeanPoints


@dataclass(frozen=True, slots=True, eq=False)
class TetBody(SparseBody[Points]):
    """A body of tetrahedra.

    Attributes, beside those of every sparse body:
        tetrahedra: its elements, over the nodes that are not fixed.
    """

    tetrahedra: Tetrahedra

    @property
    def mesh(self) -> TetMesh:
        """Linear tetrahedra on all nodes at rest."""
        return self.tetrahedra.mesh

    @property
    def moving_mass(self) -> float:
        """Mass of all nodes that are not fixed [kg]."""
        return float(self.tetrahedra.mass[::3].sum())

    @property
    def size(self) -> float:
        """Largest distance between two nodes at rest [m]."""
        return self.mesh.size

    @property
    def n_nodes(self) -> int:
        """Nodes, fixed ones included."""
        return len(self.mesh.nodes)

    @property
    def n_elements(self) -> int:
        """Tetrahedra, of smoothed elements those that are averaged, and beams among them."""
        return self.tetrahedra.elements.n_elements

    def surface_points(self, vertices: Ints) -> NodePoints:
        """Points of the body at some nodes (v,)."""
        return points_at(vertices)

    @abstractmethod
    def motion(self, state: State) -> NodeMotion:
        """Where the nodes are at a state, and how they move with the unknowns."""

    def nodes(self, state: State) -> Array:
        """Positions of all nodes, fixed ones included: (n_nodes, 3) [m]."""
        return self.motion(state).x

    def points(self, state: State) -> Array:
        """Positions of what `triangles` joins, here all nodes: (n_nodes, 3) [m]."""
        return self.nodes(state)

    def loaded(self, gravity: Array, effector_force: Array, effectors: Effectors[Points]) -> Self:
        """The body under other loads, see `Body`."""
        held = self.tetrahedra
        mass = held.mass.reshape(-1, 3)
        pushed = effectors.pushed(effector_force).on(held.motion(held.mesh.nodes))
        made = dataclasses.replace(held, load=(mass * gravity).ravel() + pushed)
        return dataclasses.replace(self, gravity=gravity, tetrahedra=made)

    def stored(self, state: State) -> float:
        """Energy stored in the memory of viscous materials [J]."""
        viscosity = self.tetrahedra.viscosity
        return 0.0 if viscosity is None else viscosity.energy(state.memory)

    def inverted(self, state: State) -> int:
        """Number of tetrahedra that are turned inside out."""
        return self.mesh.inverted(self.nodes(state))

    def remembering(self, before: State, after: State, h: float) -> State:
        """The state at the end of a step, with the memory of viscous materials there, see `Body`."""
        held = self.tetrahedra
        if held.viscosity is None:
            return after
        ends = self.nodes(before), self.nodes(after)
        memory = held.viscosity.remembered(held.elements, *ends, before.memory, h)
        return dataclasses.replace(after, memory=memory)
