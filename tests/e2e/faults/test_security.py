"""The shipped Zenoh configurations: TLS with certificates or passwords, and who may do what.

Certificates are made here. A node as a process and everybody else's sessions meet at a router.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import trustme
import zenoh
from support.messages import encode_command, encode_point
from support.nodes import PERIOD, point_at
from support.processes import Process, start, wait_alive
from support.sites import ROLES, Site, certificates, issue
from support.viewers import wait_until

from tauten.model import Robot
from tauten.service.codec.messages import POINT
from tauten.service.link import NetworkError, ask_metrics, close_session, commanding, send_command
from tauten.service.plant import free_ports
from tauten.service.wire import (
    CDR,
    TEXT,
    Keys,
    Network,
    OperatorCommand,
    decode_health,
    read_config,
)

KEYS = Keys("beam")


@pytest.fixture(params=["certificates", "passwords"])
def site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Site]:
    certificates(tmp_path)
    (tmp_path / "users.txt").write_text("".join(f"{role}:{role}-secret\n" for role in ROLES))
    found = Site(tmp_path, free_ports(), request.param == "passwords")
    router = found.router()
    yield found
    router.close()  # type: ignore[no-untyped-call]


Connect = Callable[[str], zenoh.Session]


@pytest.fixture
def connect(site: Site) -> Iterator[Connect]:
    sessions = []

    def it(role: str) -> zenoh.Session:
        sessions.append(zenoh.open(read_config(site.client(role))))
        return sessions[-1]

    yield it
    for session in sessions:
        close_session(session)


@pytest.fixture
def node(site: Site, beam_file: Path, tmp_path: Path) -> Iterator[Process]:
    found = start(tmp_path / "serve.txt", "serve", beam_file, "--zenoh-config", site.client("node"))
    yield found
    found.process.kill()
    found.process.wait()


def accepted(session: zenoh.Session) -> dict[str, int]:
    """Targets and commands that the node has accepted, from its next health."""
    health = session.declare_subscriber(KEYS.health, zenoh.handlers.RingChannel(4))
    found = decode_health(bytes(health.recv().payload))
    health.undeclare()  # type: ignore[no-untyped-call]
    assert isinstance(found, dict)
    return {name: int(found[name].values["accepted"]) for name in ("targets", "commands")}


def drive(session: zenoh.Session, beam: Robot) -> None:
    """Send some targets and a command with the rights of the session."""
    for _ in range(20):
        target = encode_point(point_at(beam, 0.003))
        session.put(KEYS.targets(("tip",))[0], target, encoding=f"{CDR};{POINT}")
        time.sleep(PERIOD)
    session.put(KEYS.command, encode_command(OperatorCommand.HOLD), encoding=f"{CDR};{TEXT}")
    time.sleep(0.2)


@pytest.mark.long
def test_a_viewer_reads_but_does_not_command(connect: Connect, node: Process, beam: Robot) -> None:
    viewer, operator = connect("viewer"), connect("operator")
    wait_alive(viewer, KEYS.token, node)
    ticks = viewer.declare_subscriber(KEYS.tick, zenoh.handlers.RingChannel(10))
    drive(viewer, beam)
    assert wait_until(lambda: ticks.try_recv() is not None)
    assert ask_metrics(viewer, "beam") is not None
    assert accepted(viewer) == {"targets": 0, "commands": 0}
    # and only the node can publish actuation
    forged = viewer.declare_publisher(KEYS.actuation)
    seen = operator.declare_subscriber(KEYS.actuation, zenoh.handlers.RingChannel(200))
    for _ in range(10):
        forged.put(b"forged")
        operator.put(KEYS.actuation, b"forged")
        time.sleep(PERIOD)
    payloads = []
    while (sample := seen.try_recv()) is not None:
        payloads.append(bytes(sample.payload))
    # what a session publishes reaches its own subscribers without passing the router
    assert payloads.count(b"forged") == 10
    drive(operator, beam)
    counts = accepted(viewer)
    assert counts["targets"] > 10
    assert counts["commands"] == 1
    assert node.end() == 0


@pytest.mark.long
def test_a_viewer_whose_stop_does_not_pass_is_told_so(
    site: Site, node: Process, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The node, which answered every question, was said not to answer."""
    network = Network(config=site.client("viewer"))
    monkeypatch.setattr(commanding, "_ANSWER", 3.0)
    monkeypatch.setattr(commanding, "_PATIENCE", 180.0)
    with pytest.raises(
        NetworkError, match=r"answers, but has not carried .* a router may not permit"
    ):
        send_command("beam", network, OperatorCommand.STOP)


@pytest.mark.parametrize("site", ["certificates"], indirect=True)
def test_a_key_that_is_not_there_is_named(site: Site) -> None:
    """At once: Zenoh tries for ten seconds, and says that it cannot connect."""
    file = site.client("operator")
    (site.folder / "operator.key").unlink()
    said = (
        f"{file}: transport/link/tls/connect_private_key: .*operator.key: no such file or directory"
    )
    with pytest.raises(NetworkError, match=said):
        send_command("beam", Network(config=file), OperatorCommand.STOP)


@pytest.mark.long
def test_strangers_are_not_let_in(site: Site, tmp_path: Path) -> None:
    if site.password:
        stranger = site.client("operator", password="guess")
    else:
        issue(trustme.CA(), tmp_path, "stranger", "stranger")  # by another authority
        stranger = site.client("stranger")
    with pytest.raises(zenoh.ZError, match="Unable to connect"):
        zenoh.open(read_config(stranger))
    plain = zenoh.Config()
    plain.insert_json5("mode", '"client"')
    plain.insert_json5("connect/endpoints", f'["tcp/localhost:{site.port}"]')
    plain.insert_json5("connect/timeout_ms", "1000")
    with pytest.raises(zenoh.ZError, match="Unable to connect"):
        zenoh.open(plain)


@pytest.mark.long
def test_a_router_of_another_authority_is_refused(site: Site, tmp_path: Path) -> None:
    trustme.CA().cert_pem.write_to_path(str(tmp_path / "ca.pem"))
    with pytest.raises(zenoh.ZError, match="Unable to connect"):
        zenoh.open(read_config(site.client("operator")))
