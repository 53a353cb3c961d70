"""Ctrl-C during a long factorisation acts at once, though the library does not return."""

from __future__ import annotations

import os
import signal
import threading
import time
from types import FrameType

import numpy as np
import pytest
import scipy.sparse as sp

from tauten.model.numerics import factorisation, installed_backends, make_factorisation
from tauten.model.numerics.long_calls import LongCalls

CALL = "factorisation"  # name of the thread of the library


class Heard(Exception):
    """A signal that a handler has heard."""


def like_a_body(side: int) -> sp.csc_array:
    """A matrix with the pattern of a cube of side³ nodes of three unknowns, positive definite."""
    ones = np.ones(side)
    line = sp.diags_array([ones[1:], ones, ones[1:]], offsets=[-1, 0, 1])
    pattern = sp.csc_array(sp.kron(sp.kron(sp.kron(line, line), line), np.ones((3, 3))))
    pattern.sort_indices()
    column = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
    pattern.data = np.where(pattern.indices == column, 200.0, -1.0)
    return pattern


@pytest.mark.long
@pytest.mark.skipif(
    "pardiso" not in installed_backends(), reason="tauten[pardiso] is not installed"
)
@pytest.mark.parametrize("analysed", [False, True])
def test_a_signal_is_heard_within_a_long_factorisation(
    monkeypatch: pytest.MonkeyPatch, analysed: bool
) -> None:
    """In the analysis of the pattern, and in the factorisation of a matrix."""
    monkeypatch.setattr(factorisation, "LONG", 5_000)
    matrix = like_a_body(16)
    n = matrix.shape[0]
    assert n >= factorisation.LONG
    factors = make_factorisation(matrix.indptr, matrix.indices, "pardiso")
    if analysed:
        factors.refactor(matrix.data)
    heard: list[bool] = []

    def handler(_signal: int, _frame: FrameType | None) -> None:
        heard.append(any(thread.name == CALL for thread in threading.enumerate()))
        raise Heard

    def interrupt() -> None:
        """As soon as the library is at work."""
        while not any(thread.name == CALL for thread in threading.enumerate()):
            time.sleep(0.001)
        os.kill(os.getpid(), signal.SIGUSR1)

    before = signal.signal(signal.SIGUSR1, handler)
    try:
        sender = threading.Thread(target=interrupt, daemon=True)
        sender.start()
        with pytest.raises(Heard):
            factors.refactor(matrix.data)
        assert heard == [True]  # the library had not returned
        # what goes on alone disturbs neither the next call nor its result
        factors.refactor(2.0 * matrix.data)
        b = np.arange(n, dtype=float)
        np.testing.assert_allclose(2.0 * (matrix @ factors.solve(b)), b, atol=1e-8 * n)
    finally:
        signal.signal(signal.SIGUSR1, before)


def test_an_interrupted_call_that_begins_late_spoils_nothing() -> None:
    """Its thread may get a processor long after the signal, as on a busy machine."""
    calls = LongCalls()
    entered, proceed = threading.Event(), threading.Event()
    order: list[str] = []

    def late() -> None:
        entered.set()
        proceed.wait()
        order.append("interrupted")

    def handler(_signal: int, _frame: FrameType | None) -> None:
        raise Heard

    def interrupt() -> None:
        entered.wait()
        os.kill(os.getpid(), signal.SIGUSR1)
        time.sleep(0.1)
        proceed.set()

    before = signal.signal(signal.SIGUSR1, handler)
    try:
        threading.Thread(target=interrupt, daemon=True).start()
        with pytest.raises(Heard):
            calls.run(late)
        calls.run(lambda: order.append("next"))
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert order == ["interrupted", "next"]


def test_errors_of_the_library_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(factorisation, "LONG", 1_000)
    matrix = like_a_body(8)
    factors = make_factorisation(matrix.indptr, matrix.indices, installed_backends()[0])
    with pytest.raises(RuntimeError, match="not positive definite"):
        factors.refactor(-matrix.data)
