"""A process that has imported tauten, and makes copies of itself that become `tauten` commands or scripts.

Importing takes most of the time of a short command, and loading the kernels most of the start of a node, so
that tests do both once. The copies are processes like others: with signals, priority, exit code and output of
their own. It reads one request in a line from standard input, answers with one number in a line, and ends
with its input.
"""

from __future__ import annotations

import gc
import json
import os
import runpy
import signal
import sys
from typing import Any, TextIO

import numba

import tauten.service.cli.app
import tauten.service.node
import tauten.service.plant
import tauten.service.replay  # noqa: F401 - the copies need not import them
from tauten.controller import warm_controller
from tauten.model import one_blas_thread
from tauten.service.cli import main
from tauten.service.setup import load_setup
from tauten.service.wire import typestore


def warm(robot: str) -> None:
    """Load what a node of this robot file needs, and leave it out of the garbage collection of the copies."""
    with one_blas_thread():  # threads would be missing in the copies
        warm_controller(load_setup(robot))
    typestore()  # loads the definitions of the messages
    numba.njit(lambda x: x)(1.0)  # the first compilation prepares the compiler
    gc.freeze()


def become(request: dict[str, Any]) -> None:
    """Run the command of a request in this process, as `python -m tauten.service` does, or its script."""
    sink = os.open(request["output"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    source = os.open(os.devnull, os.O_RDONLY)
    for number, file in ((0, source), (1, sink), (2, sink)):
        os.dup2(file, number)
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.dont_write_bytecode = bool(os.environ.get("PYTHONDONTWRITEBYTECODE"))  # read at start else
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # ignored where the tests run under nohup
    if request["script"]:
        sys.path.insert(0, request["folder"])
        runpy.run_path(request["script"], run_name="__main__")
        return
    sys.argv = ["tauten", *request["arguments"]]
    main()


def exit_code(process: int) -> int | None:
    """As `subprocess.Popen.returncode`: negative for a signal, None while the process runs."""
    ended, status = os.waitpid(process, os.WNOHANG)
    return os.waitstatus_to_exitcode(status) if ended else None


def serve(requests: TextIO, answers: TextIO) -> None:
    """Answer until the input ends; returns in a copy when its command is to run."""
    for line in requests:
        request = json.loads(line)
        if "warm" in request:
            warm(request["warm"])
            print(0, file=answers, flush=True)
            continue
        if "process" in request:
            print(json.dumps(exit_code(request["process"])), file=answers, flush=True)
            continue
        process = os.fork()
        if process == 0:
            requests.close()
            answers.close()
            return become(request)
        print(json.dumps(process), file=answers, flush=True)
    return None


if __name__ == "__main__":
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C is for the tests, which then end the input
    own = [os.fdopen(os.dup(number), mode) for number, mode in ((0, "r"), (1, "w"))]
    for number, mode in ((0, os.O_RDONLY), (1, os.O_WRONLY)):
        os.dup2(os.open(os.devnull, mode), number)
    serve(own[0], own[1])
