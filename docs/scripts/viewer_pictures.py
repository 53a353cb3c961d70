"""Takes the pictures of docs/viewer.md from a real browser.

    python docs/scripts/viewer_pictures.py

It runs the commands that the page shows, opens them in Chromium (`apt-get install chromium`) through
playwright, and writes `docs/figures/viewer-*.png`.
"""

from __future__ import annotations

import argparse
import re
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import chromium
from playwright.sync_api import Browser

FIGURES = Path(__file__).resolve().parents[1] / "figures"
START = 180.0  # s
PICTURES = ("simulate", "manipulator", "reach", "export")
MORE = 12.0  # s after the text is there


def free_port() -> int:
    """A TCP port of loopback that is free."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def viewer(*arguments: str) -> Iterator[str]:
    """`tauten view` with some arguments; gives the address of its page."""
    port = free_port()
    command = [sys.executable, "-m", "tauten.service", "view", *arguments]
    process = subprocess.Popen([*command, "--no-browser", "--web-port", str(port)])
    try:
        end = time.monotonic() + START
        while True:
            try:
                urllib.request.urlopen(f"http://127.0.0.1:{port}", timeout=5.0).close()
                break
            except OSError:
                if process.poll() is not None or time.monotonic() > end:
                    raise
                time.sleep(0.2)
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait(30.0)


def take(browser: Browser, address: str, name: str, wait: str) -> None:
    """Take a picture of a moment at which everything is drawn.

    Args:
        browser: that opens the page.
        address: of the page.
        name: of the picture.
        wait: text of the panel to wait for, with a few seconds more; or a number of seconds.
    """
    page = chromium.viewer_page(browser, address)
    if wait.isdigit():
        page.wait_for_timeout(1e3 * float(wait))
    else:
        page.get_by_text(wait).first.wait_for()
        page.wait_for_timeout(1e3 * MORE)
    chromium.photograph(page, FIGURES / name)


def take_reach(browser: Browser, address: str, name: str) -> None:
    """Take a picture of an effector's reach, in the dark.

    Args:
        browser: that opens the page.
        address: of the page.
        name: of the picture.
    """
    page = chromium.viewer_page(browser, f"{address}/?darkMode")
    page.get_by_label("reach").first.click(force=True)
    page.get_by_text(re.compile(r"reach 1\d\d/")).wait_for()
    chromium.photograph(page, FIGURES / name)


def main() -> None:
    """Take all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="finger")
    parser.add_argument("--second", default="manipulator")
    parser.add_argument(
        "--wait", default="contact points push", help="text, or seconds, before a picture"
    )
    parser.add_argument("--only", nargs="*", choices=PICTURES, help="default: all")
    settings = parser.parse_args()
    with chromium.launched() as browser, tempfile.TemporaryDirectory() as folder:
        robot, wanted = settings.robot, settings.only or list(PICTURES)
        if "simulate" in wanted:
            with viewer(robot, "--simulate", "--path", "reach") as address:
                take(browser, address, "viewer-simulate.png", settings.wait)
        if "manipulator" in wanted:
            with viewer(settings.second, "--simulate", "--path", "line") as address:
                take(browser, address, "viewer-manipulator.png", "12")
        if "reach" in wanted:
            with viewer("trunk", "--simulate") as address:
                take_reach(browser, address, "viewer-reach.png")
        if "export" in wanted:
            html = Path(folder) / "run.html"
            command = [sys.executable, "-m", "tauten.service", "view", robot, "--simulate"]
            subprocess.run([*command, "--path", "reach", "--export", str(html)], check=True)
            take(browser, html.as_uri(), "viewer-export.png", "3")


if __name__ == "__main__":
    main()
