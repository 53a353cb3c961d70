"""What the viewer's page may load and run: HTTP headers that every browser enforces.

viser's page shows HTML that the server sends, and other pages can show viser's page in a frame. So whatever
text arrives there, no script runs but the page's own, nothing is loaded from elsewhere, and no other page
shows this one, so that nobody can be led to press its buttons unseen.
"""

from __future__ import annotations

import base64
import hashlib
import logging
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import viser
import zstandard
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

log = logging.getLogger(__name__)

Respond = Callable[[ServerConnection, Request], Response | None]

# viser packs its page: one script unpacks style and code from the attributes of its element
_PACKED = re.compile(
    r'<script data-p="([^"]+)" data-ss="(\d+)" data-cs="(\d+)">(.*?)</script>', re.DOTALL
)
_DIGITS = (
    "!#$%()*+,-./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_abcdefghijklmnopqrstuvwxyz{|}~"
)
_BASE, _GROUP = len(_DIGITS), 5  # characters for four bytes
_LARGEST_PAGE = 2**26  # bytes


def with_policy(respond: Respond, hosts: re.Pattern[str]) -> Respond:
    """A function that answers HTTP requests as another one does, with the policy in its headers.

    The WebSocket of the page's origin that is asked for may be opened.
    """

    def answer(connection: ServerConnection, request: Request) -> Response | None:
        response = respond(connection, request)
        if response is not None:
            host = request.headers.get("Host", "")
            socket = f" ws://{host}" if hosts.fullmatch(f"http://{host}") else ""
            response.headers["Content-Security-Policy"] = policy(socket)
            response.headers["X-Frame-Options"] = "DENY"
            response.headers["X-Content-Type-Options"] = "nosniff"
            response.headers["Referrer-Policy"] = "no-referrer"
        return response

    return answer


def policy(socket: str = "") -> str:
    """The Content-Security-Policy of the viewer's page."""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src 'wasm-unsafe-eval' {' '.join(_own_scripts())}",
            "worker-src blob:",
            "style-src 'self' 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src 'self' data:",
            f"connect-src 'self' data: blob:{socket}",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
    )


@cache
def _own_scripts() -> tuple[str, ...]:
    """The scripts of viser's page, as a policy names them."""
    page = Path(viser.__file__).parent / "client" / "build" / "index.html"
    try:
        return script_digests(page.read_text(encoding="utf-8"))
    except (OSError, ValueError, zstandard.ZstdError):
        log.warning(
            "viser %s packs its page otherwise than this version of tauten knows: the page may run scripts "
            "of others if one gets into it",
            viser.__version__,
        )
        return ("'unsafe-inline'",)


def script_digests(page: str) -> tuple[str, str]:
    """Digests of the script that unpacks viser's page, and of the code that it unpacks.

    Raises:
        ValueError, ZstdError: the page is packed otherwise.
    """
    found = _PACKED.search(page)
    if found is None:
        raise ValueError("no packed script")
    packed, style, code, script = found.groups()
    size = int(style) + int(code)
    if size > _LARGEST_PAGE:
        raise ValueError(f"{size} bytes")
    content = zstandard.ZstdDecompressor().decompress(_bytes_of(packed), max_output_size=size)
    if len(content) != size:
        raise ValueError(f"{len(content)} bytes instead of {size}")
    return _digest(script.encode()), _digest(content[int(style) :])


def _digest(script: bytes) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"


def _bytes_of(text: str) -> bytes:
    """The bytes that a text codes: five digits of base 88 for four of them, the first one the largest.

    Raises:
        ValueError: another character.
    """
    values = np.full(128, -1)
    values[np.frombuffer(_DIGITS.encode(), np.uint8)] = np.arange(_BASE)
    digits = values[np.frombuffer(text.encode("ascii"), np.uint8)]
    if (digits < 0).any():
        raise ValueError("not a packed script")
    rest = len(digits) % _GROUP
    weights = _BASE ** np.arange(_GROUP - 1, -1, -1)
    whole = digits[: len(digits) - rest].reshape(-1, _GROUP) @ weights  # (m,)
    found: bytes = (whole & 0xFFFFFFFF).astype(">u4").tobytes()
    if rest == 0:
        return found
    last = int(digits[len(digits) - rest :] @ weights[_GROUP - rest :])
    return found + (last % (1 << 8 * (rest - 1))).to_bytes(rest - 1, "big")
