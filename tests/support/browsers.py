"""A real browser, headless, and where on its page a point of the scene is."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import chromium
import matplotlib.image
import numpy as np
import pytest

from tauten.model.numerics import Array
from tauten.service.view.picture import FIELD_OF_VIEW

if TYPE_CHECKING:
    from playwright.sync_api import Page

WIDTH, HEIGHT = 1000, 500
# A page draws as often as it can; without a graphics card each frame takes both cores tens of milliseconds,
# of a film with its lights hundreds.
FEW_FRAMES = """
    const ask = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = draw => window.setTimeout(() => ask(draw), 1000);
    window.cancelAnimationFrame = window.clearTimeout.bind(window);
"""


@contextmanager
def page_of(
    address: str,
    loaded: str | None = None,
    size: tuple[int, int] = (WIDTH, HEIGHT),
) -> Iterator[Page]:
    """A page in a browser, which draws once a second; skips where there is none.

    Args:
        address: to open.
        loaded: text that shows that it is there; None: its canvas does.
        size: width and height of the window [pixels].
    """
    if chromium.installed() is None:
        pytest.skip("no Chromium on this computer: apt-get install chromium")
    pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with chromium.launched() as browser:
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.set_default_timeout(120_000)  # ms; without a graphics card, on a busy machine
        page.add_init_script(FEW_FRAMES)
        page.goto(address)
        page.wait_for_selector("canvas", timeout=60_000)
        if loaded is not None:
            page.get_by_text(loaded).first.wait_for(timeout=60_000)
        yield page


def pixels(page: Page) -> Array:
    """What the page shows: (height, width, 3), 0 … 1."""
    picture: Array = matplotlib.image.imread(io.BytesIO(page.screenshot(timeout=120_000)))
    return picture[:, :, :3]


def on_page(
    point: Array, camera: Array, look_at: Array, size: tuple[int, int] = (WIDTH, HEIGHT)
) -> tuple[float, float]:
    """Where a point of the scene is on the page [pixels]; z is up.

    Args:
        point: (3,) [m].
        camera: (3,) its position [m].
        look_at: (3,) the point in the middle of the page [m].
        size: width and height of the window [pixels].
    """
    forward = (look_at - camera) / np.linalg.norm(look_at - camera)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    away = point - camera
    width, height = size
    scale = 0.5 * height / (np.tan(0.5 * FIELD_OF_VIEW) * float(away @ forward))
    x, y = 0.5 * width + scale * float(away @ right), 0.5 * height - scale * float(away @ up)
    return x, y
