"""How one looks at the robot: buttons for the camera and for light and dark, and the panel of a phone.

They change what one browser shows, and never what another one does.
"""

from __future__ import annotations

import viser

from tauten.service.frames import RobotLook
from tauten.service.view.picture import PRESETS, SHEET, Preset, show_preset
from tauten.service.view.web import set_theme

_LIGHT, _DARK = "light", "dark"
# On a phone viser puts the panel at the bottom, over more than half of the window and not as wide as it.
_SHEET = '[style*="bottom: 0"][style*="max-height: 60%"]'
_STYLE = f"""<style>@media (max-width: 36em) {{
{_SHEET} {{ max-height: {100 * SHEET:.0f}% !important; width: 100% !important }}
{_SHEET} [style*="width: 20em"] {{ width: 100% !important }}
}}</style>"""


def add_viewing(gui: viser.GuiApi, look: RobotLook) -> dict[str, frozenset[bool | str]]:
    """Add the buttons; returns what every browser may give them, those that look on included.

    Args:
        gui: that gets them.
        look: of the robot.
    """
    presets: dict[str, Preset] = {one: one for one in PRESETS}

    async def look_from(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        preset = presets.get(event.target.value)
        if event.client is not None and preset is not None:
            show_preset(event.client, look, preset)

    async def colour(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        if event.client is not None:
            set_theme(event.client.gui, event.target.value == _DARK)

    gui.add_html(_STYLE)
    with gui.add_folder("View"):
        camera = gui.add_button_group("from", PRESETS, hint="Where one looks from.")
        theme = gui.add_button_group("colours", (_LIGHT, _DARK), hint="Of this browser.")
    camera.on_click(look_from)
    theme.on_click(colour)
    return {
        camera._impl.uuid: frozenset(PRESETS),
        theme._impl.uuid: frozenset((_LIGHT, _DARK)),
    }
