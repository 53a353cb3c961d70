"""Triangle surfaces: the boundary of a tetrahedral mesh, points spread evenly over a surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from tauten.model.numerics import Array, Ints, kernel, row_keys

# Corners of the faces of a positively oriented tetrahedron, seen from outside counter-clockwise.
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])

SAMPLES_PER_POINT = 40  # how much denser the surface is sampled than it is to be covered
MOST_POINTS = 100_000  # that a spacing may make
HOLE_SAMPLES = 1000  # of a surface, about, among which its largest hole is
TIE = 1e-6  # of lengths relative to the spacing; what differs by less is a tie, won by the lower number
NEAREST = 8  # points among which a sample has its nearest one; more are not equally near
SAME_POINT = 1e-7  # of the size; STL repeats the corners of its triangles
RELAXATIONS = 20  # Lloyd steps; positions move by less than a sample spacing after about ten


def boundary_triangles(tets: Ints) -> Ints:
    """Faces (t, 3) that belong to one tetrahedron of tets (e, 4) only, outward, in the order of these."""
    boundary: Ints = tets[:, FACES].reshape(-1, 3)[faces_used_once(tets)]
    return boundary


def boundary_owners(tets: Ints) -> Ints:
    """The tetrahedron behind each of the `boundary_triangles` of tets (e, 4): (t,)."""
    owners: Ints = faces_used_once(tets) // 4
    return owners


def faces_used_once(tets: Ints) -> Ints:
    """Places of the boundary among the faces (4 e,) of tetrahedra (e, 4): (t,), ascending."""
    faces = tets[:, FACES].reshape(-1, 3)  # (4 e, 3)
    keys = row_keys(np.sort(faces, axis=1))
    _, first, count = np.unique(keys, return_index=True, return_counts=True)
    places: Ints = np.sort(first[count == 1])
    return places


def uncancelled_triangles(tets: Ints) -> Ints:
    """Faces (t, 3) of tets (e, 4) that no other tetrahedron passes in the opposite direction, each once.

    Where no tetrahedra overlap these are the `boundary_triangles`. Where some lie on the same side of a face,
    the face is kept, and the winding number of the surface is positive wherever a tetrahedron is.
    """
    faces = tets[:, FACES].reshape(-1, 3)  # (4 e, 3), seen from outside counter-clockwise
    order = np.argsort(faces, axis=1)
    sign = np.where((order[:, 1] - order[:, 0]) % 3 == 1, 1.0, -1.0)  # of the permutation
    _, face = np.unique(row_keys(np.sort(faces, axis=1)), return_inverse=True)
    left = np.bincount(face, sign)[face]  # (4 e,)
    places = np.flatnonzero(sign * left > 0.0)
    _, first = np.unique(face[places], return_index=True)
    return np.asarray(faces[places[np.sort(first)]])


def area_normals(corners: Array) -> Array:
    """Normals (t, 3) of triangles (t, 3, 3), counter-clockwise seen from outside: twice the areas [m²]."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def unit_normals(corners: Array) -> Array:
    """Unit normals (t, 3) of triangles (t, 3, 3), counter-clockwise seen from outside; zero of flat ones."""
    normals = area_normals(corners)
    length = np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    found: Array = normals / length[:, None]
    return found


def triangle_areas(vertices: Array, triangles: Ints) -> Array:
    """Area of each triangle: (t,) [m²]."""
    areas: Array = 0.5 * np.linalg.norm(area_normals(vertices[triangles]), axis=1)
    return areas


def spread_points(vertices: Array, triangles: Ints, count: int) -> tuple[Ints, Array]:
    """Points spread evenly over a surface, each representing about the same area.

    A dense sampling of the surface is thinned by farthest-point selection (Gonzalez 1985) and
    relaxed towards the centroidal Voronoi tessellation (Lloyd 1982). The outermost points end half
    a spacing inside the border: a small slip between two facing surfaces does not move them beyond
    the border of the other one. Distances are Euclidean, so that on a surface folded more tightly than
    the spacing the cells of both sides mix.

    Deterministic: meshes are often symmetric, and between samples that are equally far but for rounding the
    lower number decides, so that compilers and processors agree on the points.

    Args:
        vertices: (v, 3) positions [m].
        triangles: (t, 3) vertex ids.
        count: number of points.

    Returns:
        Vertex ids (count, 3) of the triangle each point lies in, and its barycentric weights
        (count, 3), positive with row sums 1.

    Raises:
        ValueError: `count` is not positive or the surface has no area.
    """
    if count < 1:
        raise ValueError(f"count is {count}, at least one point is needed")
    area = float(triangle_areas(vertices, triangles).sum())
    if not area > 0.0:
        raise ValueError(f"the surface of {len(triangles)} triangles has no area")
    owner, weights = dense_samples(vertices, triangles, area / (SAMPLES_PER_POINT * count))
    nodes = triangles[owner]  # (s, 3)
    samples = np.einsum("si,sij->sj", weights, vertices[nodes])  # (s, 3)
    chosen = farthest_points(samples, count)
    tie = TIE * np.sqrt(area / count)
    for _ in range(RELAXATIONS):
        moved = nearest_to_centroids(samples, chosen, tie)
        if np.array_equal(moved, chosen):
            break
        chosen = moved
    chosen = np.sort(chosen)
    return nodes[chosen], weights[chosen]


def vertex_points(triangles: Ints) -> tuple[Ints, Array]:
    """A point at each vertex of a surface (t, 3).

    Returns:
        The vertices of a triangle around each point (p, 3), the point's own first, and its barycentric
        weights (p, 3).
    """
    _, first = np.unique(triangles, return_index=True)
    turned = (first[:, None] % 3 + np.arange(3)) % 3  # (p, 3)
    nodes = np.take_along_axis(triangles[first // 3], turned, axis=1)
    return nodes, np.tile([1.0, 0.0, 0.0], (len(nodes), 1))


def covering_points(vertices: Array, triangles: Ints, spacing: float) -> tuple[Ints, Array]:
    """Points at each vertex of a surface, along its edges, and over its area, as of `spread_points`.

    Args:
        vertices: (v, 3) positions [m].
        triangles: (t, 3) vertex ids.
        spacing: largest distance of neighbours on an edge, and about that of neighbours elsewhere [m].

    Raises:
        ValueError: the surface has no area, or these would be more than `MOST_POINTS`.
    """
    area = float(triangle_areas(vertices, triangles).sum())
    sides = np.concatenate([triangles, triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]])
    _, first = np.unique(np.sort(sides[:, :2], axis=1), axis=0, return_index=True)
    edges = sides[np.sort(first)]  # (e, 3), the first two are the ends
    lengths = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    count = area / spacing**2 + float(lengths.sum()) / spacing
    if count > MOST_POINTS:
        raise ValueError(
            f"spacing = {spacing:g} m would make {count:.0e} candidates, allowed are {MOST_POINTS}: "
            "make it larger"
        )
    spread = spread_points(vertices, triangles, max(1, round(area / spacing**2)))
    nodes, weights = [], []
    for side, length in zip(edges, lengths.tolist(), strict=True):
        parts = int(np.ceil(length / spacing - TIE))
        share = np.arange(1, parts) / max(parts, 1)
        nodes.append(np.tile(side, (len(share), 1)))
        weights.append(np.stack([1.0 - share, share, 0.0 * share], axis=1))
    corners = vertex_points(triangles)
    return (
        np.concatenate([corners[0], *nodes, spread[0]]),
        np.concatenate([corners[1], *weights, spread[1]]),
    )


def largest_hole(vertices: Array, triangles: Ints, points: Array) -> float:
    """Largest distance of a place on a surface from the nearest of some points, about [m].

    Args:
        vertices: (v, 3) positions [m].
        triangles: (t, 3) vertex ids.
        points: (p, 3) of the surface [m].
    """
    area = float(triangle_areas(vertices, triangles).sum())
    owner, weights = dense_samples(vertices, triangles, area / HOLE_SAMPLES)
    samples = np.einsum("si,sij->sj", weights, vertices[triangles[owner]])
    return float(cKDTree(points).query(samples)[0].max())


def dense_samples(vertices: Array, triangles: Ints, area: float) -> tuple[Ints, Array]:
    """Triangles (s,) and weights (s, 3) of the centres of their d² equal parts, none larger than `area` [m²].

    Args:
        vertices: (v, 3) positions [m].
        triangles: (t, 3) vertex ids.
        area: largest area of a part [m²].
    """
    areas = triangle_areas(vertices, triangles)
    divisions = np.ceil(np.sqrt(areas / area) - TIE).astype(np.int64)  # 0 of a flat triangle
    owner, weights = [], []
    for d in np.unique(divisions[divisions > 0]):
        members = np.flatnonzero(divisions == d)
        centres = part_centres(int(d))
        owner.append(np.repeat(members, len(centres)))
        weights.append(np.tile(centres, (len(members), 1)))
    order = np.argsort(np.concatenate(owner), kind="stable")
    return np.concatenate(owner)[order], np.concatenate(weights)[order]


def part_centres(d: int) -> Array:
    """Barycentric centres of a triangle's d² congruent parts: (d², 3)."""
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(d), np.arange(d), indexing="ij"))
    upright, inverted = i + j < d, i + j < d - 1
    first = np.concatenate([i[upright] + 1 / 3, i[inverted] + 2 / 3]) / d
    second = np.concatenate([j[upright] + 1 / 3, j[inverted] + 2 / 3]) / d
    return np.stack([1.0 - first - second, first, second], axis=1)


@kernel
def farthest_points(samples: Array, count: int) -> Ints:
    """Samples chosen one by one, each farthest from the ones before: ids (count,).

    The first is the one farthest from the centre of all.
    """
    chosen = np.empty(count, dtype=np.int64)
    distance = np.full(samples.shape[0], np.inf)
    from_x = samples[:, 0].mean()
    from_y = samples[:, 1].mean()
    from_z = samples[:, 2].mean()
    for k in range(count):
        best, farthest = 0, -1.0
        for s in range(samples.shape[0]):
            dx, dy, dz = samples[s, 0] - from_x, samples[s, 1] - from_y, samples[s, 2] - from_z
            here = min(distance[s], dx * dx + dy * dy + dz * dz)
            if k > 0:  # the centre is not one of the points
                distance[s] = here
            if here > (1.0 + TIE) * farthest:
                best, farthest = s, here
        chosen[k] = best
        from_x, from_y, from_z = samples[best, 0], samples[best, 1], samples[best, 2]
    return chosen


def nearest_to_centroids(samples: Array, chosen: Ints, tie: float) -> Ints:
    """One Lloyd step: for each chosen sample the one nearest to the centroid of its cell (c,).

    Args:
        samples: (s, 3) points of the surface [m].
        chosen: (c,) numbers of the chosen ones.
        tie: distances that differ by less are the same [m].
    """
    cell = nearest_of(samples[chosen], samples, tie)  # (s,)
    size = np.bincount(cell, minlength=len(chosen))
    sums = [np.bincount(cell, samples[:, i], minlength=len(chosen)) for i in range(3)]
    centroid = np.stack(sums, axis=1) / np.maximum(size, 1)[:, None]  # (c, 3)
    distance = np.linalg.norm(samples - centroid[cell], axis=1)
    least = np.full(len(chosen), np.inf)
    np.minimum.at(least, cell, distance)
    nearest = np.flatnonzero(distance <= least[cell] + tie)  # ascending
    filled, first = np.unique(cell[nearest], return_index=True)
    moved = chosen.copy()
    moved[filled] = nearest[first]
    return moved


def nearest_of(points: Array, samples: Array, tie: float) -> Ints:
    """Number of the point nearest to each sample, the lowest one of those equally near: (s,).

    Args:
        points: (c, 3) [m].
        samples: (s, 3) [m].
        tie: distances that differ by less are the same [m].
    """
    tree, count = cKDTree(points), len(points)
    distance, number = tree.query(samples, k=[1, 2])  # (s, 2); inf and count without a second one
    nearest: Ints = number[:, 0]
    tied = np.flatnonzero(distance[:, 1] <= distance[:, 0] + tie)
    distance, number = tree.query(samples[tied], k=np.arange(1, min(NEAREST, count) + 1))
    equal = distance <= distance[:, :1] + tie
    nearest[tied] = np.where(equal, number, count).min(axis=1, initial=count)
    return nearest


def welded(corners: Array) -> tuple[Array, Ints]:
    """Vertices (v, 3) and triangles (t, 3) of triangles (t, 3, 3) that repeat their corners."""
    points = corners.reshape(-1, 3)
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    cells = np.round((points - low) / (SAME_POINT * size)) if size > 0.0 else np.zeros_like(points)
    _, first, number = np.unique(
        cells.astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    triangles = number.reshape(-1, 3)
    a, b, c = triangles.T
    return points[first], triangles[(a != b) & (b != c) & (a != c)]
