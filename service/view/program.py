"""Waypoints as a short program: its part of the panel, and what moves the target through them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from queue import SimpleQueue

import viser

from tauten.model.numerics import Array
from tauten.service.frames import RobotLook, TargetStore, WaypointList
from tauten.service.plant import PathError, TargetPath
from tauten.service.process import drained
from tauten.service.view.web import LoopbackServer
from tauten.service.view.words import Words

_SLOWEST, _FASTEST = 1.0, 500.0  # mm/s of the target
_ADD, _UP, _DOWN, _REMOVE = "set", "up", "down", "remove"
_GO, _PLAY, _END = "go", "play", "end"
_CLEAR, _SAVE = "clear", "save"
_NONE = "none"
_MOST_ACTIONS = 1000


class WaypointProgram:
    """Waypoints of each effector, and the path that its target is on.

    Attributes:
        uploads: inputs that get files.
    """

    def __init__(self, server: LoopbackServer, look: RobotLook, targets: TargetStore) -> None:
        """Add the inputs. Callbacks of the browser only note what happened; `advance` reads it."""
        self._server, self._targets, self._look = server, targets, look
        self._lists = [WaypointList(one, look.robot.size) for one in look.robot.effectors]
        self._actions: SimpleQueue[str | viser.UploadedFile] = SimpleQueue()
        self._path: tuple[TargetPath, float, bool] | None = None  # path, begin [s], whether all
        self._shown: tuple[int, tuple[str, ...]] | None = None
        self._names = tuple(one.name for one in look.robot.effectors)
        gui = server.gui
        with gui.add_folder("Waypoints", expand_by_default=False):
            self._effector: viser.GuiDropdownHandle[str] | None = None
            if len(self._names) > 1:
                self._effector = gui.add_dropdown("effector", self._names)
            self._chosen = gui.add_dropdown("waypoint", (_NONE,))
            self._buttons(
                (_ADD, _UP, _DOWN, _REMOVE),
                "set: add the target's position after the chosen one. up, down, remove: the chosen one.",
            )
            self._pace = gui.add_slider("speed [mm/s]", _SLOWEST, _FASTEST, 1.0, 30.0)
            self._loop = gui.add_checkbox("loop", False, hint="Play again from the first one.")
            self._buttons(
                (_GO, _PLAY, _END),
                "go: straight to the chosen one. play: straight to the first one, then through all.",
            )
            self._buttons((_CLEAR, _SAVE), "save: as tauten stream reads them.")
            load = gui.add_upload_button(
                "load CSV", mime_type=".csv", hint="As tauten stream reads it, up to 48 kB."
            )
            self._words = gui.add_html("")
        load.on_upload(self._on_upload)
        self.uploads = frozenset((load._impl.uuid,))

    @property
    def effector(self) -> int:
        """Number of the effector that is chosen."""
        if self._effector is None or self._effector.value not in self._names:
            return 0
        return self._names.index(str(self._effector.value))

    @property
    def waypoints(self) -> WaypointList:
        """Of the effector that is chosen."""
        return self._lists[self.effector]

    def follow(self, path: TargetPath, now: float) -> None:
        """Move the first effector's target along a path."""
        self._path = path, now, False

    def end(self) -> None:
        """Leave the target where it is."""
        self._path = None

    def advance(self, now: float, show: Callable[[Array], None]) -> None:
        """Do what was asked for, and move the target."""
        for action in islice(drained(self._actions), _MOST_ACTIONS):
            self._say("")
            self._load(action) if isinstance(action, viser.UploadedFile) else self._do(action, now)
        shown = self.effector, self.waypoints.names()
        if shown != self._shown:
            self._shown = shown
            self._list(shown[1])
            show(self.waypoints.points)
        self._move(now)

    def _move(self, now: float) -> None:
        if self._path is None or not self._targets.armed:
            self._path = None
            return
        path, begin, whole = self._path
        self._targets.put(self.effector, path.at(now - begin))
        if now - begin <= path.duration or path.repeats:
            return
        self._path = None
        if whole and self._loop.value and len(self.waypoints) > 1:
            self._play(now)

    def _play(self, now: float) -> None:
        start = self._targets.of(self.effector)
        self._path = self.waypoints.path(start, self._speed), now, True

    @property
    def _speed(self) -> float:
        """Of the target [m/s]."""
        return 1e-3 * min(max(float(self._pace.value), _SLOWEST), _FASTEST)

    @property
    def _number(self) -> int:
        """Of the waypoint that is chosen, from 0; −1 without any."""
        names = self.waypoints.names()
        return names.index(self._chosen.value) if self._chosen.value in names else len(names) - 1

    def _do(self, action: str, now: float) -> None:
        waypoints, number = self.waypoints, self._number
        if action == _ADD:
            if waypoints.add(self._targets.of(self.effector)):
                for place in range(len(waypoints) - 1, number + 1, -1):
                    waypoints.move(place, -1)
                number += 1
        elif action in (_UP, _DOWN):
            number = waypoints.move(number, -1 if action == _UP else 1)
        elif action == _REMOVE:
            waypoints.remove(number)
        elif action == _CLEAR:
            waypoints.clear()
            self._path = None
        elif action == _SAVE:
            self._save()
        elif action == _END:
            self._path = None
        elif len(waypoints):
            self._start(action, number, now)
        self._list(waypoints.names(), number)

    def _start(self, action: str, number: int, now: float) -> None:
        if not self._targets.armed:
            self._say("switch “follow” on: the target moves only then")
        elif action == _PLAY:
            self._play(now)
        else:
            start = self._targets.of(self.effector)
            self._path = self.waypoints.straight(start, number, self._speed), now, False

    def _load(self, file: viser.UploadedFile) -> None:
        try:
            self.waypoints.load(file.content.decode("utf-8"), file.name)
        except UnicodeDecodeError:
            self._say(f"{file.name}: not a text file")
        except PathError as error:
            self._say(str(error))

    def _save(self) -> None:
        content = self.waypoints.csv(self._speed).encode()
        onlookers = self._server.onlookers
        for number, client in self._server.get_clients().items():
            if number not in onlookers:  # the browser that operates
                client.send_file_download("waypoints.csv", content, save_immediately=True)

    def _list(self, names: tuple[str, ...], number: int | None = None) -> None:
        """Show the waypoints, with one of them chosen."""
        options = names or (_NONE,)
        chosen = self._chosen.value
        if number is not None and names:
            chosen = names[min(max(number, 0), len(names) - 1)]
        if self._chosen.options != options:
            self._chosen.options = options
        if chosen not in options:
            chosen = options[-1]
        self._chosen.value = chosen  # type: ignore[misc]  # viser types it so

    def _say(self, words: str) -> None:
        self._words.content = Words(advice=words).html

    def _buttons(self, names: tuple[str, ...], hint: str) -> None:
        async def callback(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            if event.target.value in names:
                self._actions.put(str(event.target.value))

        self._server.gui.add_button_group("", names, hint=hint).on_click(callback)

    async def _on_upload(self, event: viser.GuiEvent[viser.GuiUploadButtonHandle]) -> None:
        self._actions.put(event.target.value)
