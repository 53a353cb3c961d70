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
after it is then gap + h n · v of the candidate, as of one that stands still. In a step that began with
`stepping`, candidates stay on the side of obstacles and of other bodies where they were
(`tauten.model.contact.sides`).

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
from typing import TypeAlias

import numpy as np

from tauten.model.contact.broad_phase import blocks_of
from tauten.model.contact.narrow_phase import no_closest_points, search
from tauten.model.contact.obstacle import ObstaclePoses, poses_at_start
from tauten.model.contact.pair import ContactPair, LargestSum, check_pair, finite_candidates
from tauten.model.contact.shapes import PlaneShape
from tauten.model.contact.sides import Hits, Sides, add_hits, hits_of, joined, sides_of
from tauten.model.contact.surface_topology import SurfaceTopology, join_surfaces
from tauten.model.contacts import Contacts, nearest_from_all_sides
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.rows import PairSlots

NEAREST = 40  # candidates beyond the alarm distance that are found of a loose pair

_Found: TypeAlias = tuple[Ints, Array, Array, Ints, Array]  # what `detect_all` writes


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
        reach: distance up to which the nearest candidates of loose pairs are reported, too [m].
        sums: largest sums of normal forces that decisions keep.
        n_slots: number of candidates n_c.
        frictional: whether any pair has friction.
        obstructed: (n_pairs,) which pairs are with obstacles.
        sided: numbers of the pairs with obstacles that have more than one side, as all but planes have.
        loose: numbers of the pairs of bodies that may move far relative to each other.
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
        """Check the pairs and join their arrays; arguments as the attributes.

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
        self.alarm_distance = self.reach = alarm_distance
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
        shaped: Bools = np.array([pair.obstacle is not None for pair in pairs], dtype=bool)
        self.obstructed = shaped
        self._blocks: Ints = blocks[~shaped[blocks[:, 2]]]
        # contacts with surfaces are found before those with obstacles
        self._in_order = bool((np.diff(shaped.astype(np.int64)) >= 0).all())
        named = {one.obstacle.name: one.obstacle for one in pairs if one.obstacle is not None}
        self.poses = poses_at_start(tuple(named.values()))
        self._obstacle = {
            number: list(named).index(pair.obstacle.name)
            for number, pair in enumerate(pairs)
            if pair.obstacle is not None
        }
        self.sided = tuple(
            number
            for number, pair in enumerate(pairs)
            if pair.obstacle is not None and not isinstance(pair.obstacle.shape, PlaneShape)
        )
        self.loose = tuple(number for number, pair in enumerate(pairs) if pair.loose)
        self._sides: dict[int, Sides] = {}  # of pairs, in the step that is taken
        self._hits: dict[int, Hits] = {}  # likewise
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
        other.poses, other._sides, other._hits = poses, {}, {}
        return other

    def reaching(self, distance: float) -> ContactSet:
        """The same contacts, of which some in loose pairs are found up to another distance [m].

        These are `NEAREST` candidates of each pair outside the alarm distance, see `nearest_from_all_sides`.
        """
        other = copy(self)
        other.reach = max(distance, self.alarm_distance)
        return other

    def stepping(
        self, x: Array, ends: Sequence[Array], before: ObstaclePoses, far: bool = False
    ) -> ContactSet:
        """The same contacts in a step, in which candidates stay on the side of obstacles where they were.

        Args:
            x: (n_vertices, 3) positions at its start [m].
            ends: likewise, at its end if nothing touches, and where else contacts are detected in it.
            before: poses of the obstacles at its start.
            far: whether candidates beyond the alarm distance of any obstacle may meet it.
        """
        other = copy(self)
        other._sides, other._hits = {}, {}
        reach = self.alarm_distance if far else np.inf
        for number in self._obstacle if far else self.sided:
            pair, obstacle = self.pairs[number], self._obstacle[number]
            poses = before.poses[obstacle], self.poses.poses[obstacle]
            assert pair.obstacle is not None
            start, *there = (pair.candidates(at) for at in (x, *ends))
            found = [
                sides_of(pair.obstacle, (start, poses[0]), (end, poses[1]), reach) for end in there
            ]
            if any(len(one.place) for one in found):
                other._sides[number] = joined(found)
        for number in self.loose:
            pair = self.pairs[number]
            arrays = pair.nodes, pair.weights, pair.triangles
            hits = hits_of(x, ends[0], arrays, pair.loose)
            if hits is not None:
                other._hits[number] = hits
        return other

    def positions(self, x: Array) -> Array:
        """Positions of all candidates at vertex positions x (n_vertices, 3): (n_c, 3) [m]."""
        positions: Array = np.einsum("mj,mji->mi", self._weights, x[self._nodes])
        return positions

    def detect(self, x: Array) -> Detection:
        """Gaps of the candidates in range at vertex positions x (n_vertices, 3) [m].

        Never fails: a candidate or a triangle at a position that is not finite is out of range.
        """
        x, n = np.ascontiguousarray(x, dtype=float), self.n_slots
        numbers, values = np.empty((2, n), np.int64), np.empty((2, n))
        vectors, vertices, coefficients = (
            np.empty((2, n, 3)),
            np.empty((n, 6), np.int64),
            np.empty((n, 6)),
        )
        found = numbers, values, vectors, vertices, coefficients
        of_candidates = self._nodes, self._weights, self._friction
        distances = self.reach, self.distance
        m = detect_all(x, of_candidates, self._blocks, self._surfaces, distances, found)
        if self.reach > self.alarm_distance:
            m = self._near_or_next(found, m)
        for number, hits in self._hits.items():
            pair = self.pairs[number]
            of_pair = (number, self._first[number], pair.friction), (pair.nodes, pair.weights)
            of_hits = hits.place, hits.vertices, hits.weights
            m = add_hits(x, of_hits, of_pair, self.distance, found, m)
        for number in self._obstacle:
            m = self._touching(number, x, found, m)
        in_order = self._in_order and not self._hits
        every = slice(m) if in_order else np.argsort(numbers[0, :m])
        detection = Detection(
            n, numbers[0][every], numbers[1][every], values[0][every], vectors[0][every],
            vectors[1][every], values[1][every], vertices[every], coefficients[every],
        )  # fmt: skip
        if self._obstacle and self.poses.move:
            return replace(detection, surface=self._surface(detection))
        return detection

    def _near_or_next(self, found: _Found, m: int) -> int:
        """Keep of m contacts those within the alarm distance, and the nearest of loose pairs; how many."""
        pair, away = found[0][1, :m], found[1][0, :m] + self.distance
        keep = np.abs(away) < self.alarm_distance
        for number in self.loose:
            beyond = np.flatnonzero((pair == number) & (away >= self.alarm_distance))
            of_pair = away[beyond], pair[beyond], found[2][1, beyond]
            keep[beyond[nearest_from_all_sides(*of_pair, NEAREST)]] = True
        kept = np.flatnonzero(keep)
        for values in found[:3]:
            values[:, : len(kept)] = values[:, kept]
        for values in found[3:]:
            values[: len(kept)] = values[kept]
        return len(kept)

    def _touching(self, number: int, x: Array, found: _Found, m: int) -> int:
        """Add the candidates within reach of the obstacle of a pair to m others; how many there are then."""
        pair, first = self.pairs[number], int(self._first[number])
        assert pair.obstacle is not None
        place, points = np.empty(len(pair.nodes), np.int64), np.zeros((len(pair.nodes), 3))
        count = finite_candidates(x, pair.nodes, pair.weights, place, points)
        near, reach = points[:count], self.alarm_distance
        pose = self.poses.poses[self._obstacle[number]]
        gap, normal = pair.obstacle.closest(near, pose, reach)
        if number in self._sides and count == len(points):
            gap, normal = self._sides[number].corrected(near, pose, (gap, normal), reach)
            reach = np.inf
        nearest = np.ascontiguousarray(gap, dtype=float), np.ascontiguousarray(normal, dtype=float)
        of_pair = (number, first, pair.friction), (pair.nodes, pair.weights)
        distances = reach, self.distance
        return add_candidates_near((place, near), nearest, of_pair, distances, found, m)

    def _surface(self, found: Detection) -> Array:
        """Velocity of the obstacle at the nearest point of each contact (m, 3), zero of others [m/s]."""
        surface = np.zeros_like(found.point)
        for number, obstacle in self._obstacle.items():
            pose = self.poses.poses[obstacle]
            own = np.flatnonzero(found.pair == number)
            if pose.moves and len(own) > 0:
                way = (found.gap[own] + self.distance)[:, None] * found.normal[own]
                surface[own] = pose.velocity_at(found.point[own] - way)
        return surface


@kernel
def detect_all(
    x: Array, candidates: tuple[Ints, Array, Array], blocks: Ints, surfaces: SurfaceTopology,
    distances: tuple[float, float], out: _Found,
) -> int:  # fmt: skip
    """Number of contacts with surfaces, which are written to the arrays of `Detection`.

    Args:
        x: (n_vertices, 3) positions [m].
        candidates: (n_c, 3) vertices of the candidates of all pairs and (n_c, 3) their weights, and
            coefficients of friction of the pairs.
        blocks: (b, 3) candidates that are treated together, see `blocks_of`.
        surfaces: target surfaces of the pairs.
        distances: the alarm distance, and the one at which surfaces are held [m].
        out: output: slots and pairs (2, n_c), gaps and friction (2, n_c), points and normals (2, n_c, 3),
            vertices (n_c, 6), coefficients (n_c, 6).
    """
    (reach, held), (nodes, weights, friction) = distances, candidates
    numbers, values, vectors, vertices, coefficients = out
    k, triangles = 0, surfaces.triangles
    for block in range(blocks.shape[0]):
        begin, end, pair = blocks[block]
        points = np.zeros((3, end - begin))
        for s in range(begin, end):
            for j in range(3):
                for i in range(3):
                    points[i, s - begin] += weights[s, j] * x[nodes[s, j], i]
        found = no_closest_points(end - begin)
        triangle, inside = found.triangle, found.weights
        search(x, points, surfaces, pair, begin, reach, found)
        for s in range(begin, end):
            i = s - begin
            if triangle[i] < 0:
                continue
            numbers[0, k], numbers[1, k] = s, pair
            values[0, k], values[1, k] = found.gap[i] - held, friction[pair]
            for j in range(3):  # entry by entry, which is faster than slices of three
                vectors[0, k, j], vectors[1, k, j] = points[j, i], found.normal[i, j]
                vertices[k, j], vertices[k, 3 + j] = nodes[s, j], triangles[triangle[i], j]
                coefficients[k, j], coefficients[k, 3 + j] = weights[s, j], -inside[i, j]
            k += 1
    return k


@kernel
def add_candidates_near(
    candidates: tuple[Ints, Array], found: tuple[Array, Array],
    pair: tuple[tuple[int, int, float], tuple[Ints, Array]], distances: tuple[float, float],
    out: _Found, m: int,
) -> int:  # fmt: skip
    """Number of contacts after those within reach of an obstacle are written behind m others.

    Args:
        candidates: (k,) their numbers in their pair, and (k, 3) where they are [m].
        found: distances (k,) [m] and normals (k, 3).
        pair: its number, first slot and friction; vertices (n, 3) of its candidates and their weights.
        distances: the alarm distance, and the one at which surfaces are held [m].
        out: output, see `detect_all`.
        m: contacts in it.
    """
    (place, points), (gap, normal) = candidates, found
    (number, first, friction), (nodes, weights) = pair
    numbers, values, vectors, vertices, coefficients = out
    for at in range(len(gap)):
        if not gap[at] < distances[0]:
            continue
        s = place[at]
        numbers[0, m], numbers[1, m] = first + s, number
        values[0, m], values[1, m] = gap[at] - distances[1], friction
        for i in range(3):
            vectors[0, m, i], vectors[1, m, i] = points[at, i], normal[at, i]
            vertices[m, i] = vertices[m, 3 + i] = nodes[s, i]
            coefficients[m, i], coefficients[m, 3 + i] = weights[s, i], 0.0
        m += 1
    return m
