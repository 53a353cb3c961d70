"""The robot's description as JSON, the answer to a question on its key."""

from __future__ import annotations

import json
from typing import Any

from tauten.service.process import versions
from tauten.service.setup import Setup
from tauten.service.wire import HEALTH, JOINTS, POINT, TEXT, TICK, Keys


def description(setup: Setup) -> dict[str, Any]:
    """All that a client needs, in SI units; `tension` and `pull` of an actuator are in its units of both."""
    robot, keys = setup.robot, Keys(setup.robot.name)
    limits = robot.limits
    actuators = [
        {
            "name": name,
            "kind": kind.value,
            "units": {"tension": kind.effort.unit, "pull": kind.position.unit},
            "tension": [float(limits.tension_min[i]), float(limits.tension_max[i])],
            "pull": [float(limits.pull_min[i]), float(limits.pull_max[i])],
            "rate": float(limits.rate[i]),
        }
        for i, (name, kind) in enumerate(
            zip(robot.actuators.names, robot.actuators.kinds, strict=True)
        )
    ]
    rest = robot.effector(robot.rest())  # (p, 3)
    measured = keys.measurements(robot.effector_names)
    targets, published = keys.targets(robot.effector_names), keys.effectors(robot.effector_names)
    effectors = [
        {
            "name": name,
            "rest": [float(value) for value in rest[i]],
            "target": targets[i],
            "measurement": measured[i],
            "position": published[i],
            "type": POINT,
        }
        for i, name in enumerate(robot.effector_names)
    ]
    return {
        "robot": robot.name,
        "frame": robot.frame,
        "rate": robot.integration.rate,
        "target_timeout": setup.service.target_timeout,
        "size": robot.size,
        "actuators": actuators,
        "effectors": effectors,
        "keys": {
            "command": {"key": keys.command, "type": TEXT},
            "actuation": {"key": keys.actuation, "type": JOINTS},
            "tick": {"key": keys.tick, "type": TICK},
            "health": {"key": keys.health, "type": HEALTH},
        },
        "model": {
            "order": setup.order,
            "nodes": robot.n_nodes,
            "elements": robot.n_elements,
            "unknowns": robot.n,
            "candidates": robot.n_c,
            "digest": robot.digest,
            "factorisation": robot.linear_solver,
        },
        "basis": {
            "name": setup.basis_name,
            "modes": 0 if isinstance(setup.contact, str) else setup.contact.k,
            "digest": setup.basis_digest(),
        },
        "versions": versions(),
    }


def description_json(setup: Setup) -> bytes:
    """The description as JSON."""
    return json.dumps(description(setup), indent=1).encode()
