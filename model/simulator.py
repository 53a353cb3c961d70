"""The forward simulator: a robot under tensions or pulled lengths, step by step or settled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tauten.model.compliance import row_compliance
from tauten.model.contact_space import ContactSpace
from tauten.model.forward_step import (
    NO_ENRICHMENT,
    CableCommand,
    Enrichment,
    ForwardStep,
    contact_model,
    forward_step,
    no_forces,
)
from tauten.model.numerics import Anderson, Array, solve_lcp
from tauten.model.robot import Robot, State
from tauten.model.system import Integration


@dataclass(frozen=True, slots=True)
class Report:
    """How a step or a settling went.

    Attributes:
        converged: whether contact, and for settling the equilibrium, met its tolerance.
        iterations: linearised steps taken.
        movement: largest displacement of a node in the last one [m].
        residual: complementarity of the contacts [m].
        deepest_gap: smallest predicted gap [m], +inf without any candidate in range.
        extra_columns: unit columns that were in play.
    """

    converged: bool
    iterations: int
    movement: float
    residual: float
    deepest_gap: float
    extra_columns: int


class Simulator:
    """Forward simulation of a robot.

    Attributes:
        robot: the robot, with a factorisation of its own.
        state: configuration and velocity.
        forces: constraint forces of the last step.
    """

    def __init__(
        self,
        robot: Robot,
        contact: Literal["none", "full"] | ContactSpace = "full",
        enrichment: Enrichment | None = None,
    ) -> None:
        """Start at rest.

        Args:
            robot: what to simulate; the caller's workspace is left alone.
            contact: "none"; "full", pointwise to 1e-8 m; or a basis of contact forces.
            enrichment: when unit columns join; default: as tight as "full" needs, off for a basis.

        Raises:
            ValueError: `contact` is none of these, or a basis of another robot's size.
        """
        self._space, default = contact_model(contact, robot.n_c, NO_ENRICHMENT)
        self._enrichment = enrichment or default
        self.robot = robot.fork()
        self._static = replace(robot.integration, static=True)
        self.reset()

    def reset(self) -> None:
        """Back to rest, no forces."""
        self.state = self.robot.rest()
        self.forces = no_forces(self.robot.n_a, self._space.k)

    @property
    def effector(self) -> Array:
        """Positions of the effectors: (p, 3) [m]."""
        return self.robot.effector(self.state)

    @property
    def pull(self) -> Array:
        """Pulled lengths: (n_a,) [m]."""
        return self.robot.rows(self.state, contacts=False).actuators.delta

    @property
    def tension(self) -> Array:
        """Cable tensions of the last step: (n_a,) [N]."""
        return self.forces.tension

    @property
    def gaps(self) -> Array:
        """Signed gap of every candidate, +inf where out of range: (n_c,) [m]."""
        return self.robot.rows(self.state).contacts.gaps()

    @property
    def lam_c(self) -> Array:
        """Contact force of every candidate in the last step: (n_c,) [N]."""
        lam = self._space.lift(self.forces.beta).copy()
        lam[self.forces.extra] += self.forces.extra_beta
        return lam

    def step(
        self,
        pull: Sequence[float] | Array | None = None,
        tension: Sequence[float] | Array | None = None,
    ) -> Report:
        """One time step h under pulled lengths [m] or tensions [N], (n_a,) each.

        Raises:
            ValueError: not exactly one of the two, or a wrong shape, or not finite.
        """
        result, movement = self._advance(self._command(pull, tension))
        return _report(result, 1, movement, result.converged)

    def settle(
        self,
        pull: Sequence[float] | Array | None = None,
        tension: Sequence[float] | Array | None = None,
        tolerance: float = 1e-7,
        max_iterations: int = 200,
    ) -> Report:
        """Move to equilibrium under pulled lengths [m] or tensions [N].

        Newton steps of the quasi-static system, each at most a twentieth of the body long, near the end
        accelerated by Anderson's method, because the tangent leaves out how contact normals turn.

        Args:
            pull: (n_a,) pulled lengths [m].
            tension: (n_a,) tensions [N].
            tolerance: largest displacement of a node in the last step [m].
            max_iterations: linearised steps at most; then `converged` is False.

        Raises:
            ValueError: not exactly one of pull and tension, or a wrong shape, or not finite.
        """
        command = self._command(pull, tension)
        near = 2e-3 * self.robot.size  # from here on the iteration is nearly linear
        iteration, movement, anderson = 0, np.inf, Anderson(depth=5)
        while iteration < max_iterations:
            iteration += 1
            result, movement = self._advance(command, self._static, anderson, near)
            if movement < tolerance or not np.isfinite(movement):
                break
        self.state = State(self.state.q, np.zeros_like(self.state.v))
        return _report(result, iteration, movement, movement < tolerance and result.converged)

    def smooth_contact_forces(self, regularisation: float = 1e-6) -> Array:
        """The equilibrium's contact forces of nearly least norm: (n_c,) [N].

        Pointwise forces are not unique where candidates are finer than the mesh; snapshots want the
        smooth ones. The state is left as it is.

        Args:
            regularisation: relative to the diagonal of the compliance; larger is smoother.
        """
        rows = self.robot.rows(self.state)
        lam_c = np.zeros(self.robot.n_c)
        if len(rows.contacts) == 0:
            return lam_c
        system = self.robot.linearise(self.state, self.forces.tension, self._static)
        H = np.vstack([rows.actuators.dense(), rows.contacts.rows.dense()])
        response = row_compliance(
            system, H, np.concatenate([rows.actuators.delta, rows.contacts.rows.delta])
        )
        n_a = self.robot.n_a
        W = response.W[n_a:, n_a:]
        delta = response.delta_free[n_a:] + response.W[n_a:, :n_a] @ self.forces.tension
        lam_c[rows.contacts.slots] = solve_lcp(W, delta, rho=regularisation).lam
        return lam_c

    def _advance(
        self,
        command: CableCommand,
        integration: Integration | None = None,
        anderson: Anderson | None = None,
        near: float = 0.0,
    ) -> tuple[ForwardStep, float]:
        system, result = forward_step(
            self.robot, self.state, self._space, command, self._enrichment, self.forces, integration
        )
        movement, dv = self.robot.displacement(system.h * (system.v + result.dv)), result.dv
        if anderson is not None and movement < near:
            dv = anderson.next(system.h * dv) / system.h
        elif anderson is not None:
            dv = dv * min(1.0, 0.05 * self.robot.size / movement)
        self.state = self.robot.advance(self.state, system, dv)
        self.forces = result.forces
        return result, movement

    def _command(
        self, pull: Sequence[float] | Array | None, tension: Sequence[float] | Array | None
    ) -> CableCommand:
        if (pull is None) == (tension is None):
            raise ValueError("give either pull [m] or tension [N], one value a cable")
        value = np.asarray(pull if tension is None else tension, dtype=float)
        if value.shape != (self.robot.n_a,) or not np.isfinite(value).all():
            raise ValueError(
                f"{'pull' if tension is None else 'tension'}: found {value.tolist()}, "
                f"expected {self.robot.n_a} finite values"
            )
        return CableCommand(pull=value) if tension is None else CableCommand(tension=value)


def _report(result: ForwardStep, iterations: int, movement: float, converged: bool) -> Report:
    return Report(
        converged=converged,
        iterations=iterations,
        movement=movement,
        residual=result.residual,
        deepest_gap=result.deepest_gap,
        extra_columns=len(result.forces.extra),
    )
