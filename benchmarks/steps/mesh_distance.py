"""How long the signed distances of contact candidates to an obstacle of triangles take."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from tauten.model import one_blas_thread
from tauten.model.contact import MeshShape
from tauten.model.numerics import Array, Ints
from tauten.service.process import HostInfo, host_info

CANDIDATES, REACH = 2000, 2e-3  # number, and alarm distance [m]
RADIUS, TUBE, AROUND, ACROSS = 0.05, 0.02, 100, 50  # of a ring of 10,000 triangles [m]
BEYOND = 1e-3  # smallest distance of candidates in range from the surface [m]
REPEATS = 300
SHARES = (0.0, 0.1, 0.5, 1.0)  # of the candidates that are in range


@dataclass(frozen=True, slots=True)
class DistanceRun:
    """Candidates of which a share is in range.

    Attributes:
        in_range: number of candidates in range.
        median: time of all distances [ms].
        p99: likewise.
        least: likewise.
    """

    in_range: int
    median: float
    p99: float
    least: float


@dataclass(frozen=True, slots=True)
class DistanceBench:
    """All runs.

    Attributes:
        machine: facts about it.
        triangles: of the obstacle.
        candidates: of each run.
        build: time to make tree and grid, with compiled kernels [ms].
        runs: one of each share.
    """

    machine: HostInfo
    triangles: int
    candidates: int
    build: float
    runs: tuple[DistanceRun, ...]


def ring() -> tuple[Array, Ints]:
    """A ring about the z axis: vertices (v, 3) [m] and triangles (t, 3)."""
    i, j = np.indices((AROUND, ACROSS))
    vertices = on_ring(2.0 * np.pi * i / AROUND, 2.0 * np.pi * j / ACROSS, TUBE)

    def number(one: Ints, other: Ints) -> Ints:
        found: Ints = ((one % AROUND) * ACROSS + other % ACROSS).ravel()
        return found

    a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return vertices.reshape(-1, 3), triangles


def on_ring(u: Array, v: Array, tube: Array | float) -> Array:
    """Points (…, 3) at angles around the axis and the tube, at a distance from its centre line [m].

    Args:
        u: (…) around the axis [rad].
        v: (…) around the tube [rad].
        tube: (…) distance from the centre line [m].
    """
    away = RADIUS + tube * np.cos(v)
    return np.stack([away * np.cos(u), away * np.sin(u), tube * np.sin(v)], axis=-1)


def bench_mesh_distance(progress: Callable[[float, str], None]) -> DistanceBench:
    """Time the distances of candidates on a patch of a surface, which are in its order, to a ring.

    Args:
        progress: called with the share of the work that has just been done, and what comes next.
    """
    surface = ring()
    MeshShape(*surface).closest_within(surface[0], REACH)  # compiles
    begin = perf_counter()
    shape = MeshShape(*surface)
    build, runs = 1e3 * (perf_counter() - begin), list[DistanceRun]()
    side = np.ceil(CANDIDATES**0.5)
    u = 2.0 * np.pi * np.floor(np.arange(CANDIDATES) / side) / side
    v = 2.0 * np.pi * (np.arange(CANDIDATES) % side) / side
    for share in SHARES:
        near = np.arange(CANDIDATES) < share * CANDIDATES  # a patch, as of a fingertip
        points = on_ring(u, v, np.where(near, TUBE + BEYOND, 2.0 * TUBE))
        times = list[float]()
        with one_blas_thread():
            for _ in range(REPEATS):
                begin = perf_counter()
                gap, _ = shape.closest_within(points, REACH)
                times.append(1e3 * (perf_counter() - begin))
        runs.append(
            DistanceRun(
                int((gap < REACH).sum()),
                float(np.median(times)),
                float(np.quantile(times, 0.99)),
                min(times),
            )
        )
        progress(1.0 / len(SHARES), f"{share:.0%} in range")
    return DistanceBench(host_info(), len(surface[1]), CANDIDATES, build, tuple(runs))
