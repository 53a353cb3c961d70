"""What is around the robot in the picture: ground with its scale, base, obstacles, direction of gravity."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from tauten.model import Floats
from tauten.model.numerics import Array, Ints
from tauten.service.frames import RobotLook
from tauten.service.view.picture.arrows import Arrows
from tauten.service.view.picture.cameras import WEIGHTLESS, sideways, upwards
from tauten.service.view.picture.round_numbers import rounded_down

GRAVITY, BASE, OBSTACLE = (128, 128, 128), (70, 76, 84), (170, 140, 100)
_GRID = (150, 150, 150)
_ARROW = 0.15  # length of the arrow of gravity, as a share of the robot's size
_BESIDE = 0.55  # where it is, from the middle
_ABOVE = 0.62  # where a text is above the middle, as a share of that size
_GROUND = 1.5  # side of the ground, as a multiple of the robot's size
_SCALE = 0.4  # where the scale is, to the left and in front of the middle, as a share of that size
_BELOW = 0.1  # of the robot's size, below one that hangs
_UNDER = 2e-3  # of that size, under a floor that it stands on: in one plane they would flicker
_CELLS = 8.0  # cells of the ground on the robot's size, about


def draw_surroundings(server: viser.ViserServer, look: RobotLook) -> list[viser.MeshHandle]:
    """Add all to a scene; the obstacles, which may move."""
    _draw_ground(server.scene, look)
    _draw_base(server.scene, look)
    _draw_gravity(server.scene, look)
    return [
        server.scene.add_mesh_simple(
            f"/obstacles/{i}", *_arrays(*one.outline),
            wxyz=one.quaternion, position=one.position, color=OBSTACLE, opacity=0.6, side="double",
            flat_shading=True, cast_shadow=False, receive_shadow=False,
        )
        for i, one in enumerate(look.robot.surface.obstacles)
    ]  # fmt: skip


def _arrays(vertices: Array, triangles: Ints) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Vertices (v, 3) and triangles (t, 3) as the scene takes them."""
    return vertices.astype(np.float32), triangles.astype(np.uint32)


def cell_size(size: float) -> float:
    """Length of a cell of the ground of a robot of some size [m]: 1, 2 or 5 times a power of ten."""
    return rounded_down(size / _CELLS)


def above(look: RobotLook) -> Array:
    """A point (3,) above the robot, for a text [m]."""
    up = np.array(upwards(look.robot.gravity))
    found: Array = middle_of(look.vertices) + _ABOVE * look.robot.size * up
    return found


def middle_of(vertices: Floats) -> Array:
    """The middle (3,) between the least and the largest coordinates of vertices (v, 3) [m]."""
    middle: Array = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0)).astype(float)
    return middle


def scale_text(look: RobotLook) -> str:
    """What a cell of the ground is long, in words."""
    return f"cells of the ground: {length_text(cell_size(look.robot.size))}"


def length_text(length: float) -> str:
    """A length [m] with its unit."""
    return f"{length:g} m" if length >= 1.0 else f"{round(1e3 * length, 6):g} mm"


def ground_height(look: RobotLook) -> float:
    """Height of the ground along the upward direction [m]: under the robot, or below one that hangs."""
    heights = look.vertices.astype(float) @ np.array(upwards(look.robot.gravity))
    low, high = float(heights.min()), float(heights.max())
    held = heights[look.robot.surface.held]
    hangs = len(held) > 0 and float(held.mean()) > 0.5 * (low + high)
    return low - _BELOW * look.robot.size if hangs else low


def _draw_ground(scene: viser.SceneApi, look: RobotLook) -> None:
    up, cell = np.array(upwards(look.robot.gravity)), cell_size(look.robot.size)
    right, back = sideways(up)
    middle = middle_of(look.vertices)
    middle += (ground_height(look) - _UNDER * look.robot.size - float(middle @ up)) * up
    side = cell * float(np.ceil(_GROUND * look.robot.size / cell / 2.0)) * 2.0
    along = np.arange(-0.5 * side, 0.5 * side + 0.5 * cell, cell)  # (l,)
    half = 0.5 * side * np.array([-1.0, 1.0])
    lines = [
        middle + along[:, None, None] * one + half[:, None] * other
        for one, other in ((right, back), (back, right))
    ]
    scene.add_line_segments(
        "/ground", np.concatenate(lines).astype(np.float32), _GRID, thickness=0.6,
        thickness_units="screen",
    )  # fmt: skip
    first = -cell * float(np.floor(_SCALE * look.robot.size / cell))
    corner = middle + first * (right + back)  # of the cell that the scale lies along
    scene.add_label(
        "/scale", length_text(cell), position=corner + 0.5 * cell * right, anchor="top-center"
    )
    ends = np.stack([corner, corner + cell * right])[None].astype(np.float32)
    scene.add_line_segments("/ground_scale", ends, GRAVITY, thickness=0.012 * look.robot.size)


def _draw_base(scene: viser.SceneApi, look: RobotLook) -> None:
    """The part of the skin that is held; nothing where the skin moves everywhere."""
    surface = look.robot.surface
    still = np.isin(surface.triangles, surface.held).all(axis=1) & (surface.chambers < 0)
    if not still.any():
        return
    used, corners = np.unique(surface.triangles[still], return_inverse=True)
    vertices = look.vertices[used]
    scene.add_mesh_simple(
        "/base", vertices, corners.reshape(-1, 3).astype(np.uint32), color=BASE, side="double",
        flat_shading=True, cast_shadow=False, receive_shadow=False,
    )  # fmt: skip
    right, _ = sideways(np.array(upwards(look.robot.gravity)))
    beside = 0.5 * np.ptp(vertices.astype(float) @ right) + 0.04 * look.robot.size  # to the left
    scene.add_label(
        "/base/name", "base", position=middle_of(vertices) - beside * right, anchor="center-right"
    )


def _draw_gravity(scene: viser.SceneApi, look: RobotLook) -> None:
    """An arrow along gravity beside the robot; none without gravity."""
    if np.linalg.norm(look.robot.gravity) < WEIGHTLESS:
        return
    size, up = look.robot.size, np.array(upwards(look.robot.gravity))
    right, _ = sideways(up)
    start = middle_of(look.vertices) + _BESIDE * size * right + 0.5 * _ARROW * size * up
    ends = np.stack([start, start - _ARROW * size * up])[None]  # (1, 2, 3)
    arrow = Arrows(scene, "/gravity", GRAVITY, size, (0.004, 0.012, 0.03))
    arrow.draw(ends.astype(np.float32))
    scene.add_label("/gravity/name", "g", position=start, anchor="bottom-center")
