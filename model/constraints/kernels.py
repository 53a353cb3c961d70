"""Kernels of `Frames` and of the map to the nodes: loops over what moves with a frame."""

from __future__ import annotations

import numpy as np

from tauten.model.numerics import (
    Array,
    Bools,
    Ints,
    Vector3,
    cross,
    dot,
    kernel,
    quaternion,
    rotate,
    row,
    scale,
)


@kernel
def place_frames(
    poses: Array,
    theta: Array,
    owner: Ints,
    offsets: Array,
    axes: Array,
    through: Array,
    turns: Bools,
) -> tuple[Array, Array]:
    """Positions and levers, both (k, 3), of `Frames.place`.

    Args:
        poses: (n_turning, 7) position and unit quaternion of the rigid and pinned regions.
        theta: (n_drives,) angles and travels.
        owner: (k,) region of each node.
        offsets: (k, 3) at rest [m].
        axes: (n_drives, 3) unit directions.
        through: (n_drives, 3) points of the axes [m].
        turns: (n_drives,) whether a drive turns its region.
    """
    k, n_turning = owner.shape[0], poses.shape[0]
    x, levers = np.empty((k, 3)), np.empty((k, 3))
    for i in range(k):
        r, region = row(offsets, i), owner[i]
        if region < n_turning:
            lever = rotate(quaternion(poses[:, 3:], region), r)
            for c in range(3):
                x[i, c], levers[i, c] = poses[region, c] + lever[c], lever[c]
            continue
        drive = region - n_turning
        axis, angle = row(axes, drive), theta[drive]
        if turns[drive]:
            across, along = cross(axis, r), scale(dot(axis, r), axis)
            cosine, sine = np.cos(angle), np.sin(angle)
            r = (
                cosine * (r[0] - along[0]) + sine * across[0] + along[0],
                cosine * (r[1] - along[1]) + sine * across[1] + along[1],
                cosine * (r[2] - along[2]) + sine * across[2] + along[2],
            )
            lever = cross(axis, r)
        else:
            r = (r[0] + angle * axis[0], r[1] + angle * axis[1], r[2] + angle * axis[2])
            lever = axis
        for c in range(3):
            x[i, c], levers[i, c] = through[drive, c] + r[c], lever[c]
    return x, levers


@kernel
def centripetal_rates(
    omega: Array, rate: Array, owner: Ints, levers: Array, axes: Array, turns: Bools
) -> Array:
    """Accelerations (k, 3) of `Frames.centripetal` [m/s²].

    Args:
        omega: (n_turning, 3) angular velocities [rad/s].
        rate: (n_drives,) rates of the drives.
        owner: (k,) region of each node.
        levers: (k, 3) from `place_frames`.
        axes: (n_drives, 3) unit directions.
        turns: (n_drives,) whether a drive turns its region.
    """
    result = np.zeros(levers.shape)
    for i in range(owner.shape[0]):
        drive = owner[i] - omega.shape[0]
        if drive < 0:
            w = row(omega, owner[i])
            a = cross(w, cross(w, row(levers, i)))
        elif turns[drive]:
            a = scale(rate[drive] ** 2, cross(row(axes, drive), row(levers, i)))
        else:
            continue
        for c in range(3):
            result[i, c] = a[c]
    return result


@kernel
def lever_stiffness(
    owner: Ints, levers: Array, force: Array, axes: Array, turns: Bools, blocks: Array
) -> Array:
    """Add the blocks of `Frames.stiffness` to `blocks` (n_turning, 3, 3); those of drives: (n_drives,) [N m].

    Args:
        owner: (k,) region of each node.
        levers: (k, 3) from `place_frames`.
        force: (k, 3) on the nodes [N].
        axes: (n_drives, 3) unit directions.
        turns: (n_drives,) whether a drive turns its region.
        blocks: accumulated [N m].
    """
    drives = np.zeros(axes.shape[0])
    for i in range(owner.shape[0]):
        drive = owner[i] - blocks.shape[0]
        a: Vector3 = row(levers, i)
        f: Vector3 = row(force, i)
        if drive >= 0:
            if turns[drive]:  # ∂²x/∂θ² is the axis times the lever
                drives[drive] -= dot(cross(row(axes, drive), a), f)
            continue
        along = dot(a, f)
        for r in range(3):
            blocks[owner[i], r, r] += along
            for c in range(3):
                blocks[owner[i], r, c] -= 0.5 * (a[r] * f[c] + f[r] * a[c])
    return drives


@kernel
def transposed_product(indptr: Ints, indices: Ints, T: Array, f: Array, n: int) -> Array:
    """Tᵀ f (n,) for the first rows of T, as many as f has entries.

    Args:
        indptr: row starts of T.
        indices: its columns.
        T: its values.
        f: vector.
        n: columns of T.
    """
    product = np.zeros(n)
    for i in range(len(f)):
        for place in range(indptr[i], indptr[i + 1]):
            product[indices[place]] += T[place] * f[i]
    return product
