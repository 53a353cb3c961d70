"""Zenoh sessions of a robot's processes: peers on loopback, no router, no multicast.

Two TCP ports follow from the robot's name: the node listens on the first, a plant on the second,
and every process connects to those that are not its own, again and again until they are there. So
the order in which the processes start, stop and start again does not matter. `--port` moves both;
`--zenoh-config` replaces all of it.
"""

from __future__ import annotations

import json
import logging
import re
import threading
import time
import tomllib
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from queue import Empty, SimpleQueue

import zenoh

log = logging.getLogger(__name__)

HOST = "127.0.0.1"
# that a user may give to a node; its plant has the next one
LOWEST_PORT, HIGHEST_PORT = 1024, 65534
ZENOH_CONFIG_VARIABLE = "TAUTEN_ZENOH_CONFIG"  # names a configuration file
_FIRST_PORT = 17_447
# Errors of Zenoh, but not "Received Data for unknown expr_id" or "key_expr": messages of processes that end.
_LOG = "error,zenoh::net::routing::dispatcher::pubsub=off,zenoh::api::session=off"
_RETRY = 0.05  # s between two looks for a token
_QUIET = 1.0  # s of waiting that nobody is told: a connection takes some tenths
_MAX_MESSAGE = 2**20  # bytes; the description of a robot is the largest
_PORTS = 10_000  # two for each robot
# Time for which a message that must not be lost, an answer for instance, waits for a peer that does not read;
# then its connection is closed. The control loop waits as long.
_LONGEST_WAIT = 20_000  # µs
# Connections that say nothing: each is closed after this time, and so many may wait for their first word.
# With Zenoh's 10 s and 100, three hundred of them kept every new operator out.
_ACCEPT_TIMEOUT, _ACCEPT_PENDING = 1_000, 5_000  # ms, connections
_SOURCE = re.compile(r"\s+at \S+\.rs:\d+\.?")  # the line of Zenoh's own sources in an error
_MOST_WORDS = 300  # characters of an error of Zenoh
# A configuration of Zenoh has 10 levels and 30 kB at most; its parser ends at some ten thousand levels.
_MOST_LEVELS, _LARGEST_CONFIG = 100, 2**20  # brackets within each other, bytes
_BLOCK = "transport/link/tx/queue/congestion_control/block/wait_before_close"
_TLS = "transport/link/tls"


class NetworkError(RuntimeError):
    """A session that cannot be opened; the text names what to change."""


class Role(Enum):
    """Which process of a robot a session belongs to; the value is its offset from the port."""

    NODE = 0
    PLANT = 1
    OTHER = 2


@dataclass(frozen=True, slots=True)
class Network:
    """Where the processes of a robot meet.

    Attributes:
        port: TCP port of the node, the plant's is the next one; None: from the robot's name.
        config: file with a Zenoh configuration that replaces the default one.

    Raises:
        NetworkError: both are given; the configuration has its own ports.
    """

    port: int | None = None
    config: Path | None = None

    def __post_init__(self) -> None:
        if self.port is not None and self.config is not None:
            raise NetworkError(
                f"--port {self.port} would have no effect beside the Zenoh configuration {self.config}, "
                "which has its own ports: give --port or --zenoh-config, not both; the environment variable "
                f"{ZENOH_CONFIG_VARIABLE} counts as --zenoh-config"
            )


def default_port(robot: str) -> int:
    """The node's port of a robot of this name."""
    return _FIRST_PORT + 2 * (zlib.crc32(robot.encode()) % (_PORTS // 2))


def served_name(robot: str) -> str:
    """The name by which a robot is served: of a robot file the one in it, any other word as it is.

    Raises:
        NetworkError: the file has no name that can be read.
    """
    if not robot.endswith(".toml"):
        return robot
    try:
        name = tomllib.loads(Path(robot).read_text("utf-8")).get("name")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise NetworkError(
            f"{robot}: cannot be read ({why}); give the name by which the robot is served"
        ) from error
    if not isinstance(name, str):
        raise NetworkError(f"{robot}: name: found {name!r}, expected that of a robot")
    return name


def node_port(network: Network, robot: str) -> int:
    """The TCP port of a robot's node where no configuration says otherwise."""
    return default_port(robot) if network.port is None else network.port


def address(network: Network, robot: str) -> str:
    """Where a robot's node can be reached, for people and programs without tauten."""
    return str(network.config or _endpoint(node_port(network, robot)))


def open_session(network: Network, role: Role, robot: str, connected: bool = True) -> zenoh.Session:
    """Open the session of one process of a robot; `connected`: wait 0.5 s for connections, as Zenoh does.

    The node's session writes the time of arrival into every sample that has none (`timestamping` of Zenoh),
    closes the connection of a peer that does not read for 20 ms while an answer waits for it, and closes a
    connection that says nothing for a second.

    Raises:
        NetworkError: the name is that of no robot, the port is taken or the configuration cannot be used.
    """
    if not (robot.isascii() and robot.isidentifier()):  # part of every key: * would be all robots
        raise NetworkError(
            f"no robot has the name {robot[:40]!r}: it has letters, digits and _ only"
        )
    zenoh.init_log_from_env_or(_LOG)
    first = node_port(network, robot)
    if network.config is None:
        config = loopback_config(first, role)
    else:
        config = read_config(network.config)
        if unreadable := _unreadable_file(config):
            raise NetworkError(f"{network.config}: {unreadable}")
    if not connected:
        config.insert_json5("open/return_conditions/connect_scouted", "false")
    if role is Role.NODE:
        config.insert_json5("timestamping/enabled", "true")
        config.insert_json5("transport/unicast/accept_timeout", str(_ACCEPT_TIMEOUT))
        config.insert_json5("transport/unicast/accept_pending", str(_ACCEPT_PENDING))
        config.insert_json5(_BLOCK, str(_LONGEST_WAIT))
    try:
        return _opened(config, network)
    except zenoh.ZError as error:
        if network.config is not None:
            why = _SOURCE.sub("", str(error))
            raise NetworkError(f"{network.config}: Zenoh cannot open a session: {why}") from error
        who = "plant or driver" if role is Role.PLANT else role.name.lower()
        raise NetworkError(
            f"port {first + role.value} on {HOST} is taken: is another {who} of {robot!r} running? stop it "
            "or give --port"
        ) from error


def _opened(config: zenoh.Config, network: Network) -> zenoh.Session:
    """A session, opened in a thread: a client may wait for its router, and Zenoh hears no signals meanwhile.

    Raises:
        zenoh.ZError: it cannot be opened.
    """
    done = SimpleQueue[zenoh.Session | Exception]()

    def attempt() -> None:
        try:
            done.put(zenoh.open(config))
        except Exception as error:
            done.put(error)

    threading.Thread(target=attempt, name="opening", daemon=True).start()
    try:
        found = done.get(timeout=_QUIET)
    except Empty:
        if network.config is not None:
            log.info("waiting for a router or peer that %s names", network.config)
        found = done.get()
    if isinstance(found, Exception):
        raise found
    return found


def close_session(session: zenoh.Session) -> None:
    """Close a session; what Zenoh has not closed within its 10 s ends with the process."""
    try:
        session.close()  # type: ignore[no-untyped-call]
    except zenoh.ZError as error:
        log.info("a session was not closed in time: %s", error)


@contextmanager
def session_of(
    network: Network, role: Role, robot: str, connected: bool = True
) -> Iterator[zenoh.Session]:
    """A session that is closed when the block ends; arguments and errors of `open_session`."""
    session = open_session(network, role, robot, connected)
    try:
        yield session
    finally:
        close_session(session)


@contextmanager
def announced(session: zenoh.Session, key: str) -> Iterator[None]:
    """Declare a liveliness token until the block ends."""
    token = session.liveliness().declare_token(key)
    try:
        yield
    finally:
        token.undeclare()  # type: ignore[no-untyped-call]


def _endpoint(port: int) -> str:
    """A port of loopback as Zenoh writes it; 0: any free one."""
    return f"tcp/{HOST}:{port}"


def loopback_config(first_port: int, role: Role) -> zenoh.Config:
    """Configuration of a peer on loopback."""
    fixed = {r: _endpoint(first_port + r.value) for r in (Role.NODE, Role.PLANT)}
    settings = {
        "mode": "peer",
        "listen/endpoints": [fixed.get(role, _endpoint(0))],
        "connect/endpoints": [endpoint for r, endpoint in fixed.items() if r is not role],
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": {
            "period_init_ms": 100,
            "period_max_ms": 500,
            "period_increase_factor": 1.5,
        },
        "scouting/multicast/enabled": False,
        # correct messages are far smaller; a larger one is not assembled
        "transport/link/rx/max_message_size": _MAX_MESSAGE,
        # and they need no shared memory
        "transport/shared_memory/enabled": False,
    }
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def read_config(path: Path) -> zenoh.Config:
    """A user's Zenoh configuration.

    Raises:
        NetworkError: it cannot be read.
    """
    refused = _not_parsed(path)
    if refused:
        raise NetworkError(f"{path}: no Zenoh configuration: {refused}")
    try:
        return zenoh.Config.from_file(path)
    except zenoh.ZError as error:
        why = _SOURCE.sub("", str(error))[:_MOST_WORDS]  # a parser quotes the whole file
        raise NetworkError(f"{path}: no Zenoh configuration: {why}") from error


def _unreadable_file(config: zenoh.Config) -> str:
    """Which file of its TLS cannot be read; "" where all can. Zenoh would try until its timeout."""
    for field, name in json.loads(config.get_json(_TLS)).items():
        if name is None or not field.endswith(("_certificate", "_private_key")):
            continue
        try:
            Path(name).open("rb").close()
        except OSError as error:
            return f"{_TLS}/{field}: {name}: {(error.strerror or str(error)).lower()}"
    return ""


def _not_parsed(path: Path) -> str:
    """Why a file is not given to Zenoh's parser, which would end the process; "" where it is."""
    try:
        if not path.is_file():
            return "is a folder or a device" if path.exists() else "there is no such file"
        with path.open("rb") as file:
            contents = file.read(_LARGEST_CONFIG + 1)
    except OSError as error:
        return error.strerror or str(error)
    if len(contents) > _LARGEST_CONFIG:
        return f"larger than {_LARGEST_CONFIG} bytes"
    levels = 0
    for byte in contents:
        levels += (byte in b"[{") - (byte in b"]}")
        if levels > _MOST_LEVELS:
            return f"more than {_MOST_LEVELS} brackets within each other"
    return ""


def is_alive(session: zenoh.Session, token: str) -> bool:
    """Whether a liveliness token is declared."""
    return any(reply.ok is not None for reply in session.liveliness().get(token, timeout=1.0))


def await_token(
    session: zenoh.Session, token: str, ended: Callable[[], bool], retry: float = _RETRY
) -> bool:
    """Wait until a liveliness token is declared; False where the wait has ended before.

    Args:
        session: open Zenoh session.
        token: its key.
        ended: whether to wait no longer.
        retry: time between two looks [s].
    """
    announced, begin = False, time.monotonic()
    while not is_alive(session, token):
        if ended():
            return False
        if not announced and time.monotonic() > begin + _QUIET:
            log.info("waiting for %s", token)
            announced = True
        time.sleep(retry)
    return True
