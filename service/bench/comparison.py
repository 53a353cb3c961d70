"""`tauten compare`: the same command with and without contact, as the paper's Figs. 5 and 11."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tauten.model import Robot, Simulator, State
from tauten.model.numerics import Array

_STEPS = 20  # on the way to the command, so that folds are entered as a slow pull enters them


class CompareError(ValueError):
    """A comparison that cannot be made; the message names what to change."""


@dataclass(frozen=True, slots=True, eq=False)
class Equilibrium:
    """Where a command takes a robot.

    Attributes:
        state: of the robot.
        effector: (p, 3) [m].
        values: (n_v,) goal values of the effectors.
        effort: (n_a,) [N].
        position: (n_a,) [m].
        lam_c: (n_c,) contact forces [N].
        share: of the command that the robot has an equilibrium for; less than 1 where the load was shortened.
    """

    state: State
    effector: Array
    values: Array
    effort: Array
    position: Array
    lam_c: Array
    share: float


@dataclass(frozen=True, slots=True)
class Comparison:
    """The numbers of a comparison, as JSON has them.

    Attributes:
        robot: its name.
        pull_mm: pulled lengths, with and without contact.
        tension_n: tensions, with and without contact.
        apart_mm: distance between the effectors, with against without contact; of a distance or length
            the difference.
        pushing: candidates that push.
        contact_force_n: sum of the contact forces.
        deepest_overlap_mm: of candidates and surfaces without contact.
        share: of the command, with and without contact; less than 1 where the robot has no equilibrium
            farther on.
        apart_mrad: angle between frames; None for effectors of other kinds.
        apart_ml: difference of volumes; None for effectors of other kinds.
    """

    robot: str
    pull_mm: tuple[list[float], list[float]]
    tension_n: tuple[list[float], list[float]]
    apart_mm: list[float]
    pushing: int
    contact_force_n: float
    deepest_overlap_mm: float
    share: tuple[float, float]
    apart_mrad: tuple[float | None, ...] = ()
    apart_ml: tuple[float | None, ...] = ()


def equilibrium(
    robot: Robot, contact: str, position: Array | None, effort: Array | None
) -> Equilibrium:
    """Settle on the way to a command and there, or as far as there are equilibria.

    Args:
        robot: what is commanded.
        contact: "full" or "none".
        position: (n_a,) positions [m], or
        effort: (n_a,) efforts [N]; NaN in each where the other one is given.

    Raises:
        CompareError: no equilibrium was found on the way.
    """
    simulator = Simulator(robot, contact=contact)  # type: ignore[arg-type]
    share = 0.0
    for following in np.linspace(0.0, 1.0, _STEPS + 1)[1:]:
        report = simulator.settle(
            position=None if position is None else following * position,
            effort=None if effort is None else following * effort,
        )
        share += report.share * (following - share)
        if not report.converged:
            if share == 0.0:
                with_it = contact != "none"
                hint = "" if with_it else "; what nothing but contact holds has none"
                raise CompareError(
                    f"{robot.name}: found no equilibrium {'with' if with_it else 'without'} contact: "
                    f"{report.ending.value}{hint}"
                )
            break
    lam_c = simulator.smooth_contact_forces() if contact == "full" else np.zeros(robot.n_c)
    return Equilibrium(
        simulator.state, simulator.effector, simulator.effector_values, simulator.effort,
        simulator.position, lam_c, share,
    )  # fmt: skip


def compare_equilibria(robot: Robot, touching: Equilibrium, passing: Equilibrium) -> Comparison:
    """Numbers of a comparison."""
    gaps = robot.rows(passing.state).contacts.rows.delta
    layout = robot.effector_layout
    change = layout.difference(touching.values, passing.values)  # (n_e,)
    own = [change[layout.rows_of(i)] for i in range(len(layout))]
    apart = np.linalg.norm(touching.effector - passing.effector, axis=1)  # (p,)
    for i, kind in enumerate(layout.kinds):
        if kind in ("distance", "length", "function"):
            apart[i] = abs(own[i][0])
    return Comparison(
        robot=robot.name,
        pull_mm=((1e3 * touching.position).tolist(), (1e3 * passing.position).tolist()),
        tension_n=(touching.effort.tolist(), passing.effort.tolist()),
        apart_mm=(1e3 * apart).tolist(),
        pushing=int((touching.lam_c > 0.0).sum()),
        contact_force_n=float(touching.lam_c.sum()),
        deepest_overlap_mm=1e3 * max(0.0, -float(gaps.min(initial=0.0))),
        share=(touching.share, passing.share),
        apart_mrad=tuple(
            1e3 * float(np.linalg.norm(rows[3:])) if len(rows) == 6 else None for rows in own
        ),
        apart_ml=tuple(
            1e6 * abs(float(rows[0])) if kind == "volume" else None
            for kind, rows in zip(layout.kinds, own, strict=True)
        ),
    )
