"""Calls of libraries that take long, while which handlers of signals run."""

from __future__ import annotations

import threading
from collections.abc import Callable


class LongCalls:
    """Long calls of a library, each in a thread of its own, so that handlers of signals run meanwhile.

    Python runs handlers in the main thread, and not while that is in C. Where a handler raises an exception
    the call goes on alone and what it computes is lost; `wait` before its arguments are changed. Other
    threads than the main one call directly.
    """

    def __init__(self) -> None:
        self._thread: threading.Thread | None = None
        self._ended = threading.Event()

    def run(self, call: Callable[[], None]) -> None:
        """Call, and return when the call has ended; raises what it raises."""
        self.wait()
        if threading.current_thread() is not threading.main_thread():
            call()
            return
        failure: list[BaseException] = []

        def guarded() -> None:
            try:
                call()
            except BaseException as error:
                failure.append(error)
            finally:
                self._ended.set()

        self._ended.clear()
        self._thread = threading.Thread(target=guarded, name="factorisation", daemon=True)
        self._thread.start()
        self.wait()
        if failure:
            raise failure[0]

    def wait(self) -> None:
        """Until a call that was interrupted has ended."""
        if self._thread is None:
            return
        if self._thread in threading.enumerate():  # with those that are just being started
            self._ended.wait()
        self._thread = None
