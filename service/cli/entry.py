"""Where `tauten` starts: `tauten command` at once, all other commands with the whole program."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from io import TextIOWrapper

from tauten.service.parent import PARENT, end_with


def main() -> None:
    """Entry point of `tauten`."""
    atexit.register(gc.freeze)  # no search for garbage at the end, which takes 0.2 s
    run(_start)


def _start() -> None:
    try:
        parent = int(os.environ.pop(PARENT, ""))
    except ValueError:  # none, or not from `tauten`
        parent = 0
    if parent > 0:
        end_with(parent)
    if sys.argv[1:2] == ["command"]:
        from tauten.service.cli.emergency import carry_out, order_in

        order = order_in(sys.argv[2:])
        if order is not None:
            print(carry_out(order))
            sys.exit(0)
    from tauten.service.cli.app import app

    app()


def run(program: Callable[[], object]) -> None:
    """Run a program of commands: errors of the set-up become one sentence and exit code 2.

    Where a script runs a command in the background, its shell has SIGINT ignored; commands obey Ctrl-C there
    too. SIGHUP stays ignored where `nohup` did that. Characters that a terminal does not have become "?".
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # None where it is closed
            stream.reconfigure(errors="replace")
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        program()
    except KeyboardInterrupt:
        sys.exit(130)  # as all commands do
    except SystemExit as end:
        # as of other programs before `head`; libraries say 1, which of `check` is a finding
        if isinstance(end.__context__, BrokenPipeError):
            sys.exit(128 + signal.SIGPIPE)
        raise
    except Exception as error:
        sentence = _sentence(error)
        if sentence is None:
            raise
        with suppress(OSError):  # of a full disk: the exit code says it still
            print(f"tauten: {sentence}", file=sys.stderr)
        sys.exit(2)


def _sentence(error: Exception) -> str | None:
    """What to tell the user, where the text of the error or its kind says what to change; None elsewhere."""
    from tauten.service.link import NetworkError, OrderError

    if isinstance(error, FileExistsError) and error.filename is not None:  # of a folder to be made
        return f"{error.filename}: exists and is no folder"
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: {error.strerror.lower()}"
    if isinstance(error, NetworkError | OrderError | OSError):
        return str(error)
    from tauten.model.numerics import FactorisationError
    from tauten.service.cli.app import setup_errors

    if isinstance(error, setup_errors()):
        return str(error)
    if isinstance(error, FactorisationError):
        return (
            f"the simulated motion has diverged, the equations of a time step have no solution ({error}); "
            "choose a larger controller.rate, and look at what tauten check says about the robot"
        )
    return None
