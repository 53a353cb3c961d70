"""How one looks at the robot: buttons for the camera and for light and dark, and the panel of a phone.

They change what one browser shows, and never what another one does.
"""

from __future__ import annotations

import viser

from tauten.service.frames import ReachSet, RobotLook, ViewFrame
from tauten.service.view.picture import (
    PRESETS,
    SHEET,
    ForceNumbers,
    Preset,
    RobotScene,
    StrainSkin,
    show_preset,
    strain_bar,
)
from tauten.service.view.web import LoopbackServer

_LIGHT, _DARK = "light", "dark"
# On a phone viser puts the panel at the bottom, over more than half of the window and not as wide as it.
_SHEET = '[style*="bottom: 0"][style*="max-height: 60%"]'
# The field beside a slider has room for five characters: a run has more than 100.00 s.
_STYLE = f"""<style>.mantine-Slider-root + .mantine-NumberInput-root {{ width: 4.5rem !important }}
@media (max-width: 36em) {{
{_SHEET} {{ max-height: {100 * SHEET:.0f}% !important; width: 100% !important }}
{_SHEET} [style*="width: 20em"] {{ width: 100% !important }}
}}</style>"""


class Viewing:
    """The folder *View* of the panel.

    Attributes:
        for_all: what every browser may give its inputs, those that look on included.
    """

    def __init__(self, server: LoopbackServer, look: RobotLook, reaches: bool) -> None:
        gui = server.gui
        presets: dict[str, Preset] = {one: one for one in PRESETS}

        async def look_from(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            preset = presets.get(event.target.value)
            if event.client is not None and preset is not None:
                show_preset(event.client, look, preset)

        async def colour(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            if event.client is not None:
                await server.colours.choose(event.client, event.target.value == _DARK)

        self._skin, self._numbers = StrainSkin(server.scene, look), ForceNumbers(server.scene, look)
        gui.add_html(_STYLE)
        self._reach: viser.GuiCheckboxHandle | None = None
        with gui.add_folder("View"):
            camera = gui.add_button_group("from", PRESETS, hint="Where one looks from.")
            theme = gui.add_button_group(
                "colours", (_LIGHT, _DARK), hint="Until one chooses, as the browser prefers."
            )
            self._forces = gui.add_checkbox(
                "forces", False, hint="Numbers of forces, and arrows of those along cables."
            )
            self._strain = gui.add_checkbox(
                "strain", False, hint="Largest principal strain of the skin, from its form at rest."
            )
            self._bar = gui.add_html("")
            if reaches:
                self._reach = gui.add_checkbox(
                    "reach", False, hint="Where the effector gets, by the model that decides."
                )
        camera.on_click(look_from)
        theme.on_click(colour)
        self.for_all: dict[str, frozenset[bool | str]] = {
            camera._impl.uuid: frozenset(PRESETS),
            theme._impl.uuid: frozenset((_LIGHT, _DARK)),
        }

    @property
    def shows_reach(self) -> bool:
        """Whether the reach of the effector is shown."""
        return self._reach is not None and bool(self._reach.value)

    @property
    def wanted(self) -> tuple[bool, bool]:
        """Whether forces have numbers, and the skin the colours of its strain."""
        return bool(self._forces.value), bool(self._strain.value)

    @property
    def strain(self) -> float | None:
        """Strain at the end of the colours; None while they are not shown."""
        return self._skin.end if self._strain.value else None

    def draw(self, frame: ViewFrame, scene: RobotScene) -> None:
        """Show the strain of a frame, and numbers of its forces, where they are wanted."""
        forces, strained = self.wanted
        scene.show_skin(not strained)
        self._skin.draw(frame.geometry.vertices if strained else None)
        self._numbers.draw(frame if forces else None)
        self._bar.content = strain_bar(self._skin.end) if strained else ""

    def show_progress(self, found: ReachSet, possible: bool) -> None:
        """Show how much of the reach is known; the box is grey where the effector cannot have one."""
        if self._reach is None:
            return
        self._reach.disabled = not possible
        part = f" {len(found.points)}/{found.wanted}" if found.wanted else " …"
        if found.failed:
            part = " failed"
        done = found.complete and not found.failed
        self._reach.label = "reach" + (part if possible and self.shows_reach and not done else "")
