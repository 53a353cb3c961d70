"""What a sender chooses is quoted in a refusal with at most 40 characters, all of them printable."""

from __future__ import annotations

import json
import random
from dataclasses import dataclass, replace

import numpy as np
import pytest
from support.messages import Point, encode_point, point_layout

from tauten.model.schema import EffectorKind
from tauten.service.codec.messages import POINT
from tauten.service.wire import (
    CDR,
    JOINTS,
    JSON,
    Cause,
    EffectorMessage,
    EffectorSubscriber,
    Joints,
    Mode,
    Rejection,
    Tick,
    decode_command,
    decode_effector,
    decode_joints,
    decode_tick,
    encode_effector,
    encode_joints,
    encode_tick,
)

MOST = 40
MARKUP = "<img src=http://evil/x onerror=stop()>"
ALPHABET = "<>&'\"`[](){}!*_#\\|~:/ \n\r\t\0\x1b[31m\u202e\u200b\ufeffé漢"
TICK = Tick(
    10**18, "base", 7, Mode.RUN, Cause.NONE, "OK", (), (), 10**18,
    1e-4, 2e-3, 1e-3, 5e-3, 1e-2, 0, 1e-3, 0.0, 0.0, 0, False,
)  # fmt: skip


@dataclass(frozen=True)
class Sample:
    payload: bytes
    encoding: str = f"{CDR};{POINT}"
    timestamp: None = None


@dataclass
class Once:
    """A ring with one sample."""

    sample: Sample | None

    def try_recv(self) -> Sample | None:
        found, self.sample = self.sample, None
        return found


def hostile(seed: int) -> str:
    """A text as somebody would send it who wants to be shown in a terminal or a browser."""
    change = random.Random(seed)
    length = change.choice((1, 39, 40, 41, 300, 2000))
    text = "".join(change.choice(ALPHABET) for _ in range(length))
    return MARKUP * change.randrange(3) + text.replace("\0", "") + str(seed)


def of_frame(text: str) -> str:
    """Why a target in another frame was refused."""
    sample = Sample(encode_point(Point(0, text, (0.0, 0.0, 0.0))))
    rest = np.zeros(3)
    subscriber = EffectorSubscriber(
        [Once(sample)], "base", point_layout(["tip"]), rest, reach=1.0, timeout=1.0
    )
    assert subscriber.read(0.0, 0.0) == []
    return subscriber.counts.last_rejection


def refusals(text: str) -> list[str]:
    """The reasons of all refusals in which a text could appear."""
    number = EffectorMessage(0, "", (0.1,))
    found: list[object] = []
    kinds: tuple[EffectorKind, ...] = ("point", "frame", "length")
    for kind in kinds:
        for encoding in (text, f"{CDR};{text}", f"{JSON};{text}"):
            found.append(decode_effector(kind, "tip", b"x", encoding))
        found.append(decode_effector(kind, "tip", json.dumps({text: text}).encode(), JSON))
    found += [
        decode_effector("length", "tip", encode_effector("length", text, number), CDR),
        decode_effector("point", "tip", encode_effector("length", text, number), f"{CDR};{JOINTS}"),
        decode_joints(encode_joints(Joints(0, text, (text,), (0.0,), (0.0,))), CDR, ("tendon",)),
        decode_joints(b"", text, ("tendon",)),
        decode_tick(encode_tick(replace(TICK, status=text))),
    ]
    for words in (text, f"lock {text} position 1", f"lock tendon force {text}", f"unlock {text} x"):
        for encoding in (JSON, text):
            found.append(decode_command(json.dumps({"data": words}).encode(), encoding))
    details = [one.detail for one in found if isinstance(one, Rejection)]
    assert len(details) >= len(found) - 2  # a name of one word may be that of an actuator
    return [*details, of_frame(text)]


@pytest.mark.parametrize("first", range(0, 200, 50))
def test_refusals_quote_little_of_what_was_received(first: int) -> None:
    for seed in range(first, first + 50):
        text = hostile(seed)
        for detail in refusals(text):
            assert detail.isprintable(), detail
            pieces = {text[i : i + MOST + 1] for i in range(len(text) - MOST)}
            assert not any(piece in detail for piece in pieces), detail
            assert len(detail) < 300


def test_a_tick_has_a_status_that_there_is() -> None:
    """A log's status is shown in the viewer and in tables."""
    assert decode_tick(encode_tick(replace(TICK, status="MAX_PIVOTS"))) == replace(
        TICK, status="MAX_PIVOTS"
    )
    found = decode_tick(encode_tick(replace(TICK, status=MARKUP)))
    assert isinstance(found, Rejection)
    assert "no status" in found.detail
