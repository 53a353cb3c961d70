"""What the panel says: markup in what others have sent is text."""

from __future__ import annotations

import random
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from tauten.controller import Status
from tauten.model import NO_CONTACTS, ActuatorKind
from tauten.service.view.charts import names_html
from tauten.service.view.words import (
    _STATUSES,
    Words,
    at_limit,
    beyond_limit,
    frame_in_words,
    without_node,
)
from tauten.service.wire import Cause, Mode

PIECES = (
    "<", ">", "&", "'", '"', "img", "script", "=", " ", "onerror", "javascript:", "\n", "\0", "\u202e",
    "x",
)  # fmt: skip


class Reader(HTMLParser):
    """The elements of a text and its text."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


def read(words: Words) -> Reader:
    reader = Reader()
    reader.feed(words.html)
    reader.close()
    return reader


def test_no_text_becomes_an_element() -> None:
    for seed in range(500):
        change = random.Random(seed)
        parts = ["".join(change.choices(PIECES, k=change.randrange(30))) for _ in range(4)]
        found = read(Words(parts[0], parts[1], tuple(parts[2:])))
        assert set(found.tags) <= {"div", "b", "ul", "li"}
        assert found.tags.count("li") == 2
        shown = "".join(c if c.isprintable() else " " for c in "".join(parts))
        assert found.text == shown


def test_every_status_of_a_decision_has_a_sentence() -> None:
    assert set(_STATUSES) == {status.name for status in Status if not status.ok}


def test_what_is_too_long_is_cut() -> None:
    found = read(Words(items=("x" * 10**6,) * 10**3))
    assert len(found.text) < 20_000
    assert Words().html == ""


def test_what_a_missing_node_said_last_is_not_what_it_does() -> None:
    found = without_node(Words("RUN: follows the target", "", ("1 contact point pushes",)), 3.2)
    assert "RUN" not in found.title + found.advice
    assert "3 s" in found.advice
    assert found.items == ("the last was RUN: follows the target", "1 contact point pushes")


def test_the_largest_vacuum_and_the_longest_cable_are_limits_and_rest_is_none() -> None:
    """Only upper limits were said: a chamber at its largest vacuum did not follow, and nothing said why."""
    limits = {
        "cable": ((0.0, 0.02), (0.0, 10.0)),
        "paid": ((-0.05, 0.05), (0.0, 15.0)),
        "air": ((-6e-6, 6e-6), (-12e3, 25e3)),
    }
    actuators = [SimpleNamespace(name=n, position=p, effort=e) for n, (p, e) in limits.items()]
    look = cast(Any, SimpleNamespace(robot=SimpleNamespace(actuators=actuators)))

    def named(position: list[float], effort: list[float]) -> list[str]:
        frame = SimpleNamespace(position=np.array(position), effort=np.array(effort))
        return at_limit(look, cast(Any, frame))

    assert named([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]) == []
    assert named([0.02, -0.05, -1.4e-6], [1.0, 0.0, -12e3]) == ["cable", "paid", "air"]
    assert named([0.0, 0.0, 0.0], [10.0, 15.0, 25e3]) == ["cable", "paid", "air"]


def test_what_a_simulated_robot_has_beyond_a_limit_is_not_what_was_decided() -> None:
    """A trunk that was dragged fast showed 16.3 N where 15 N are allowed, as if these had left."""
    kind = ActuatorKind.CABLE
    cables = [SimpleNamespace(name=name, effort=(0.0, 15.0), kind=kind) for name in ("one", "two")]
    look = cast(Any, SimpleNamespace(robot=SimpleNamespace(actuators=cables)))
    frame = SimpleNamespace(effort=np.array([15.0, 16.3]), decided=np.array([15.0, 14.9]))
    assert beyond_limit(look, cast(Any, frame)) == ["two 16.3 N, decided 14.9 N"]
    frame.decided = None  # of a served robot: these are what left
    assert beyond_limit(look, cast(Any, frame)) == []


def test_lines_of_a_plot_have_their_names() -> None:
    """Plots of more than three lines had none, and nobody knew which cable was which."""
    found = names_html(["one", "<b>", "limit"])
    assert "#2a5ca0" in found and "#c00000" in found
    assert "&lt;b&gt;" in found


def test_after_a_stop_the_model_is_said_not_to_move() -> None:
    """A served robot that had been released was shown bent, without a word."""
    look = SimpleNamespace(robot=SimpleNamespace(actuators=[]), error=lambda frame: float("nan"))
    none = np.zeros(0)
    for modelled, expected in ((None, 1), (none, 0)):  # without and with a robot beside the model
        frame = SimpleNamespace(
            mode=Mode.STOP, cause=Cause.OPERATOR, status="", position=none, effort=none,
            modelled=modelled, decided=None, geometry=SimpleNamespace(contacts=NO_CONTACTS),
        )  # fmt: skip
        found = frame_in_words(cast(Any, look), cast(Any, frame), ())
        assert sum("the model does not move" in item for item in found.items) == expected
