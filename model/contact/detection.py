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
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from tauten.model.contact.broad_phase import BLOCK
from tauten.model.contact.narrow_phase import no_closest_points, search
from tauten.model.contact.obstacle import ObstaclePoses, poses_at_start
from tauten.model.contact.pair import ContactPair, LargestSum, check_pair
from tauten.model.contact.surface_topology import SurfaceTopology, join_surfaces
from tauten.model.contacts import Contacts
from tauten.model.numerics import Array, Bools, Ints, kernel
from tauten.model.points import Entries, Placed
from tauten.model.rows import ContactRows, PairSlots, dense

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
        numbers, values = detect_all(
            x, self._nodes, self._weights, self._blocks, self._surfaces, distances
        )
        m = len(numbers) // 8
        found = Detection(
            self.n_slots, numbers[:m], numbers[m : 2 * m], values[:m],
            values[m : 4 * m].reshape(m, 3), values[4 * m : 7 * m].reshape(m, 3), values[7 * m : 8 * m],
            numbers[2 * m :].reshape(m, 6), values[8 * m :].reshape(m, 6),
        )  # fmt: skip
        if self.frictional:
            found = replace(found, friction=self._friction[found.pair])
        if not self._shaped:
            return found
        return merged([found, *(self._touching(number, x) for number in self._shaped)])

    def _touching(self, number: int, x: Array) -> Detection:
        """Candidates within reach of the obstacle of a pair, by its number."""
        pair, first = self.pairs[number], int(self._first[number])
        assert pair.obstacle is not None
        pose = self.poses.poses[self.poses.number(pair.obstacle.name)]
        points = np.einsum("mj,mji->mi", pair.weights, x[pair.nodes])
        place = np.flatnonzero(np.isfinite(points).all(axis=1))
        gap, normal = pair.obstacle.closest(points[place], pose, self.alarm_distance)
        near = gap < self.alarm_distance
        place, gap, normal = place[near], gap[near], normal[near]
        nodes, weights = pair.nodes[place], pair.weights[place]
        return Detection(
            n_slots=self.n_slots,
            slots=first + place,
            pair=np.full(len(place), number),
            gap=gap - self.distance,
            point=points[place],
            normal=np.ascontiguousarray(normal),
            friction=np.full(len(place), pair.friction),
            vertices=np.hstack([nodes, nodes]),
            coefficients=np.hstack([weights, np.zeros_like(weights)]),
            surface=pose.velocity_at(points[place] - gap[:, None] * normal) if pose.moves else None,
        )


def merged(parts: list[Detection]) -> Detection:
    """Candidates of different pairs as one record, with ascending slots."""
    order = np.argsort(np.concatenate([part.slots for part in parts]), kind="stable")

    def joined(name: str) -> Any:
        return np.concatenate([getattr(part, name) for part in parts])[order]

    return Detection(
        parts[0].n_slots, joined("slots"), joined("pair"), joined("gap"), joined("point"),
        joined("normal"), joined("friction"), joined("vertices"), joined("coefficients"),
        surface=_surfaces(parts, order),
    )  # fmt: skip


def _surfaces(parts: list[Detection], order: Ints) -> Array | None:
    """Velocities of the surfaces that are touched, in an order; None where nothing moves."""
    if all(part.surface is None for part in parts):
        return None
    found = [np.zeros((len(p), 3)) if p.surface is None else p.surface for p in parts]
    joined: Array = np.concatenate(found)[order]
    return joined


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
    distances: tuple[float, float],
) -> tuple[Ints, Array]:
    """The arrays of a `Detection` one after the other: its integers (8 m,), and its other numbers (14 m,).

    Args:
        x: (n_vertices, 3) positions [m].
        nodes: (n_c, 3) vertices of the candidates of all pairs.
        weights: (n_c, 3) their weights.
        blocks: (b, 3) candidates that are treated together, see `blocks_of`.
        surfaces: target surfaces of the pairs.
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
        gap[k] = found.gap[s] - held
        for j in range(3):  # entry by entry, which is faster than slices of three
            point[k, j], normal[k, j] = points[j, s], found.normal[s, j]
            vertices[k, j], vertices[k, 3 + j] = nodes[s, j], triangles[triangle[s], j]
            coefficients[k, j], coefficients[k, 3 + j] = weights[s, j], -inside[s, j]
    return numbers, values


def contact_rows(detection: Detection, placed: Placed, frictional: bool = False) -> ContactRows:
    """Contact rows H_c (m, n) with the gaps (T2), and rows across the normals where there is friction.

    Args:
        detection: candidates in range.
        placed: the vertices at this state.
        frictional: whether any pair has friction.
    """
    vectors = np.empty((6 * len(detection.gap), 3))
    gap_vectors(detection.coefficients, detection.normal, vectors)
    starts = np.arange(0, len(vectors) + 1, 6)
    rows = placed.many_rows(Entries(starts, detection.vertices.ravel(), vectors), detection.gap)
    if not (frictional and detection.friction.any()):
        return ContactRows(rows, detection)
    return ContactRows(rows, detection, PlacedTangents(detection, placed))


@dataclass(frozen=True, slots=True)
class PlacedTangents:
    """Rows of the relative motion across the normals; those are computed that are used.

    Attributes:
        detection: candidates in range.
        placed: the vertices at this state.
    """

    detection: Detection
    placed: Placed

    def chosen(self, rows: Ints) -> Array:
        """Two rows for each of some candidates (r,), in the order of `Contacts.tangents`: (2 r, n).

        The relative motion of the point of a candidate and of what it touches, as in (T2), with a tangent
        instead of the normal.
        """
        both, found = np.repeat(rows, 2), self.detection
        vectors = np.empty((6 * len(both), 3))
        gap_vectors(found.coefficients[both], found.tangents(rows).reshape(-1, 3), vectors)
        points = found.vertices[both].ravel()
        return dense(self.placed.rows(Entries(np.arange(0, len(points) + 1, 6), points, vectors)))


@kernel
def gap_vectors(coefficients: Array, normal: Array, vectors: Array) -> None:
    """Derivatives of the gaps by their vertices (T2).

    Args:
        coefficients: (m, 6) of the vertices.
        normal: (m, 3) unit normals.
        vectors: (6 m, 3) output.
    """
    for k in range(normal.shape[0]):
        for j in range(6):
            for i in range(3):
                vectors[6 * k + j, i] = coefficients[k, j] * normal[k, i]
