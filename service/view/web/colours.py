"""Light or dark: a page is as its browser prefers, until somebody chooses.

The server cannot ask a browser what it prefers, and no script of ours runs in viser's page. So each page gets
a picture that is not shown and that has two addresses: the browser loads the one of its preference, and loads
again when that changes.
"""

from __future__ import annotations

import re
import secrets
from http import HTTPStatus

import viser
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from tauten.service.view.web.policy import Respond

_ADDRESS = re.compile(r"/colours/([\w-]+)/(light|dark)")
_PICTURE = (
    '<picture style="display:none">'
    '<source media="(prefers-color-scheme: dark)" srcset="/colours/{token}/dark">'
    '<img src="/colours/{token}/light" alt=""></picture>'
)


class Colours:
    """The colours of the pages of one server."""

    def __init__(self) -> None:
        self._asked: dict[str, viser.ClientHandle] = {}

    async def ask(self, client: viser.ClientHandle) -> None:
        """Ask the browser of a page that has been opened what it prefers."""
        token = secrets.token_urlsafe()
        self._asked[token] = client
        client.gui.add_html(_PICTURE.format(token=token))

    async def forget(self, client: viser.ClientHandle) -> None:
        """Set no colours of a page any more by what its browser prefers."""
        for token in [one for one, asked in self._asked.items() if asked is client]:
            del self._asked[token]

    async def choose(self, client: viser.ClientHandle, dark: bool) -> None:
        """Set the colours of a page for as long as it is open.

        Args:
            client: its browser.
            dark: whether the background is dark.
        """
        await self.forget(client)
        set_theme(client.gui, dark)

    def answering(self, respond: Respond) -> Respond:
        """A function that takes the browsers' answers and passes all other HTTP requests on."""

        def answer(connection: ServerConnection, request: Request) -> Response | None:
            found = _ADDRESS.fullmatch(request.path)
            if found is None:
                return respond(connection, request)
            client = self._asked.get(found[1])
            if client is not None:
                set_theme(client.gui, found[2] == "dark")
            return Response(HTTPStatus.OK, "OK", Headers({"Cache-Control": "no-store"}), b"")

        return answer


def set_theme(gui: viser.GuiApi, dark: bool) -> None:
    """Set the colours of the page."""
    gui.configure_theme(
        control_width="medium",
        dark_mode=dark,
        show_logo=False,
        show_share_button=False,
        brand_color=(40, 90, 160),
    )
