"""The same robot on other meshes, under the same loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tauten.model import Robot, Simulator
from tauten.model.load import build_robot, read_bodies
from tauten.model.numerics import Array
from tauten.model.schema import ElementName, RobotConfig
from tauten.model.signals import Quantity

AnyElement = ElementName | Literal["beam"]

LEAST_SLACK = 0.05  # of the largest pull; cables that are slack for less count as taut at rest
TOLERANCE = 1e-6  # m; movement of the last step of an equilibrium


@dataclass(frozen=True, slots=True)
class Variant:
    """What a robot's mesh is replaced by.

    Attributes:
        element: what it is made of.
        refinements: how often every tetrahedron of the file is cut into eight, or every beam into two.
    """

    element: AnyElement
    refinements: int

    @property
    def name(self) -> str:
        """In tables."""
        return self.element + self.refined

    @property
    def phrase(self) -> str:
        """In sentences."""
        return f"{self.element} elements{self.refined}"

    @property
    def refined(self) -> str:
        """How often, in words; "" for the mesh of the file."""
        words = ("", ", refined once", ", refined twice")
        count = self.refinements
        return words[count] if count < len(words) else f", refined {count} times"

    @property
    def relative_cost(self) -> int:
        """Number of nodes relative to the mesh of the file, linear or of beams, roughly."""
        if self.element == "beam":
            return int(2**self.refinements)
        return int(8 ** (self.refinements + (self.element == "quadratic")))


@dataclass(frozen=True, slots=True)
class Load:
    """One actuator moved; the others keep their position at rest, or are slack.

    Attributes:
        cable: its number.
        name: its name.
        share: of its farthest position, or of its largest tension.
        position: its position, in the unit of its kind.
        quantity: what its position is.
        slack: pull from which on the cable is taut, where the body sags towards it.
    """

    cable: int
    name: str
    share: float
    position: float
    quantity: Quantity
    slack: float = 0.0

    @property
    def label(self) -> str:
        """Name and position, in the unit that tables show."""
        return f"{self.name} {self.quantity.scale * self.position:.4g} {self.quantity.shown_unit}"


@dataclass(frozen=True, slots=True)
class LoadedState:
    """An equilibrium.

    Attributes:
        converged: whether it was found.
        effort: (n_a,) effort of every actuator, where they have several units in shares of its limit.
        tip: (3 q,) change of the effectors since rest, three for each part with weight, in metres by the
            units of `EffectorLayout` [m].
        contact_force: sum of all contact forces [N].
    """

    converged: bool
    effort: tuple[float, ...]
    tip: tuple[float, ...]
    contact_force: float


@dataclass(frozen=True, slots=True)
class VariantStates:
    """Equilibria of one variant.

    Attributes:
        variant: the mesh.
        nodes: its nodes.
        states: one a load; fewer where the work was stopped or failed.
        failure: the error that ended it; "" where there was none.
    """

    variant: Variant
    nodes: int
    states: tuple[LoadedState, ...]
    failure: str = ""


def make_loads(robot: Robot, shares: tuple[float, ...], antagonists: bool) -> tuple[Load, ...]:
    """Every actuator alone at shares of its farthest position, in ascending order.

    Where the body sags towards a cable, shares are of the way from where it is taut.

    Args:
        robot: the robot.
        shares: of the farthest position, or of the largest tension.
        antagonists: whether cables pull against each other, as those of arms made of beams do. The largest
            pull of one may be far beyond its tension then: it is pulled to where shares of its largest
            tension take it while the others are slack, if that is nearer.
    """
    kinds = zip(robot.actuators.names, robot.actuators.kinds, strict=True)
    if antagonists:
        return tuple(
            Load(cable, name, share, position, kind.position)
            for cable, (name, kind) in enumerate(kinds)
            for share, position in tensioned(robot, cable, sorted(shares))
        )
    farthest = robot.limits.farthest_position
    begin = slack_until(robot)
    return tuple(
        Load(
            cable, name, share,
            float(begin[cable] + share * (farthest[cable] - begin[cable])), kind.position,
            float(begin[cable]),
        )
        for cable, (name, kind) in enumerate(kinds)
        for share in sorted(shares)
    )  # fmt: skip


def slack_until(robot: Robot) -> Array:
    """The pull from which each cable is taut where the body sags towards it: (n_a,) [m]; otherwise zero."""
    none, cables = np.zeros(robot.n_a), ~robot.actuators.laws.bilateral
    if not cables.any() or not robot.gravity.any():
        return none
    simulator = Simulator(robot, contact="none")
    if not simulator.settle_start().converged:
        return none
    farthest = robot.limits.farthest_position
    slack = cables & (simulator.position > LEAST_SLACK * farthest)
    return np.where(slack, np.minimum(simulator.position, farthest), 0.0)


def tensioned(robot: Robot, cable: int, shares: list[float]) -> list[tuple[float, float]]:
    """Shares of a cable's largest tension with the pulled lengths they lead to, as far as they are found.

    No length is longer than the same share of the largest one; where none is found, they are these.

    Args:
        robot: on its own mesh.
        cable: its number.
        shares: in ascending order.
    """
    simulator, found = Simulator(robot, contact="full"), list[tuple[float, float]]()
    farthest = [share * float(robot.limits.farthest_position[cable]) for share in shares]
    for share, most in zip(shares, farthest, strict=True):
        effort = np.zeros(robot.n_a)
        effort[cable] = share * robot.limits.effort_max[cable]
        if not simulator.settle(effort=effort, tolerance=TOLERANCE).converged:
            break
        found.append((share, min(float(simulator.position[cable]), most)))
    return found or list(zip(shares, farthest, strict=True))


def chosen_variants(element: AnyElement, refinements: int) -> tuple[Variant, ...]:
    """The meshes to compare, in the order of their use: the robot's own, the finest quadratic, others.

    Args:
        element: of the robot file.
        refinements: of linear and smoothed elements at most; quadratic ones have one less, as their nodes are
            those of a refined linear mesh, except where the robot itself is quadratic.
    """
    own = [Variant(element, count) for count in range(refinements + 1)]
    if element == "beam":
        return tuple(own)
    finest = refinements if element == "quadratic" else max(refinements - 1, 0)
    quadratic = [Variant("quadratic", count) for count in range(finest, -1, -1)]
    smoothed = [] if element == "smoothed" else [Variant("smoothed", 0)]
    return tuple(dict.fromkeys([own[0], *quadratic, *smoothed, *own[1:]]))


def variant_robot(config: RobotConfig, path: Path, variant: Variant) -> Robot:
    """The robot of a file on another mesh.

    Raises:
        RobotFileError, MeshError: it cannot be built.
    """
    changed = config if variant.element == "beam" else config.with_element(variant.element)
    return build_robot(changed, read_bodies(changed, path, variant.refinements), str(path))


def equilibria(robot: Robot, loads: tuple[Load, ...], antagonists: bool) -> Iterator[LoadedState]:
    """The robot at rest under each load; pulls of a cable that is slack at first count from where it is taut.

    Args:
        robot: the robot.
        loads: in ascending order for each cable, which starts from rest.
        antagonists: as of `make_loads`; the other cables are slack then.
    """
    simulator, cable = Simulator(robot, contact="full"), -1
    sags = any(load.slack > 0.0 for load in loads)
    begin = slack_until(robot) if sags else np.zeros(robot.n_a)
    one_unit = bool((robot.actuators.groups == 0).all())
    unit = np.ones(robot.n_a) if one_unit else robot.limits.largest_effort
    # where regions have other nodes on another mesh, their means differ at rest already: that is no error
    layout, rest = robot.effector_layout, robot.effector_values(robot.rest())
    for load in loads:
        if load.cable != cable:
            simulator.reset()
            cable = load.cable
        position = robot.limits.position_min.copy() if antagonists else np.zeros(robot.n_a)
        position[cable] = load.position + (begin[cable] - load.slack if load.slack > 0.0 else 0.0)
        converged = simulator.settle(position=position, tolerance=TOLERANCE).converged
        moved = layout.counted(simulator.effector_values, rest)  # (n_e,)
        yield LoadedState(
            converged,
            tuple((simulator.effort / unit).tolist()),
            tuple(layout.in_metres(moved[:, None]).ravel().tolist()),
            float(simulator.lam_c.sum()),
        )
        if not converged:
            simulator.reset()
