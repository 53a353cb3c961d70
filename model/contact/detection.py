"""Contact: candidate points of one surface against the triangles of another, or against an obstacle.

A candidate is a point of a surface triangle, fixed in it. Its *contact point* is the nearest point of
the target surface within the alarm distance that

1. is a local minimum of the distance to the surface;
2. lies inside the surface, not on its border;
3. lies on a triangle that shares no vertex with the triangle of the candidate: neighbours on one
   surface, or the two flanks of a notch at its root, do not collide. Of a surface against itself more
   triangles are left out (`tauten.model.contact.self_contact`).

A candidate with a contact point is *in range* and has a row; the others have none.

The gap δ_c is the signed distance to this point, negative behind the surface, less the distance at which
surfaces are to be held, by default zero. Its gradient, that of a distance, needs no derivative of the closest
point:

    dδ_c = nᵀ (Σ_j w_j dx_j − Σ_j b_j dy_j)                                       (T2)

with the candidate's weights w over its triangle's vertices x and the closest point's weights b over
the target triangle's vertices y.

The gap to an obstacle (`tauten.model.contact.obstacle`) is its signed distance, at any depth, with the
gradient nᵀ Σ_j w_j dx_j. Obstacles that move are where they are at the end of the step that is taken: the gap
after it is then gap + h n · v of the candidate, as of one that stands still.

**Open surfaces.** A face selected from a body has a border, and the side of a point beyond the border is
undefined. By rule 2 a candidate beyond the border, above or below the face, has no row: the border does
not stop it, and a candidate that has slid off the face is not treated as a deep penetration. The gap is
therefore continuous while the candidate projects onto the face, and ends where it crosses the border
(rule 3 excludes the surroundings of the candidate in the same way). A closed surface has no border, and
its gap is continuous everywhere within the alarm distance.

**Depth.** Penetration is found down to the alarm distance, which must be less than the thickness of the
body: in a thinner wall a candidate of one side is also behind the other side.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.contact.broad_phase import BLOCK
from tauten.model.contact.narrow_phase import no_closest_points, search
from tauten.model.contact.obstacle import ObstaclePose, ObstaclePoses, poses_at_start
from tauten.model.contact.pair import ContactPair, LargestSum, check_pair
from tauten.model.contact.surface_topology import SurfaceTopology, join_surfaces
from tauten.model.contacts import Contacts
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.rows import PairSlots

SHORT = 16  # candidates; blocks of connected parts have at least as many


@dataclass(frozen=True, slots=True)
class Detection(Contacts):
    """Candidates in range, with the vertices that move their gaps.

    Attributes, beside those of all contacts:
        vertices: (m, 6) the candidate's three vertices, then the target triangle's; where the target is a
            shape the candidate's again, with coefficients of zero.
        coefficients: (m, 6): dgap = Σ_j coefficients_j normalᵀ dx_j (T2).
    """

    vertices: Ints
    coefficients: Array


class ContactSet:
    """All contact pairs of a robot; the slot of a candidate never changes.

    Attributes:
        pairs: the pairs; slots run through them in this order.
        n_vertices: number of vertices positions are given for.
        alarm_distance: largest distance that is reported [m].
        distance: at which surfaces are held from each other [m]; the gap is what remains to it.
        sums: largest sums of normal forces that decisions keep.
        n_slots: number of candidates n_c.
        frictional: whether any pair has friction.
        poses: where the obstacles are.
    """

    def __init__(
        self,
        pairs: list[ContactPair],
        n_vertices: int,
        alarm_distance: float,
        distance: float = 0.0,
        sums: Sequence[LargestSum] = (),
    ) -> None:
        """Check the pairs and join their arrays.

        Args:
            pairs: their slots follow each other in this order.
            n_vertices: number of vertices positions are given for.
            alarm_distance: largest distance that is reported [m].
            distance: at which surfaces are held from each other [m].
            sums: largest sums of normal forces that decisions keep.

        Raises:
            ValueError: the alarm distance is not positive and larger than the other, or a pair has no
                candidates or triangles, vertices out of range, weights that are not barycentric, or
                triangles not oriented alike.
        """
        if not 0.0 <= distance < alarm_distance < np.inf:
            raise ValueError(
                f"alarm_distance is {alarm_distance} m, it must be positive and larger than the distance of "
                f"{distance} m at which surfaces are held"
            )
        for pair in pairs:
            check_pair(pair, n_vertices)
        self.pairs = tuple(pairs)
        self.n_vertices = n_vertices
        self.alarm_distance = alarm_distance
        self.distance = distance
        self.sums = tuple(sums)
        self._nodes: Ints = np.vstack([np.zeros((0, 3)), *(p.nodes for p in pairs)]).astype(
            np.int64
        )
        self.n_slots = len(self._nodes)
        self._weights: Array = np.vstack([np.zeros((0, 3)), *(p.weights for p in pairs)])
        self._friction = np.array([pair.friction for pair in pairs], dtype=float)
        self.frictional = bool(self._friction.any())
        self._first: Ints = np.cumsum([0, *(len(pair.nodes) for pair in pairs)]).astype(np.int64)
        blocks = blocks_of([pair.nodes for pair in pairs], n_vertices)
        shaped = np.array([pair.obstacle is not None for pair in pairs], dtype=bool)
        self._blocks: Ints = blocks[~shaped[blocks[:, 2]]]
        self._shaped = np.flatnonzero(shaped).tolist()
        named = {one.obstacle.name: one.obstacle for one in pairs if one.obstacle is not None}
        self.poses = poses_at_start(tuple(named.values()))
        self._surfaces: SurfaceTopology = join_surfaces(
            [pair.triangles.astype(np.int64) for pair in pairs],
            [pair.nodes.astype(np.int64) for pair in pairs],
            [pair.apart.astype(np.int64) for pair in pairs],
            [pair.name for pair in pairs],
        )

    @property
    def without_friction(self) -> Bools:
        """Which candidates belong to pairs without friction, whose forces a basis may give: (n_c,)."""
        chosen: Bools = np.repeat(self._friction == 0.0, np.diff(self._first))
        return chosen

    @property
    def pair_slots(self) -> tuple[PairSlots, ...]:
        """The pairs' names and slots, in order."""
        slots = pairwise(self._first.tolist())
        return tuple(PairSlots(p.name, *s) for p, s in zip(self.pairs, slots, strict=True))

    def placed(self, poses: ObstaclePoses) -> ContactSet:
        """The same contacts with the obstacles (those of `poses`) elsewhere."""
        other = copy(self)
        other.poses = poses
        return other

    def positions(self, x: Array) -> Array:
        """Positions of all candidates at vertex positions x (n_vertices, 3): (n_c, 3) [m]."""
        positions: Array = np.einsum("mj,mji->mi", self._weights, x[self._nodes])
        return positions

    def detect(self, x: Array) -> Detection:
        """Gaps of the candidates in range at vertex positions x (n_vertices, 3) [m].

        Never fails: a candidate or a triangle at a position that is not finite is out of range.
        """
        x = np.ascontiguousarray(x, dtype=float)
        distances = self.alarm_distance, self.distance
        packed = detect_all(
            x, self._nodes, self._weights, self._blocks, self._surfaces, self._friction, distances
        )
        for number in self._shaped:
            packed = merged(packed, self._touching(number, x))
        numbers, values = packed
        m = len(numbers) // 8
        found = Detection(
            self.n_slots, numbers[:m], numbers[m : 2 * m], values[:m],
            values[m : 4 * m].reshape(m, 3), values[4 * m : 7 * m].reshape(m, 3), values[7 * m : 8 * m],
            numbers[2 * m :].reshape(m, 6), values[8 * m :].reshape(m, 6),
        )  # fmt: skip
        return replace(found, surface=self._surface(found)) if self.poses.move else found

    def _touching(self, number: int, x: Array) -> tuple[Ints, Array]:
        """Candidates within reach of the obstacle of a pair, by its number, as `detect_all` gives them."""
        pair, first = self.pairs[number], int(self._first[number])
        assert pair.obstacle is not None
        place, points = finite_candidates(x, pair.nodes, pair.weights)
        pose, reach = self._pose(pair.obstacle.name), self.alarm_distance
        gap, normal = pair.obstacle.closest(points, pose, reach)
        found = np.ascontiguousarray(gap, dtype=float), np.ascontiguousarray(normal, dtype=float)
        kept = (number, first), pair.friction, (reach, self.distance)
        return candidates_near(place, points, found, *kept, pair.nodes, pair.weights)

    def _pose(self, obstacle: str) -> ObstaclePose:
        """Where an obstacle is, by its name."""
        return self.poses.poses[self.poses.number(obstacle)]

    def _surface(self, found: Detection) -> Array:
        """Velocity of the obstacle at the nearest point of each contact (m, 3), zero of others [m/s]."""
        surface = np.zeros_like(found.point)
        for number in self._shaped:
            obstacle = self.pairs[number].obstacle
            assert obstacle is not None
            pose = self._pose(obstacle.name)
            own = np.flatnonzero(found.pair == number)
            if pose.moves and len(own) > 0:
                way = (found.gap[own] + self.distance)[:, None] * found.normal[own]
                surface[own] = pose.velocity_at(found.point[own] - way)
        return surface


def blocks_of(candidates: list[Ints], n_vertices: int) -> Ints:
    """Candidates that are treated together: (b, 3) first slot, one past the last, and the pair.

    A block ends with its pair, after `BLOCK` candidates, and, where it has `SHORT`, with the connected part
    of the surface that it lies in: few triangles are within reach of a block that is small in space.

    Args:
        candidates: of each pair, (m, 3) vertex ids of the triangles that its candidates lie in.
        n_vertices: number of vertices.
    """
    blocks, begin = [], 0
    for pair, nodes in enumerate(candidates):
        links = np.concatenate([nodes[:, :2], nodes[:, 1:]])
        graph = sp.coo_array((np.ones(len(links)), links.T), shape=(n_vertices, n_vertices))
        part = connected_components(graph, directed=False)[1][nodes[:, 0]]
        start = begin
        for i in range(1, len(nodes) + 1):
            size = begin + i - start
            ends = i == len(nodes) or (part[i] != part[i - 1] and size >= SHORT)
            if ends or size == BLOCK:
                blocks.append((start, begin + i, pair))
                start = begin + i
        begin += len(nodes)
    return np.array(blocks, dtype=np.int64).reshape(-1, 3)


@kernel
def detect_all(
    x: Array,
    nodes: Ints,
    weights: Array,
    blocks: Ints,
    surfaces: SurfaceTopology,
    friction: Array,
    distances: tuple[float, float],
) -> tuple[Ints, Array]:
    """The arrays of a `Detection` one after the other: its integers (8 m,), and its other numbers (14 m,).

    Args:
        x: (n_vertices, 3) positions [m].
        nodes: (n_c, 3) vertices of the candidates of all pairs.
        weights: (n_c, 3) their weights.
        blocks: (b, 3) candidates that are treated together, see `blocks_of`.
        surfaces: target surfaces of the pairs.
        friction: coefficients of the pairs.
        distances: the alarm distance, and the one at which surfaces are held [m].
    """
    reach, held = distances
    count = nodes.shape[0]
    points = np.zeros((3, count))
    for s in range(count):
        for j in range(3):
            for i in range(3):
                points[i, s] += weights[s, j] * x[nodes[s, j], i]
    found, pairs = no_closest_points(count), np.empty(count, np.int64)
    for k in range(blocks.shape[0]):
        begin, end, pair = blocks[k]
        search(x, points[:, begin:end].copy(), surfaces, pair, begin, reach, found)
        pairs[begin:end] = pair
    slots = np.flatnonzero(found.triangle >= 0)
    m = slots.shape[0]
    numbers, values = np.empty(8 * m, np.int64), np.zeros(14 * m)
    numbers[:m], numbers[m : 2 * m] = slots, pairs[slots]
    vertices, gap = numbers[2 * m :].reshape((m, 6)), values[:m]
    point, normal = values[m : 4 * m].reshape((m, 3)), values[4 * m : 7 * m].reshape((m, 3))
    coefficients = values[8 * m :].reshape((m, 6))
    triangle, inside, triangles = found.triangle, found.weights, surfaces.triangles
    for k in range(m):
        s = slots[k]
        gap[k], values[7 * m + k] = found.gap[s] - held, friction[pairs[s]]
        for j in range(3):  # entry by entry, which is faster than slices of three
            point[k, j], normal[k, j] = points[j, s], found.normal[s, j]
            vertices[k, j], vertices[k, 3 + j] = nodes[s, j], triangles[triangle[s], j]
            coefficients[k, j], coefficients[k, 3 + j] = weights[s, j], -inside[s, j]
    return numbers, values


@kernel
def finite_candidates(x: Array, nodes: Ints, weights: Array) -> tuple[Ints, Array]:
    """Candidates at finite positions: their numbers (k,), and where they are (k, 3) [m].

    Args:
        x: (n_vertices, 3) positions [m].
        nodes: (m, 3) vertices of the candidates.
        weights: (m, 3) their weights.
    """
    place, points = np.empty(len(nodes), np.int64), np.zeros((len(nodes), 3))
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
    return place[:count], points[:count]


@kernel
def candidates_near(
    place: Ints, points: Array, found: tuple[Array, Array], pair: tuple[int, int], friction: float,
    distances: tuple[float, float], nodes: Ints, weights: Array,
) -> tuple[Ints, Array]:  # fmt: skip
    """Candidates within reach of an obstacle, in the arrays of `detect_all`.

    Args:
        place: (k,) numbers of candidates in their pair.
        points: (k, 3) where they are [m].
        found: distances (k,) [m] and normals (k, 3).
        pair: its number and first slot.
        friction: its coefficient.
        distances: the alarm distance, and the one at which surfaces are held [m].
        nodes: (n, 3) vertices of all candidates of the pair.
        weights: (n, 3) their weights.
    """
    gap, normal = found
    near = np.flatnonzero(gap < distances[0])
    m = near.shape[0]
    numbers, values = np.empty(8 * m, np.int64), np.zeros(14 * m)
    for k in range(m):
        at = near[k]
        s = place[at]
        numbers[k], numbers[m + k] = pair[1] + s, pair[0]
        values[k], values[7 * m + k] = gap[at] - distances[1], friction
        for i in range(3):
            numbers[2 * m + 6 * k + i] = numbers[2 * m + 6 * k + 3 + i] = nodes[s, i]
            values[m + 3 * k + i], values[4 * m + 3 * k + i] = points[at, i], normal[at, i]
            values[8 * m + 6 * k + i] = weights[s, i]
    return numbers, values


@kernel
def merged(one: tuple[Ints, Array], other: tuple[Ints, Array]) -> tuple[Ints, Array]:
    """Candidates of different pairs in the arrays of `detect_all`, with ascending slots."""
    p, q = len(one[0]) // 8, len(other[0]) // 8
    if p == 0 or q == 0:
        return other if p == 0 else one
    m, a, b = p + q, 0, 0
    numbers, values = np.empty(8 * m, np.int64), np.empty(14 * m)
    for k in range(m):
        if b == q or (a < p and one[0][a] < other[0][b]):
            _put_contact(one, a, p, numbers, values, k, m)
            a += 1
        else:
            _put_contact(other, b, q, numbers, values, k, m)
            b += 1
    return numbers, values


@kernel
def _put_contact(
    source: tuple[Ints, Array], a: int, p: int, numbers: Ints, values: Array, k: int, m: int
) -> None:
    """Copy contact a of p into place k of m."""
    from_numbers, from_values = source
    numbers[k], numbers[m + k] = from_numbers[a], from_numbers[p + a]
    values[k], values[7 * m + k] = from_values[a], from_values[7 * p + a]
    for i in range(3):
        values[m + 3 * k + i] = from_values[p + 3 * a + i]
        values[4 * m + 3 * k + i] = from_values[4 * p + 3 * a + i]
    for i in range(6):
        numbers[2 * m + 6 * k + i] = from_numbers[2 * p + 6 * a + i]
        values[8 * m + 6 * k + i] = from_values[8 * p + 6 * a + i]
