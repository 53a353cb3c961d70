"""The policy that is sent with the viewer's page."""

from __future__ import annotations

import urllib.request

import pytest
from support.viewers import wait_until

from tauten.service.view import open_server
from tauten.service.view.web.policy import policy, script_digests


def test_the_page_has_a_policy_that_names_its_own_scripts() -> None:
    with open_server(0, "test") as (server, _):
        assert wait_until(lambda: server.get_port() > 0)
        port = server.get_port()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=60.0) as answer:
            headers = dict(answer.headers.items())
    found = dict(part.split(" ", 1) for part in headers["Content-Security-Policy"].split("; "))
    assert found["default-src"] == "'none'"
    assert found["script-src"].count("'sha256-") == 2
    assert "unsafe-inline" not in found["script-src"]
    assert "'unsafe-eval'" not in found["script-src"]
    assert found["connect-src"].endswith(f" ws://127.0.0.1:{port}")
    assert found["frame-ancestors"] == "'none'"
    assert headers["X-Frame-Options"] == "DENY"


def test_a_host_of_others_is_not_connected_to() -> None:
    with open_server(0, "test") as (server, _):
        request = urllib.request.Request(f"http://127.0.0.1:{server.get_port()}/")
        request.add_header("Host", "evil.example; script-src *")
        with urllib.request.urlopen(request, timeout=60.0) as answer:
            assert answer.headers["Content-Security-Policy"] == policy()


@pytest.mark.parametrize(
    "page",
    ["", "<script>run()</script>", '<script data-p="###" data-ss="1" data-cs="2">x</script>',
     '<script data-p="A A" data-ss="1" data-cs="99999999999">x</script>'],
)  # fmt: skip
def test_a_page_that_is_packed_otherwise_is_noticed(page: str) -> None:
    with pytest.raises(Exception, match=r"no packed script|bytes|decompress|frame"):
        script_digests(page)
