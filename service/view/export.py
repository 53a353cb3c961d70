"""A run as one HTML file that plays by itself, without a server and without anything from elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tauten.service.frames import RobotLook, ViewFrame
from tauten.service.process import write_text
from tauten.service.view.scene import TRAIL, RobotScene
from tauten.service.view.server import open_server

_LAST = 1.0  # s for which the last frame remains


def write_html(look: RobotLook, frames: Iterable[ViewFrame], file: Path) -> int:
    """Write frames to an HTML file; returns how many.

    Args:
        look: of the robot.
        frames: in the order of their time.
        file: to write.

    Raises:
        OSError: the file cannot be written.
    """
    count, trail = 0, list[ViewFrame]()
    with open_server(0, look.robot.name) as (server, _):
        scene = RobotScene(server, look, draggable=False)
        recorder = None
        for frame in frames:
            if trail and recorder is not None:
                recorder.insert_sleep(max(frame.time - trail[-1].time, 0.0))
            trail = [one for one in trail if one.time > frame.time - TRAIL] + [frame]
            scene.draw(frame, trail)
            if recorder is None:  # starts with the scene as it is: the first frame
                recorder = server.get_scene_serializer()
            count += 1
        if recorder is None:
            return 0
        recorder.insert_sleep(_LAST)
        write_text(file, recorder.as_html())
    return count
