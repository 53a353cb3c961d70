"""A process that has imported tauten, and makes copies of itself that become `tauten` commands or scripts.

Importing takes most of the time of a short command, and loading the kernels most of the start of a node, so
that tests do both once. The copies are processes like others: with signals, priority, exit code and output of
their own. `fork_server.py ADDRESS ROBOT` listens at the address of a Unix socket, which it says by a line of
output. It reads requests of one line, answers each with one number in a line, and ends with the last
connection.
"""

from __future__ import annotations

import gc
import json
import os
import runpy
import select
import signal
import socket
import sys
from contextlib import suppress
from pathlib import Path
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


def serve(server: socket.socket) -> None:
    """Answer until nobody is connected any more; returns in a copy when its command has ended."""
    files: dict[socket.socket, TextIO] = {}
    while True:
        for one in select.select([server, *files], [], [])[0]:
            if one is server:
                client, _ = server.accept()
                files[client] = client.makefile("rw")
                continue
            line = ""
            with suppress(ConnectionError):  # a process of the suite has crashed
                line = files[one].readline()
            if not line:
                with suppress(ConnectionError):
                    files.pop(one).close()
                one.close()
                if not files:
                    Path(server.getsockname()).unlink()
                    return
                continue
            request = json.loads(line)
            answer: int | None
            if "process" in request:
                answer = exit_code(request["process"])
            else:
                answer = os.fork()
                if answer == 0:
                    for other in (server, *files, *files.values()):
                        other.close()
                    become(request)
                    return
            with suppress(ConnectionError):
                print(json.dumps(answer), file=files[one], flush=True)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the tests, which then leave
    address, robot = Path(sys.argv[1]), sys.argv[2]
    warm(robot)
    address.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(address))
        server.listen()
        print("listening", flush=True)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        serve(server)
