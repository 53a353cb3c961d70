"""Waiting for a node: said where it lasts, not where only the connection has to be made."""

from __future__ import annotations

import logging
from itertools import count

import pytest

from tauten.service.link import await_token, network


@pytest.mark.parametrize(("looks", "said"), [(3, 0), (1000, 1)])
def test_waiting_is_said_once_and_only_where_it_lasts(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, looks: int, said: int
) -> None:
    asked, clock = count(), count(step=0.01)
    monkeypatch.setattr(network, "is_alive", lambda *_: next(asked) == looks)
    monkeypatch.setattr(network.time, "monotonic", lambda: next(clock))
    monkeypatch.setattr(network.time, "sleep", lambda _: None)
    caplog.set_level(logging.INFO)
    assert await_token(None, "tauten/finger", lambda: False)  # type: ignore[arg-type]
    assert [record.message for record in caplog.records] == said * ["waiting for tauten/finger"]
