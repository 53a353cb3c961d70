"""The driver of docs/tutorials/hardware.md gets what a node publishes, where a node is reached by default."""

from __future__ import annotations

import os
import re
import time
import zlib
from pathlib import Path

import pytest

from tauten.service.link import address
from tauten.service.wire import (
    CDR,
    Joints,
    Keys,
    Network,
    Role,
    default_port,
    encode_joints,
    session_of,
)

DOCS = Path(__file__).resolve().parents[2] / "docs"
PATIENCE = 30.0  # s


def test_the_driver_of_the_page_hears_the_node(capsys: pytest.CaptureFixture[str]) -> None:
    page = (DOCS / "tutorials" / "hardware.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S)
    robot = f"page_{os.getpid()}"  # its port is nobody else's
    joints = Joints(0, "base", ("tendon",), (0.0125,), (3.5,))
    heard: list[str] = []

    with session_of(Network(), Role.NODE, robot) as node:

        def wait_for_line(prompt: str) -> None:
            """What the page asks for input with: until the driver has printed an actuation."""
            end = time.monotonic() + PATIENCE
            while not heard and time.monotonic() < end:
                node.put(Keys(robot).actuation, encode_joints(joints), encoding=CDR)
                time.sleep(0.05)
                heard.extend(capsys.readouterr().out.splitlines())

        exec(code.replace('"finger"', f'"{robot}"'), {"input": wait_for_line})
    assert heard[:1] == ["tendon: 12.50 mm, 3.50 N"]


def test_the_page_of_messages_says_the_port_of_a_robot() -> None:
    page = (DOCS / "reference" / "messages.md").read_text(encoding="utf-8")
    (first, robots) = re.findall(r"TCP port (\d+) \+ 2 \(CRC-32 .* mod (\d+)\)", page)[0]
    port = int(first) + 2 * (zlib.crc32(b"finger") % int(robots))
    assert port == default_port("finger")
    assert address(Network(), "finger") == f"tcp/127.0.0.1:{port}"
