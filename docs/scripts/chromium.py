"""A headless Chromium that draws three-dimensional scenes without a graphics card.

Used by the scripts that take pictures for these pages, and by the tests of the viewer.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, ViewportSize

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
SIZE: ViewportSize = {"width": 1280, "height": 800}
PATIENCE = 180_000  # ms; without a graphics card, on a busy machine
SETTLE = 8_000  # ms after the picture stands still
ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]


def installed() -> str | None:
    """Path of a Chromium on this computer; None: there is none."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


@contextmanager
def launched() -> Iterator[Browser]:
    """A running Chromium.

    Raises:
        ImportError: playwright is not installed.
        FileNotFoundError: no Chromium on this computer.
    """
    from playwright.sync_api import sync_playwright

    path = installed()
    if path is None:
        raise FileNotFoundError("no Chromium on this computer: apt-get install chromium")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield browser
        browser.close()


def viewer_page(browser: Browser, address: str) -> Page:
    """A page of the viewer or of an exported run, without the browser's own notice.

    Args:
        browser: that opens it.
        address: of the page.
    """
    page = browser.new_page(viewport=SIZE)
    page.set_default_timeout(PATIENCE)
    page.goto(address)
    page.wait_for_selector("canvas")
    page.add_style_tag(content=".mantine-Notifications-root { display: none; }")
    return page


def photograph(page: Page, file: Path) -> None:
    """Pause a page of the viewer, let it draw, and take its picture: it is taken of what stands still.

    Args:
        page: of the viewer or of an exported run.
        file: PNG to write.
    """
    if page.get_by_label("pause").count():
        page.get_by_label("pause").first.click(force=True)
    else:
        page.mouse.click(22, SIZE["height"] - 20)  # pause of an exported run
    page.wait_for_timeout(SETTLE)
    page.screenshot(path=str(file))
    page.close()
