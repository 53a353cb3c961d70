"""Markup in what a camera, an operator or a node says: the page shows it as text, and nothing of it runs."""

from __future__ import annotations

import http.server
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from support.browsers import page_of
from support.messages import Point, encode_point
from support.processes import Served
from support.viewers import Shown, showing, wait_until

from tauten.model import Robot
from tauten.service.codec.messages import POINT
from tauten.service.frames import ServedRobot, SimulatedRobot
from tauten.service.setup import load_setup
from tauten.service.wire import CDR, Mode

if TYPE_CHECKING:
    from playwright.sync_api import Page

# ELSEWHERE is replaced by the address of another server
PAYLOADS = (
    "<iframe srcdoc='<script>parent.ran=1</script>'></iframe>",
    "<iframe srcdoc=\"<script src='http://ELSEWHERE/a.js'></script>\"></iframe>",
    "<iframe src='http://ELSEWHERE/'></iframe>",
    "<img src=http://ELSEWHERE/leak>",
    "<img src=x onerror=ran=1>",
    "<svg onload=ran=1><script>ran=1</script></svg>",
    "<script>ran=1</script>",
    "<script async src=http://ELSEWHERE/b.js></script>",
    "<style>button{display:none}</style>",
    "<meta http-equiv=refresh content='0;url=http://ELSEWHERE/'>",
    "<base href=http://ELSEWHERE/>",
    "<form action=http://ELSEWHERE/><button>stop</button></form>",
    "<details open ontoggle=ran=1>x</details>",
    "</li></ul></div><h1>STOPPED</h1>",
    "<!-- ",
    "<a href=javascript:ran=1>press</a>",
    "[press](javascript:ran=1) ![x](http://ELSEWHERE/leak) <http://ELSEWHERE/>",
    "http://ELSEWHERE/press **bold** # title ```",
    "&lt;img src=x onerror=ran=1&gt; &amp; &#60;b&#62;",
    "]]><?php --> {{ran=1}} ${ran=1}",
)
INNER = "() => [...document.querySelectorAll('li')].map(one => one.textContent)"


class Elsewhere(http.server.BaseHTTPRequestHandler):
    """A server that a page of the viewer must not ask for anything."""

    asked: list[str]

    def do_GET(self) -> None:
        """Note that somebody asks."""
        self.asked.append(self.path)
        self.send_response(200)
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@pytest.fixture(scope="module")
def elsewhere() -> Iterator[tuple[str, list[str]]]:
    """Address of another server, and what it has been asked for."""
    handler = type("Handler", (Elsewhere,), {"asked": []})
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"127.0.0.1:{server.server_port}", handler.asked  # type: ignore[attr-defined]
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def payloads(elsewhere: tuple[str, list[str]]) -> tuple[str, ...]:
    return tuple(one.replace("ELSEWHERE", elsewhere[0]) for one in PAYLOADS)


@pytest.fixture(scope="module")
def shown(beam_file: Path, beam: Robot, payloads: tuple[str, ...]) -> Iterator[Shown]:
    """The small robot, simulated, whose notes are markup."""

    class Talking(SimulatedRobot):
        @property
        def notes(self) -> tuple[str, ...]:
            return payloads

    setups = [load_setup(beam_file, rate=10.0) for _ in range(2)]
    with showing(Talking(*setups)) as found:
        yield found


@pytest.fixture(scope="module")
def page(shown: Shown) -> Iterator[Page]:
    with page_of(shown.origin, "Operate") as found:
        yield found


@contextmanager
def beside(page: Page, address: str) -> Iterator[Page]:
    """A further page in the same browser."""
    browser = page.context.browser
    assert browser is not None
    other = browser.new_page()
    other.set_default_timeout(120_000)  # ms; without a graphics card, on a busy machine
    other.goto(address)
    yield other
    other.close()


def ran(page: Page) -> bool:
    """Whether script of a payload has run."""
    return bool(page.evaluate("() => typeof window.ran !== 'undefined'"))


@pytest.mark.long
def test_markup_is_shown_as_text(
    page: Page, payloads: tuple[str, ...], elsewhere: tuple[str, list[str]]
) -> None:
    page.get_by_text("STOPPED").first.wait_for()
    assert wait_until(lambda: set(payloads) <= set(page.evaluate(INNER)))
    page.wait_for_timeout(1_000)
    assert not ran(page)
    assert elsewhere[1] == []
    assert page.locator("iframe, object, embed, form, base, meta[http-equiv]").count() == 0
    assert page.get_by_role("button", name="stop").count() == 1
    assert page.get_by_role("button", name="stop").is_visible()


@pytest.mark.long
def test_the_policy_stops_what_would_get_into_the_page(
    page: Page, payloads: tuple[str, ...], elsewhere: tuple[str, list[str]]
) -> None:
    reports: list[str] = []
    page.on("console", lambda message: reports.append(message.text))
    page.evaluate(
        "([all, far_away]) => { for (const one of all) { const box = document.createElement('div');"
        "box.innerHTML = one; document.body.append(box); }"
        "const own = document.createElement('script'); own.textContent = 'ran=1';"
        "document.head.append(own); const far = document.createElement('script');"
        "far.src = far_away; document.head.append(far); }",
        [
            [one for one in payloads if "<style>" not in one and "<meta" not in one],
            f"http://{elsewhere[0]}/c.js",
        ],
    )
    page.wait_for_timeout(1_000)
    assert not ran(page)
    assert elsewhere[1] == []
    assert any("Content Security Policy" in one for one in reports)


def test_no_other_page_shows_the_viewer_in_a_frame(
    page: Page, shown: Shown, elsewhere: tuple[str, list[str]]
) -> None:
    with beside(page, f"http://{elsewhere[0]}/") as other:
        other.set_content(f"<iframe src='{shown.origin}'></iframe>")
        assert wait_until(lambda: other.frames[1].url not in ("", "about:blank"))
        assert other.frames[1].url.startswith("chrome-error:")
    elsewhere[1].clear()


@pytest.mark.slow
@pytest.mark.parametrize("served", [("--closed-loop",)], indirect=True)
def test_a_camera_a_target_and_a_command_run_nothing(served: Served, page: Page) -> None:
    """The whole way: message, node, health, viewer, browser."""
    markup = "<iframe srcdoc='<script>parent.ran=1</script>'>"
    tip = ("tip",)
    source = ServedRobot(served.session, "beam")
    source.await_surface()
    with showing(source) as shown, beside(page, shown.origin) as other:
        other.get_by_text("Operate").first.wait_for()
        served.session.put(served.keys.measurements(tip)[0], b"x", encoding=markup)
        served.session.put(
            served.keys.targets(tip)[0],
            encode_point(Point(0, markup, (0.1, 0.0, 0.0))),
            encoding=f"{CDR};{POINT}",
        )
        served.session.put(
            served.keys.command, b'{"data": "<img src=x onerror=ran=1>"}',
            encoding="application/json",
        )  # fmt: skip

        def said(place: str) -> bool:
            return any(
                one.startswith(f"{place}: 1 refused") and "<i" in one
                for one in other.evaluate(INNER)
            )

        for place in ("measurements", "targets", "commands"):
            assert wait_until(lambda place=place: said(place)), other.evaluate(INNER)  # type: ignore[misc]
        assert not ran(other)
        assert other.locator("iframe").count() == 0
        frame = shown.session.newest
        assert frame is not None
        assert frame.mode is not Mode.STOP
