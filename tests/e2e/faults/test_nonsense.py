"""A node that answers nonsense: one sentence from each command that asks, and no traceback."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tauten.service.describing import describe
from tauten.service.frames import ServedRobot
from tauten.service.link import (
    Keys,
    Network,
    NetworkError,
    Role,
    close_session,
    node_of,
    open_session,
)
from tauten.service.log import record_robot
from tauten.service.operate import read_contacts
from tauten.service.plant import free_ports
from tauten.service.plant.receiver import described_receiver
from tauten.service.process import StopFlag
from tauten.service.setup import load_setup
from tauten.service.wire.description import read_description

NONSENSE = (
    b"", b"\xff\xfe", b"null", b"[]", b"3", b'"beam"', b"{}", b'{"robot": "beam"}', b"[" * 5000,
    b'{"actuators": {}}', b'{"robot": "beam", "actuators": 7, "effectors": null}', b"{" + b" " * 10**5,
)  # fmt: skip


@dataclass
class Liar:
    """A node of which only the answer matters."""

    port: int
    answer: bytes


@pytest.fixture(scope="module")
def liar() -> Iterator[Liar]:
    found = Liar(free_ports(), b"")
    session, keys = open_session(Network(found.port), Role.NODE, "beam"), Keys("beam")
    answers = session.declare_queryable(
        keys.description,
        lambda query: query.reply(keys.description, found.answer, encoding="application/json"),
    )
    alive = session.liveliness().declare_token(keys.token)
    yield found
    alive.undeclare()
    answers.undeclare()  # type: ignore[no-untyped-call]
    close_session(session)


def doctored(beam_file: Path) -> list[bytes]:
    """Descriptions in which one entry is wrong."""
    honest = json.loads(describe(load_setup(beam_file)).as_json())
    found = []
    for place in ("robot", "frame", "size", "actuators", "effectors"):
        for value in ("", -1, None, "<b>", [{}]):
            found.append(json.dumps({**honest, place: value}).encode())
    return found


def test_nonsense_is_no_description(beam_file: Path) -> None:
    for answer in (*NONSENSE, *doctored(beam_file)):
        with pytest.raises(NetworkError, match="the node of 'beam' describes") as refused:
            read_description("beam", answer)
        assert len(str(refused.value)) < 400
        assert "(:" not in str(refused.value)


def test_nonsense_is_one_sentence_of_each_command(liar: Liar, tmp_path: Path) -> None:
    network, sentence = Network(liar.port), "the node of 'beam' describes"
    for liar.answer in NONSENSE[2:4]:
        with node_of("beam", network) as session, pytest.raises(NetworkError, match=sentence):
            read_contacts(session, "beam")
    with pytest.raises(NetworkError, match=sentence):
        described_receiver("beam", network, StopFlag())
    with node_of("beam", network) as session, pytest.raises(NetworkError, match=sentence):
        record_robot(session, "beam", tmp_path / "log.mcap", StopFlag())
    with node_of("beam", network) as session, pytest.raises(NetworkError, match=sentence):
        ServedRobot(session, "beam")
    assert not list(tmp_path.iterdir())
