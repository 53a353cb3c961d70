"""The body of tetrahedra whose nodes move freely."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from tauten.model.body import Turning
from tauten.model.materials import EXACT, MATERIAL
from tauten.model.mesh import boundary_triangles
from tauten.model.numerics import Array, Ints, longest
from tauten.model.points import NodeMotion
from tauten.model.state import State
from tauten.model.tetra.tetra_body import TetBody
from tauten.model.tetra.turning import TurningSteps


@dataclass(frozen=True, slots=True, eq=False)
class NodalBody(TetBody):
    """A body of tetrahedra whose unknowns are the positions of its nodes."""

    @property
    def triangles(self) -> Ints:
        """Surface as triples of `points`: (t, 3)."""
        return boundary_triangles(self.mesh.tets)

    def rest(self) -> State:
        """The stress-free state at standstill."""
        return State(self.tetrahedra.at_rest, np.zeros(self.n), self.tetrahedra.relaxed)

    def motion(self, state: State) -> NodeMotion:
        """Where the nodes are at a state."""
        return self.tetrahedra.motion(self.tetrahedra.placed(state.q))

    def displacement(self, state: State, dq: Array) -> float:
        """Largest displacement of a node in a change dq (n,) of the configuration [m]."""
        return longest(dq)

    def forces(
        self, state: State, effort: Array | None = None, exact: bool = False
    ) -> tuple[Array, Array]:
        """Internal forces plus gravity, and the tangent, see `Robot`."""
        return self.forces_with(
            EXACT if exact else self.tetrahedra.elements.semidefinite, state, effort
        )

    def stiffness(self, state: State) -> Array:
        """The stiffness of the material, carried along with the elements: CSC values (nnz,)."""
        return self.tetrahedra.forces(MATERIAL, self.motion(state).x, None)[1]

    def forces_and_stiffness(
        self, state: State, effort: Array | None
    ) -> tuple[Array, Array, Array]:
        """`forces` with the exact tangent, and `stiffness`, in one pass over the elements."""
        D = np.zeros(len(self.pattern.indices))
        force, K = self.forces_with(EXACT, state, effort, D)
        return force, K, D

    def forces_with(
        self, tangent: int, state: State, effort: Array | None = None, D: Array | None = None
    ) -> tuple[Array, Array]:
        """`forces` with one of the tangents of `tauten.model.materials.response`.

        Args:
            tangent: EXACT, PROJECTED or MATERIAL.
            state: as in `forces`.
            effort: as in `forces`.
            D: (nnz,) zeros, overwritten with `stiffness`; None: it is not wanted.
        """
        motion, actuators = self.motion(state), self.actuator_set
        loads = actuators.loads(actuators.efforts(effort), tangent == EXACT)
        total, K = self.tetrahedra.forces(tangent, motion.x, loads, D)
        preload = actuators.preload(motion)
        return (total if preload is None else total + preload[0]), K

    def potential(self, state: State) -> float:
        """Elastic energy minus the work of gravity and outer forces since rest [J]."""
        motion = self.motion(state)
        preload = self.actuator_set.preload(motion)
        return self.tetrahedra.potential(motion.x) - (preload[1] if preload else 0.0)

    def viscosity_at(self, state: State, h: float) -> tuple[Array | None, Array | None]:
        """Forces (n,) of viscous materials' memory [N], and matrix C as CSC values (nnz,); None: no such.

        See `SparseBody`.
        """
        held = self.tetrahedra
        if held.viscosity is None:
            return None, None
        return held.viscous(held.viscosity, self.nodes(state), state.memory, h)

    def masses(self, state: State) -> Array:
        """Lumped masses (n,), the same at any state."""
        return self.tetrahedra.mass

    def turning_steps(self) -> Turning:
        """What makes long steps towards equilibrium turn elements instead of stretching them."""
        return partial(self._turned, TurningSteps(self.mesh, self.pattern.dof))

    def _turned(self, steps: TurningSteps, state: State, u: Array) -> Array:
        return steps.turned(self.nodes(state), u)

    def advance(self, state: State, v: Array, h: float, straight: bool = False) -> State:
        """The state one step later, v and q + h v, see `Robot`."""
        return self.remembering(state, State(state.q + h * v, v), h)
