"""`python -m benchmarks contact-loop`: controllers in contact with a wall and with an object.

Plants have steps of their own and pointwise contact in full order; their friction and mass may be others
than controllers believe.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from benchmarks.control.lift import CUBES, MODELS, RESERVES, LiftBench, LiftRun, ReserveRun
from benchmarks.control.wall import CONTROLLERS, WallBench, WallRun
from tauten.model import one_blas_thread
from tauten.service.process import HostInfo, Progress, StopFlag, host_info


@dataclass(frozen=True, slots=True)
class ContactBench:
    """Everything the benchmark measures.

    Attributes:
        machine: facts about it.
        wall_depth_mm: of targets behind the wall, of the controller that does not know it.
        wall_plant_steps: steps of the plant in a period.
        lift_plant_steps: the same.
        wall: one a controller, in open and closed loop.
        lift: one a model and a cube, in open and closed loop.
        reserves: lifts whose decisions leave more or less of the friction.
        complete: whether all runs were done.
    """

    machine: HostInfo
    wall_depth_mm: float
    wall_plant_steps: int
    lift_plant_steps: int
    wall: tuple[WallRun, ...]
    lift: tuple[LiftRun, ...]
    reserves: tuple[ReserveRun, ...]
    complete: bool


def bench_contact(stop: StopFlag, progress: Progress) -> ContactBench:
    """Do all runs, or as many as are done when `stop` is raised.

    Args:
        stop: raised to end early.
        progress: called with the share of the work that has just been done, and what comes next.
    """
    walls, lifts, reserves = list[WallRun](), list[LiftRun](), list[ReserveRun]()
    runs = 2 * len(CONTROLLERS) + 2 * len(MODELS) * len(CUBES) + len(RESERVES)
    share = 1.0 / (runs + 2)
    with one_blas_thread():
        progress(0.0, "how far behind the wall")
        wall, lift = WallBench(), LiftBench()
        progress(2.0 * share, "wall")
        for closed in (False, True):
            for controller in CONTROLLERS:
                if not stop.requested:
                    progress(0.0, f"wall, controller knows {controller}")
                    walls.append(wall.run(controller, closed))
                    progress(share, "wall")
        for model, (mass, friction), closed in product(MODELS, CUBES, (False, True)):
            if not stop.requested:
                progress(0.0, f"{model}, cube, mass x {mass:g}, friction x {friction:g}")
                lifts.append(lift.run(model, mass, friction, closed))
                progress(share, "cube")
        for friction_share, min_slip_margin in RESERVES:
            if not stop.requested:
                progress(0.0, f"full, cube, share of friction {friction_share:g}")
                reserves.append(lift.with_reserve(friction_share, min_slip_margin))
                progress(share, "cube")
    return ContactBench(
        machine=host_info(),
        wall_depth_mm=1e3 * wall.depth,
        wall_plant_steps=wall.plant.steps,
        lift_plant_steps=lift.plant_steps or 0,
        wall=tuple(walls),
        lift=tuple(lifts),
        reserves=tuple(reserves),
        complete=not stop.requested,
    )
