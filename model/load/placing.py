"""Where a body stands: from its own coordinates into the robot's frame and back."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tauten.model.numerics import Array
from tauten.model.schema import BodySettings


def placed(nodes: Array, body: BodySettings) -> Array:
    """A body's own coordinates (n_nodes, 3) in the robot's frame: (n_nodes, 3) [m]."""
    nodes = turned(nodes, body)
    return nodes + np.array(body.position) if any(body.position) else nodes


def turned(vectors: Array, body: BodySettings) -> Array:
    """Vectors (m, 3) in a body's own axes along those of the robot's frame: (m, 3)."""
    if body.rotation is None:
        return vectors
    w, x, y, z = body.rotation.unit_quaternion
    found: Array = Rotation.from_quat([x, y, z, w]).apply(vectors)
    return found


def taken_back(nodes: Array, body: BodySettings) -> Array:
    """The inverse of `placed`: nodes (n_nodes, 3) in the robot's frame in a body's own coordinates [m]."""
    moved: Array = nodes - np.array(body.position)
    if body.rotation is not None:
        w, x, y, z = body.rotation.unit_quaternion
        moved = Rotation.from_quat([x, y, z, w]).apply(moved, inverse=True)
    return moved
