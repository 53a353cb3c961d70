"""Arrows in the picture: of forces, and of the direction of gravity."""

from __future__ import annotations

import viser

from tauten.model import Floats


class Arrows:
    """Arrows of one colour, in the scene from the first ones on, and hidden while there are none."""

    def __init__(
        self,
        scene: viser.SceneApi,
        name: str,
        colour: tuple[int, int, int],
        size: float,
        shape: tuple[float, float, float],
    ) -> None:
        """Add nothing yet.

        Args:
            scene: that shows them.
            name: of the node in the scene.
            colour: red, green and blue.
            size: of the robot [m].
            shape: radius of the shafts, radius and length of the heads, as shares of that size.
        """
        self._scene, self._name, self._colour = scene, name, colour
        self._shaft, self._head, self._length = (share * size for share in shape)
        self._handle: viser.ArrowsHandle | None = None

    def draw(self, points: Floats) -> None:
        """Show arrows from points to others: (m, 2, 3) [m]."""
        if self._handle is not None:
            self._handle.visible = len(points) > 0
        if len(points) == 0:
            return
        if self._handle is None:
            self._handle = self._scene.add_arrows(
                self._name, points, self._colour, shaft_radius=self._shaft, head_radius=self._head,
                head_length=self._length,
            )  # fmt: skip
        self._handle.points = points
