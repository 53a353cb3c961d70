"""From a robot to its description, for the wire, logs, streams and the viewer."""

from __future__ import annotations

import platform

from tauten.model import ObstacleOutline, held_vertices, obstacles_of, skin_of
from tauten.model.numerics import Array
from tauten.service.log import description_metadata
from tauten.service.process import versions
from tauten.service.setup import Setup
from tauten.service.wire import (
    DescribedActuator,
    DescribedBasis,
    DescribedEffector,
    DescribedModel,
    DescribedObstacle,
    DescribedRod,
    DescribedSurface,
    RobotDescription,
)


def describe(setup: Setup, start: Array | None = None) -> RobotDescription:
    """The description of a robot, in SI units.

    Args:
        setup: the robot.
        start: (n_v,) goal values of the effectors where the model starts; None: where it is undeformed.
    """
    robot = setup.robot
    skin, (gx, gy, gz) = skin_of(robot), robot.gravity.tolist()
    return RobotDescription(
        robot=robot.name,
        frame=robot.frame,
        rate=robot.integration.rate,
        start=setup.start,
        target_timeout=setup.service.lasting(robot.h).target_timeout,
        size=robot.size,
        gravity=(gx, gy, gz),
        actuators=_actuators(setup),
        effectors=_effectors(
            setup, robot.effector_values(robot.rest()) if start is None else start
        ),
        surface=DescribedSurface(
            vertices=len(skin.used),
            triangles=skin.triangles,
            segments=robot.actuator_set.segment_owners,
            chambers=robot.body.chamber_owners,
            held=held_vertices(robot, skin),
            objects=robot.body.of_objects,
            obstacles=tuple(map(_obstacle, obstacles_of(robot))),
            pairs=tuple(pair.name for pair in robot.pairs),
            friction=tuple(pair.friction for pair in robot.contacts.pairs),
        ),
        model=DescribedModel(
            order=setup.order,
            digest=robot.digest,
            states=setup.states_digest(),
            factorisation=robot.body.linear_solver,
            mesh_error=setup.mesh_error,
            nodes=robot.n_nodes,
            elements=robot.body.n_elements,
            unknowns=robot.n,
            candidates=robot.n_c,
        ),
        basis=DescribedBasis(
            name=setup.basis_name, digest=setup.basis_digest(), modes=setup.basis_modes
        ),
        versions={
            "system": f"{platform.system()} {platform.machine()}",
            "python": platform.python_version(),
            **versions(),
        },
    )


def _obstacle(one: ObstacleOutline) -> DescribedObstacle:
    """An obstacle; a round one without its triangles."""
    position, quaternion = tuple(one.pose.position.tolist()), tuple(one.pose.quaternion.tolist())
    if one.rod is None:
        return DescribedObstacle(
            name=one.name, position=position, quaternion=quaternion, vertices=one.vertices,
            triangles=one.triangles,
        )  # fmt: skip
    ends = tuple(one.rod.start.tolist()), tuple(one.rod.along.tolist())
    rod = DescribedRod(start=ends[0], along=ends[1], radius=one.rod.radius, flat=one.rod.flat)
    return DescribedObstacle(name=one.name, position=position, quaternion=quaternion, rod=rod)


def _actuators(setup: Setup) -> tuple[DescribedActuator, ...]:
    actuators, limits = setup.robot.actuators, setup.robot.limits
    springs = actuators.laws.springs
    return tuple(
        DescribedActuator(
            name=name,
            kind=kind,
            effort=(float(limits.effort_min[i]), float(limits.effort_max[i])),
            position=(float(limits.position_min[i]), float(limits.position_max[i])),
            rate=float(limits.rate[i]),
            flexibility=float(springs.flexibility[i]) if springs is not None else 0.0,
        )
        for i, (name, kind) in enumerate(zip(actuators.names, actuators.kinds, strict=True))
    )


def _effectors(setup: Setup, start: Array) -> tuple[DescribedEffector, ...]:
    layout = setup.robot.effector_layout
    return tuple(
        DescribedEffector(
            name=name,
            kind=layout.kinds[i],
            rest=tuple(start[layout.values_of(i)].tolist()),
            weight=tuple(layout.weights[layout.rows_of(i)].tolist()),
            exact=bool(layout.exact[layout.rows_of(i)].any()),
        )
        for i, name in enumerate(layout.names)
    )


def log_metadata(setup: Setup, start: Array | None = None) -> dict[str, str]:
    """Metadata of a log of a run: the robot's description and its file."""
    return {
        **description_metadata(describe(setup, start)),
        "robot_path": str(setup.path),
        "robot_file": setup.path.read_text(encoding="utf-8"),
    }
