"""Answers to questions over Zenoh: the robot's description as JSON, the node's metrics as Prometheus text.

Questions wait in rings outside the interpreter: when a ring is full the oldest question is dropped and ends
unanswered. A ring never blocks the thread of Zenoh that receives all messages of the session; a queue that is
full does, and then commands and targets do not arrive. The loop answers at most one question in a tick, in
the time left after its work, so that no other thread runs Python code beside it.
"""

from __future__ import annotations

from collections.abc import Callable

import zenoh

from tauten.service.wire import JSON, Keys

_WAITING = 4  # questions on each key
_TEXT = "text/plain"


class QuestionAnswers:
    """Answers questions about a robot and its node."""

    def __init__(self, session: zenoh.Session, robot: str, description: bytes) -> None:
        keys = Keys(robot)
        self._description = description
        self._keys = (keys.metrics, keys.description)
        self._questions = [
            session.declare_queryable(key, zenoh.handlers.RingChannel(_WAITING))
            for key in self._keys
        ]
        self._first = 0  # the key that is looked at first

    def answer_one(self, metrics: Callable[[], bytes]) -> None:
        """Answer one question if there is any; of two keys with questions each has its turn.

        The text of the metrics is made only for a question on their key.
        """
        for number in (self._first, 1 - self._first):
            query = self._questions[number].try_recv()
            if query is None:
                continue
            self._first = 1 - number
            with query:
                payload, encoding = (metrics(), _TEXT) if number == 0 else (self._description, JSON)
                query.reply(self._keys[number], payload, encoding=encoding)
            return
