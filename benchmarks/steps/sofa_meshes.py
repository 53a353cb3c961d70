"""Steps on the meshes that SOFA computed with, beside SOFA's published times."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.physics import diamond, finger, trunk
from benchmarks.steps.stages import StepTimes, time_steps
from tauten.model import one_blas_thread
from tauten.model.numerics import Array
from tauten.service.bench import (
    WARM_UP,
    Sizes,
    forward_steps,
    sizes_of,
)
from tauten.service.process import HostInfo, Progress, host_info
from tauten.service.replay import Spread

# Median of SOFA v25.06 with SoftRobots.Inverse on a quiet AMD EPYC at 2.25 GHz with 2 cores, one thread, as
# published with the reference data and, of the finger, with the request for these times [ms]
SOFA_MS = {"diamond inverse": 22.0, "trunk forward": 8.4, "finger forward": 22.4}


@dataclass(frozen=True, slots=True)
class SofaMeshTimes:
    """Steps of one robot on the mesh that SOFA computed with, without contact.

    Attributes:
        robot: its name.
        sizes: of its problems.
        forward_ms: a simulator's step under a growing pull of all its cables, of the trunk of the first one.
        inverse: a controller's steps with their stages.
        sofa_ms: published medians of SOFA by kind of step, from another computer.
    """

    robot: str
    sizes: Sizes
    forward_ms: Spread
    inverse: StepTimes
    sofa_ms: dict[str, float]


@dataclass(frozen=True, slots=True)
class SofaMeshBench:
    """Everything `python -m benchmarks sofa-meshes` measures."""

    machine: HostInfo
    robots: tuple[SofaMeshTimes, ...]


def bench_sofa_meshes(data: Path, steps: int, progress: Progress) -> SofaMeshBench:
    """Time forward and inverse steps of trunk, diamond and finger on the meshes that SOFA computed with.

    SOFA is not run: its medians are published ones, from another computer. The trunk moves forward with its
    first cable alone, as there, and inversely with all eight.

    Args:
        data: folder of the reference data.
        steps: to measure of each kind.
        progress: called with the share of the work that has just been done.
    """
    models = data / "sofa_robots"
    legs, bent = diamond(models), finger(data, refinements=1)
    cases = (
        ("diamond", legs, legs, circle(np.array([0.0, 0.0, 0.115]), steps)),
        ("trunk", trunk(models, ("L0",)), trunk(models), circle(np.array([0.0, 0.0, 0.19]), steps)),
        ("finger", bent, bent, None),
    )
    found = []
    with one_blas_thread():
        for name, pulled, led, targets in cases:
            forward, reached = forward_steps(pulled, steps)
            followed = reached[:, None] if targets is None else targets
            found.append(
                SofaMeshTimes(
                    robot=name,
                    sizes=sizes_of(led),
                    forward_ms=forward,
                    inverse=time_steps(led, "none", "none", followed, warm_up=WARM_UP),
                    sofa_ms={
                        kind: SOFA_MS[f"{name} {kind}"]
                        for kind in ("forward", "inverse")
                        if f"{name} {kind}" in SOFA_MS
                    },
                )
            )
            progress(1.0 / len(cases))
    return SofaMeshBench(host_info(), tuple(found))


def circle(centre: Array, steps: int, radius: float = 0.02) -> Array:
    """Targets (steps + WARM_UP, 1, 3) once round a circle in a plane of constant z [m].

    Args:
        centre: (3,) of the circle [m].
        steps: on the circle; before them the target moves from its centre to its first point.
        radius: of the circle [m].
    """
    angle = np.concatenate([np.zeros(WARM_UP), np.linspace(0.0, 2.0 * np.pi, steps)])
    size = radius * np.concatenate([np.linspace(0.0, 1.0, WARM_UP), np.ones(steps)])
    offset = np.stack([size * np.cos(angle), size * np.sin(angle), np.zeros_like(angle)], axis=1)
    targets: Array = (centre + offset)[:, None]
    return targets
