"""What libraries print is kept from the terminal, and only that: other threads of Python go on printing."""

from __future__ import annotations

import contextlib
import io
import sys
import threading
from collections.abc import Iterator
from typing import TextIO

# `sys.stdout` belongs to the process: who changes it has to change it back before another does.
_ONE = threading.Lock()


class _Split(io.TextIOBase):
    """What one thread writes goes to a text, what others write to where it went before."""

    def __init__(self, kept: io.StringIO, before: TextIO) -> None:
        super().__init__()
        self._kept, self._before, self._thread = kept, before, threading.get_ident()

    def write(self, text: str) -> int:
        ours = threading.get_ident() == self._thread
        return (self._kept if ours else self._before).write(text)

    def flush(self) -> None:
        # Python flushes what it deletes, in any thread: the stream before may be closed by then.
        if threading.get_ident() != self._thread and not self._before.closed:
            self._before.flush()


@contextlib.contextmanager
def kept_from_terminal() -> Iterator[io.StringIO]:
    """Keep what this thread prints from the terminal; yields the text of its `sys.stdout`."""
    printed = io.StringIO()
    with (
        _ONE,
        contextlib.redirect_stdout(_Split(printed, sys.stdout)),
        contextlib.redirect_stderr(_Split(io.StringIO(), sys.stderr)),
    ):
        yield printed
