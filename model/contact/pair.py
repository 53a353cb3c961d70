"""A contact pair: candidates, and what they may touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tauten.model.contact.obstacle import Obstacle
from tauten.model.numerics import Array, Ints, kernel
from tauten.model.schema import LARGEST_FRICTION


@dataclass(frozen=True, slots=True)
class ForceBounds:
    """What decisions keep of the forces of a contact.

    Attributes:
        least: sum of the normal forces, once it pushes [N].
        largest: sum of the normal forces; +inf: any [N].
        margin: distance to slip, once it pushes; 0: any [N].
    """

    least: float = 0.0
    largest: float = np.inf
    margin: float = 0.0

    @property
    def given(self) -> bool:
        """Whether anything is to be kept."""
        return self.least > 0.0 or self.largest < np.inf or self.margin > 0.0


@dataclass(frozen=True, slots=True)
class LargestSum:
    """The largest sum of the normal forces of several contacts, that decisions keep.

    Attributes:
        name: in messages.
        pairs: numbers of the contacts.
        force: at most [N].
    """

    name: str
    pairs: tuple[int, ...]
    force: float


@dataclass(frozen=True, slots=True)
class ContactPair:
    """Candidate points of one surface against triangles of another, or of the same one, or against a shape.

    Attributes:
        name: in messages and tables.
        nodes: (m, 3) vertex ids of the triangle each candidate lies in.
        weights: (m, 3) its barycentric weights, row sums 1.
        triangles: (t, 3) vertex ids of the target, counter-clockwise seen from outside; none of an obstacle.
        apart: (k, 2) candidate and triangle that are not compared, beside those that share a vertex.
        obstacle: the target instead of triangles; None: these are.
        friction: coefficient of friction.
        bounds: of its forces.
        loose: numbers of candidates (c,) and of triangles (f,) of bodies that nothing but contact joins; they
            may move far relative to each other in a step.
        owner: name of the part that the candidates belong to; "": the robot has no parts.
        other: name of the part that they may touch; "": an obstacle, or the robot has no parts.
    """

    name: str
    nodes: Ints
    weights: Array
    triangles: Ints
    apart: Ints = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    obstacle: Obstacle | None = None
    friction: float = 0.0
    bounds: ForceBounds = ForceBounds()
    loose: tuple[tuple[Ints, Ints], ...] = ()
    owner: str = ""
    other: str = ""

    def candidates(self, x: Array) -> Array:
        """Positions (m, 3) of the candidates at vertex positions x (v, 3) [m]."""
        positions: Array = np.einsum("mj,mji->mi", self.weights, x[self.nodes])
        return positions

    def renumbered(self, numbers: Ints) -> ContactPair:
        """The same pair over other vertices: numbers (v,) of those that it is over."""
        return replace(self, nodes=numbers[self.nodes], triangles=numbers[self.triangles])


def check_pair(pair: ContactPair, n_vertices: int) -> None:
    """Raise a ValueError that names the pair when its arrays do not make a contact."""
    targets = [("candidates", pair.nodes), ("triangles", pair.triangles)]
    for what, ids in targets if pair.obstacle is None else targets[:1]:
        if ids.ndim != 2 or ids.shape[1] != 3 or len(ids) == 0:
            raise ValueError(
                f"{pair.name}: {what} have shape {ids.shape}, expected (m, 3) with m > 0"
            )
        if ids.min() < 0 or ids.max() >= n_vertices:
            raise ValueError(
                f"{pair.name}: {what} name vertices {ids.min()} to {ids.max()}, "
                f"there are 0 to {n_vertices - 1}"
            )
    if not 0.0 <= pair.friction <= LARGEST_FRICTION:
        raise ValueError(
            f"{pair.name}: friction is {pair.friction}, expected 0 to {LARGEST_FRICTION:g}"
        )
    weights = pair.weights
    if weights.shape != pair.nodes.shape:
        raise ValueError(
            f"{pair.name}: weights have shape {weights.shape}, the candidates {pair.nodes.shape}"
        )
    good = (weights >= -1e-9).all(axis=1) & (np.abs(weights.sum(axis=1) - 1.0) < 1e-9)
    if not good.all():
        worst = int(np.flatnonzero(~good)[0])
        raise ValueError(
            f"{pair.name}: candidate {worst} has weights {weights[worst].tolist()}, "
            "they must not be negative and sum to 1"
        )


def loose_bodies(body: Ints, nodes: Ints, triangles: Ints) -> tuple[tuple[Ints, Ints], ...]:
    """The candidates and triangles of a pair that belong to different bodies, see `ContactPair`.

    Args:
        body: (v,) number of the body that each vertex belongs to.
        nodes: (m, 3) vertices of the triangles that the candidates lie in.
        triangles: (t, 3) of the target.
    """
    own, other = body[nodes[:, 0]], body[triangles[:, 0]]
    found = [(np.flatnonzero(own != one), np.flatnonzero(other == one)) for one in np.unique(other)]
    return tuple(bodies for bodies in found if len(bodies[0]) > 0)


def largest_sums(
    pairs: Sequence[ContactPair], of_all: float | None, first: int = 0
) -> tuple[LargestSum, ...]:
    """The largest sums of the normal forces: on obstacles that have one, and of all contacts.

    Args:
        pairs: of a robot, its last ones.
        of_all: the largest sum of all its contacts [N]; None: any.
        first: number of pairs before these.
    """
    numbers = dict[str, list[int]]()
    forces = dict[str, float]()
    for number, pair in enumerate(pairs, first):
        if pair.obstacle is not None and pair.obstacle.max_force < np.inf:
            numbers.setdefault(pair.obstacle.name, []).append(number)
            forces[pair.obstacle.name] = pair.obstacle.max_force
    sums = [
        LargestSum(f"all contacts on {name}", tuple(own), forces[name])
        for name, own in numbers.items()
    ]
    if of_all is not None:
        sums.append(LargestSum("all contacts", tuple(range(first + len(pairs))), of_all))
    return tuple(sums)


@kernel
def finite_candidates(x: Array, nodes: Ints, weights: Array, place: Ints, points: Array) -> int:
    """How many candidates are at finite positions.

    Args:
        x: (n_vertices, 3) positions [m].
        nodes: (m, 3) vertices of the candidates of a pair.
        weights: (m, 3) their weights.
        place: (m,) output, the numbers of those.
        points: (m, 3) zeros, to which their positions are added [m].
    """
    count = 0
    for s in range(len(nodes)):
        point = points[count]
        for j in range(3):
            w, corner = weights[s, j], x[nodes[s, j]]
            for i in range(3):
                point[i] += w * corner[i]
        if np.isfinite(point[0] + point[1] + point[2]):
            place[count] = s
            count += 1
        else:
            point[:] = 0.0
    return count
