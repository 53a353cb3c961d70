"""A node's metrics over HTTP, for Prometheus to scrape."""

from __future__ import annotations

import http.server
import logging
import sys

import zenoh

from tauten.service.link import HOST, NetworkError, ask_metrics
from tauten.service.process import StopFlag

log = logging.getLogger(__name__)

_CONTENT = "text/plain; version=0.0.4; charset=utf-8"
_SILENCE = 5.0  # s after which a connection that says nothing is closed


def serve_metrics(session: zenoh.Session, robot: str, port: int, stop: StopFlag) -> None:
    """Serve the node's metrics over HTTP on loopback until `stop` is raised.

    Each connection has a thread: browsers open some on which they say nothing.

    Raises:
        NetworkError: the port cannot be opened.
    """

    class Handler(http.server.BaseHTTPRequestHandler):
        timeout = _SILENCE

        def do_GET(self) -> None:
            known = self.path.partition("?")[0] == "/metrics"
            text = ask_metrics(session, robot) if known else None
            self.send_response(200 if text is not None else 503 if known else 404)
            self.send_header("Content-Type", _CONTENT)
            self.end_headers()
            self.wfile.write(text or b"")

        def log_message(self, format: str, *args: object) -> None:
            log.debug(format, *args)

    class Server(http.server.ThreadingHTTPServer):
        def handle_error(self, request: object, client_address: object) -> None:
            log.warning("a request for metrics has failed: %r", sys.exception())

    try:
        server = Server((HOST, port), Handler)
    except OSError as error:
        raise NetworkError(
            f"port {port} on {HOST} cannot be opened ({error.strerror}): give another --http"
        ) from error
    with server:
        server.timeout = 0.2
        log.info("metrics of %s at http://%s:%d/metrics", robot, HOST, server.server_port)
        while not stop.requested:
            server.handle_request()
