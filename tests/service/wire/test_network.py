"""Processes of a robot find one another on loopback, in whatever order they start."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zenoh

from tauten.service.link import close_session
from tauten.service.plant import free_ports
from tauten.service.wire import (
    TICK,
    Network,
    NetworkError,
    Publisher,
    Ring,
    Role,
    default_port,
    open_session,
    read_config,
)

Open = Callable[[Role], zenoh.Session]


@pytest.fixture
def port() -> int:
    return free_ports()


@pytest.fixture
def open_one(port: int) -> Iterator[Open]:
    sessions = []

    def open_it(role: Role) -> zenoh.Session:
        sessions.append(open_session(Network(port), role, "r", connected=False))
        return sessions[-1]

    yield open_it
    for session in sessions:
        close_session(session)


def arrives(publisher: zenoh.Publisher, subscriber: Ring, seconds: float = 10.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        publisher.put(b"x")
        time.sleep(0.02)
        if subscriber.try_recv() is not None:
            return True
    return False


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (Role.NODE, Role.PLANT),
        (Role.PLANT, Role.NODE),
        (Role.OTHER, Role.NODE),
        (Role.NODE, Role.OTHER),
        (Role.OTHER, Role.PLANT),
    ],
)
def test_two_meet_in_any_order(open_one: Open, first: Role, second: Role) -> None:
    early = open_one(first).declare_subscriber("r/a", zenoh.handlers.RingChannel(8))
    late_session = open_one(second)
    assert arrives(late_session.declare_publisher("r/a"), early)


def test_a_stream_finds_a_node_that_starts_again(open_one: Open) -> None:
    publisher = open_one(Role.OTHER).declare_publisher("r/a")
    for _ in range(2):
        node = open_one(Role.NODE)
        assert arrives(publisher, node.declare_subscriber("r/a", zenoh.handlers.RingChannel(8)))
        node.close()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize(("role", "who"), [(Role.NODE, "node"), (Role.PLANT, "plant or driver")])
def test_a_second_one_fails_with_a_sentence_about_the_port(
    open_one: Open, role: Role, who: str
) -> None:
    open_one(role)
    with pytest.raises(NetworkError, match=rf"is another {who} of 'r' running"):
        open_one(role)


def listening_addresses() -> set[str]:
    """Local addresses, in the kernel's hexadecimal, that this process listens on."""
    fds = [fd for fd in Path("/proc/self/fd").iterdir() if fd.is_symlink()]
    links = [str(fd.readlink()) for fd in fds]
    inodes = {link[8:-1] for link in links if link.startswith("socket:[")}
    rows = []
    for table in ("tcp", "tcp6"):
        rows += Path(f"/proc/self/net/{table}").read_text().splitlines()[1:]
    fields = [row.split() for row in rows]
    return {f[1].split(":")[0] for f in fields if f[3] == "0A" and f[9] in inodes}


def test_sessions_listen_on_loopback_only(open_one: Open) -> None:
    open_one(Role.NODE)
    open_one(Role.OTHER)
    assert listening_addresses() == {"0100007F"}


def test_default_ports_are_where_the_kernel_gives_none_away() -> None:
    for name in ("finger", "manipulator", "x"):
        assert 17_000 < default_port(name) < 32_000
    assert default_port("finger") != default_port("manipulator")


def test_a_router_that_is_not_there_is_a_sentence(tmp_path: Path) -> None:
    """Zenoh names the line of its own sources."""
    path, endpoint = tmp_path / "client.json5", f"tcp/127.0.0.1:{free_ports()}"
    path.write_text(f'{{mode: "client", connect: {{endpoints: ["{endpoint}"]}}}}')
    with pytest.raises(NetworkError, match="Zenoh cannot open a session") as refused:
        open_session(Network(config=path), Role.OTHER, "beam")
    assert endpoint in str(refused.value)
    assert ".rs" not in str(refused.value)


def test_a_port_beside_a_configuration_is_refused() -> None:
    """The port had no effect, and nothing said so where the configuration was that of the variable."""
    with pytest.raises(NetworkError, match=r"--port 20000 .* client\.json5.*TAUTEN_ZENOH_CONFIG"):
        Network(20_000, Path("client.json5"))


def test_a_bad_zenoh_configuration_is_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "zenoh.json5"
    with pytest.raises(NetworkError, match=r"no Zenoh configuration"):
        read_config(path)
    for name, contents in (
        ("zenoh.json5", "{mode: 'banana'}"),
        ("zenoh.stl", ""),
        ("zenoh.txt", "x"),
    ):
        path = tmp_path / name
        path.write_text(contents)
        with pytest.raises(NetworkError, match=r"no Zenoh configuration") as refused:
            read_config(path)
        assert ".rs" not in str(refused.value), "the line of Zenoh's own sources"


@pytest.mark.parametrize(
    ("contents", "why"),
    [
        ("[" * 50_000, "more than 100 brackets within each other"),
        ("{a:" * 50_000, "more than 100 brackets within each other"),
        (" " * (2**20 + 1), "larger than 1048576 bytes"),
    ],
)
def test_a_configuration_that_ends_zenohs_parser_is_not_given_to_it(
    tmp_path: Path, contents: str, why: str
) -> None:
    """Its stack overflowed, and the process was gone."""
    path = tmp_path / "zenoh.json5"
    path.write_text(contents)
    with pytest.raises(NetworkError, match=f"^{path}: no Zenoh configuration: {why}$"):
        read_config(path)
    for other in (tmp_path, Path("/dev/zero")):
        with pytest.raises(NetworkError, match=r"is a folder or a device$"):
            read_config(other)


def test_a_publisher_finds_whether_there_is_a_subscriber(open_one: Open) -> None:
    """Also when the listener was there first, when it goes, and when its whole session does."""
    node, other = open_one(Role.NODE), open_one(Role.OTHER)
    early = other.declare_subscriber("tauten/r/early")

    def becomes(publisher: Publisher, heard: bool) -> bool:
        end = time.monotonic() + 10.0
        while publisher.has_subscribers is not heard and time.monotonic() < end:
            time.sleep(0.01)
        return publisher.has_subscribers is heard

    publisher, silent = (
        Publisher(node, "tauten/r/late", TICK),
        Publisher(node, "tauten/r/silent", TICK),
    )
    assert becomes(Publisher(node, "tauten/r/early", TICK), True)
    assert not publisher.has_subscribers
    late = other.declare_subscriber("tauten/*/late")
    assert becomes(publisher, True)
    late.undeclare()  # type: ignore[no-untyped-call]
    assert becomes(publisher, False)
    again = other.declare_subscriber("tauten/r/late", zenoh.handlers.RingChannel(1))
    assert becomes(publisher, True)
    assert not silent.has_subscribers
    other.close()  # type: ignore[no-untyped-call]
    assert becomes(publisher, False)
    del early, again  # which end with their variables


@pytest.mark.parametrize("name", ["*", "a/b", "a\udcff", "", "two words", "a\nb"])
def test_names_that_no_robot_has_open_no_session(name: str) -> None:
    """A wildcard would command every robot; half a surrogate pair is in no key."""
    with pytest.raises(
        NetworkError, match=r"no robot has the name .*: it has letters, digits and _"
    ):
        open_session(Network(), Role.OTHER, name)
