"""A cable that is drawn by clicking points of the skin, and saved to the robot file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import viser

from tauten.model import ActuatorKind, Floats, RobotFileError
from tauten.model.mesh import ray_crossings
from tauten.model.numerics import Array, Ints
from tauten.service.frames import RobotLook
from tauten.service.new import TENSION, NewCable, add_cable

COLOUR = (150, 0, 150)
_OUTSIDE = 0.01  # of the robot's size


@dataclass(frozen=True, slots=True)
class SkinPoint:
    """A point of the skin that moves with it.

    Attributes:
        corners: (3,) vertices of its triangle.
        weights: (3,) of them, which sum to one.
    """

    corners: Ints
    weights: Array

    def at(self, vertices: Floats) -> Array:
        """Its position (3,) where the vertices are (P, 3) [m]."""
        position: Array = self.weights @ vertices[self.corners].astype(float)
        return position


class CableDrawing:
    """The cable that is being drawn."""

    def __init__(self, scene: viser.SceneApi, look: RobotLook, file: Path) -> None:
        self._scene, self._look, self._file = scene, look, file
        self._points: list[SkinPoint] = []
        self._saved: list[str] = []
        self._dots: viser.PointCloudHandle | None = None
        self._line: viser.LineSegmentsHandle | None = None

    def __len__(self) -> int:
        return len(self._points)

    @property
    def rest(self) -> Array:
        """Its points at rest (p, 3) [m]."""
        found = [point.at(self._look.vertices) for point in self._points]
        return np.array(found).reshape(-1, 3)

    def click(self, origin: Array, direction: Array, vertices: Floats) -> None:
        """Add the first point of the skin on a ray, if there is one.

        Args:
            origin: (3,) of the ray [m].
            direction: (3,) of the ray.
            vertices: (P, 3) of the skin now [m].
        """
        found = first_hit(
            origin, direction, vertices.astype(float), self._look.robot.surface.triangles
        )
        if found is not None:
            self._points.append(found)

    def undo(self) -> None:
        """Remove the last point."""
        if self._points:
            self._points.pop()

    def draw(self, vertices: Floats) -> None:
        """Show points and line where the vertices are (P, 3) [m]."""
        points = np.array([point.at(vertices) for point in self._points], np.float32)
        if (
            self._dots is not None
            and self._line is not None
            and len(self._dots.points) == len(points)
        ):
            self._dots.points, self._line.points = points, pieces_of(points)
            return
        self._scene.remove_by_name("/drawing")
        self._dots = self._line = None
        if len(points) == 0:
            return
        self._dots = self._scene.add_point_cloud(
            "/drawing/points", points, COLOUR, point_size=0.03 * self._look.robot.size,
            point_shape="circle", precision="float32",
        )  # fmt: skip
        self._line = self._scene.add_line_segments(
            "/drawing/line", pieces_of(points), COLOUR, thickness=0.008 * self._look.robot.size
        )

    def save(self, name: str) -> str:
        """Append the cable to the robot file and begin another; what to tell the user."""
        name = name.strip()
        limits = [
            one.effort[1] for one in self._look.robot.actuators if one.kind is ActuatorKind.CABLE
        ]
        cable = NewCable(
            name, self.rest, limits[0] if limits else TENSION, _OUTSIDE * self._look.robot.size
        )
        try:
            if not name.isidentifier() or name in self._saved:
                raise RobotFileError(
                    f"{name[:40]!r} is no new name of a cable: letters, digits and _ are allowed"
                )
            add_cable(self._file, cable)
        except (RobotFileError, OSError) as error:
            return f"not saved: {error}"
        self._points.clear()
        self._saved.append(name)
        return (
            f"{name} is saved to {self._file.name}; `tauten check {self._file}` says what to look at. "
            "The robot here has not changed: start the viewer again."
        )


def pieces_of(points: Floats) -> Floats:
    """Pieces (m − 1, 2, 3) of a line through points (m, 3); of one point a piece without length."""
    if len(points) == 1:
        return np.repeat(points[None], 2, axis=1)
    return np.stack([points[:-1], points[1:]], axis=1)


def first_hit(
    origin: Array, direction: Array, vertices: Array, triangles: Ints
) -> SkinPoint | None:
    """The first point of triangles on a ray; None where there is none.

    Args:
        origin: (3,) of the ray [m].
        direction: (3,) of the ray, of any length.
        vertices: (P, 3) [m].
        triangles: (t, 3) of the vertices.
    """
    u, v, distance = ray_crossings(origin, direction, vertices[triangles])
    hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 0.0)
    if not hit.any():
        return None
    t = int(np.argmin(np.where(hit, distance, np.inf)))
    return SkinPoint(triangles[t], np.array([1.0 - u[t] - v[t], u[t], v[t]]))
