"""The robot's description as JSON, the answer to a question on its key."""

from __future__ import annotations

import base64
import json
from typing import Any

from tauten.model import skin_of
from tauten.model.numerics import Array, Ints
from tauten.service.process import versions
from tauten.service.setup import Setup
from tauten.service.wire import CLOUD, HEALTH, JOINTS, MESSAGE_TYPES, TEXT, TICK, Keys


def description(setup: Setup, start: Array) -> dict[str, Any]:
    """All that a client needs, in SI units; `effort` and `position` of an actuator are in its units of both.

    Args:
        setup: the robot.
        start: (n_v,) goal values of the effectors where the model starts.
    """
    robot, keys = setup.robot, Keys(setup.robot.name)
    limits, springs = robot.limits, robot.actuators.laws.springs
    actuators = [
        {
            "name": name,
            "kind": kind.value,
            "units": {"effort": kind.effort.unit, "position": kind.position.unit},
            "effort": [float(limits.effort_min[i]), float(limits.effort_max[i])],
            "position": [float(limits.position_min[i]), float(limits.position_max[i])],
            "rate": float(limits.rate[i]),
            "flexibility": float(springs.flexibility[i]) if springs is not None else 0.0,
        }
        for i, (name, kind) in enumerate(
            zip(robot.actuators.names, robot.actuators.kinds, strict=True)
        )
    ]
    layout = robot.effector_layout
    measured = keys.measurements(robot.effector_names)
    targets, published = keys.targets(robot.effector_names), keys.effectors(robot.effector_names)
    effectors = [
        {
            "name": name,
            "kind": layout.kinds[i],
            "rest": start[layout.values_of(i)].tolist(),
            "weight": layout.weights[layout.rows_of(i)].tolist(),
            "exact": bool(layout.exact[layout.rows_of(i)].any()),
            "target": targets[i],
            "measurement": measured[i],
            "position": published[i],
            "type": MESSAGE_TYPES[layout.kinds[i]],
        }
        for i, name in enumerate(robot.effector_names)
    ]
    skin = skin_of(robot)
    surface = {
        "key": keys.surface,
        "contacts": keys.contacts,
        "type": CLOUD,
        "vertices": len(skin.used),
        "triangles": numbers_text(skin.triangles),
        "segments": numbers_text(robot.segment_owners),
        "chambers": numbers_text(robot.chamber_owners + 1),
    }
    return {
        "robot": robot.name,
        "frame": robot.frame,
        "rate": robot.integration.rate,
        "target_timeout": setup.service.target_timeout,
        "size": robot.size,
        "gravity": [float(part) for part in robot.gravity],
        "actuators": actuators,
        "effectors": effectors,
        "surface": surface,
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


def numbers_text(numbers: Ints) -> str:
    """Whole numbers as little-endian uint32 in base64: triangles would be most of the text otherwise."""
    return base64.b64encode(numbers.astype("<u4").tobytes()).decode("ascii")


def description_json(setup: Setup, start: Array) -> bytes:
    """The description as JSON, for arguments of `description`."""
    return json.dumps(description(setup, start), indent=1).encode()
