"""Where one looks from: presets that show the whole robot, and how large it is in the window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import viser

from tauten.model.numerics import Array
from tauten.service.frames import RobotLook

Preset = Literal["fit", "front", "side", "top"]
PRESETS: tuple[Preset, ...] = ("fit", "front", "side", "top")
FIELD_OF_VIEW = np.radians(40.0)  # from bottom to top
_SAME = 1e-3  # of the robot's size, within which two places of a camera are the same
SHEET = 0.42  # of a phone's window, under the panel
_HEIGHT, _WIDTH = 0.5, 0.45  # of the window, that the robot takes
PANEL = 335  # pixels of the window's width under the panel, where that is beside the robot
_FIRST = 1.5  # width of a window over its height, which all browsers start with
_USUAL = 1400  # pixels of its width
WEIGHTLESS = 1e-6  # m/s²
_NARROW = 0.8  # aspect below which the panel is at the bottom of the window, as on a phone


@dataclass(frozen=True, slots=True)
class Camera:
    """Where one looks from, and at what.

    Attributes:
        position: (3,) [m].
        look_at: (3,) [m].
    """

    position: Array
    look_at: Array


def camera_of(
    look: RobotLook, preset: Preset, aspect: float = _FIRST, width_in_pixels: int = _USUAL
) -> Camera:
    """The camera that shows a robot at rest half as high as the window, or nearly half as wide as is free.

    Args:
        look: of the robot.
        preset: from where.
        aspect: width of the window over its height; narrow ones have the panel at the bottom.
        width_in_pixels: of the window, whose others have the panel at their right side.
    """
    up = np.array(upwards(look.robot.gravity))
    right, back = sideways(up)
    out = {
        "fit": 0.35 * right - back + 0.25 * up,
        "front": -back,
        "side": right,
        "top": up - 1e-3 * back,  # straight down has no upwards
    }[preset]
    out = out / np.linalg.norm(out)
    x = np.cross(up, out)
    x /= np.linalg.norm(x)
    y = np.cross(out, x)
    corners = look.vertices.astype(float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = 0.5 * (low + high)
    width, height, depth = (float(np.ptp((corners - middle) @ one)) for one in (x, y, out))
    narrow = aspect < _NARROW
    free = 1.0 - SHEET if narrow else 1.0  # of the window's height
    tangent = np.tan(0.5 * FIELD_OF_VIEW)
    beside = 0.0 if narrow else min(PANEL / max(width_in_pixels, 1), 0.5)  # of the window's width
    aspect_free = aspect * (1.0 - beside)
    half = max(height / (_HEIGHT * free), width / (_WIDTH * aspect_free), 0.2 * look.robot.size)
    distance = 0.5 * half / tangent + 0.5 * depth
    shift = -0.5 * (1.0 - free) * 2.0 * distance * tangent  # of the middle of the free part
    # and what is nearest is in the middle beside the panel
    look_at = middle + shift * y + 0.5 * beside * aspect * half * x
    return Camera(look_at + distance * out, look_at)


def place_first(server: viser.ViserServer, look: RobotLook) -> None:
    """Start all browsers with the robot in the middle; in narrow windows smaller, or above the panel."""
    first, camera = camera_of(look, "fit"), server.initial_camera
    camera.position, camera.look_at = tuple(first.position), tuple(first.look_at)
    camera.fov = float(FIELD_OF_VIEW)
    camera.near, camera.far = 0.02 * look.robot.size, 100.0 * look.robot.size

    async def connected(client: viser.ClientHandle) -> None:
        if client.camera.aspect >= _FIRST:
            return
        fitted = False

        async def moved(now: viser.CameraHandle) -> None:
            """Fit it once the browser has the camera that all start with: before, that would override it."""
            nonlocal fitted
            away = float(np.linalg.norm(now.position - first.position))
            if not fitted and away < _SAME * look.robot.size:
                fitted = True
                show_preset(client, look, "fit")

        client.camera.on_update(moved)
        await moved(client.camera)

    server.on_client_connect(connected)


def show_preset(client: viser.ClientHandle, look: RobotLook, preset: Preset) -> None:
    """Move the camera of one browser."""
    wanted = camera_of(look, preset, client.camera.aspect, client.camera.image_width)
    with client.atomic():
        client.camera.position = wanted.position
        client.camera.look_at = wanted.look_at


def upwards(gravity: tuple[float, float, float]) -> tuple[float, float, float]:
    """The direction against gravity; without gravity that of z."""
    size = float(np.linalg.norm(gravity))
    if size < WEIGHTLESS:
        return (0.0, 0.0, 1.0)
    x, y, z = (-float(part) / size for part in gravity)
    return x, y, z


def sideways(up: Array) -> tuple[Array, Array]:
    """Unit vectors to the right and away from somebody who looks at the robot from the front.

    Where the unit vector upwards (3,) is that of z they are those of x and y.
    """
    x = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
    right: Array = x - (x @ up) * up
    right /= np.linalg.norm(right)
    return right, np.cross(up, right)
