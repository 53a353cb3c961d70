"""Commands that end when the process that started them is killed."""

from __future__ import annotations

import signal
import sys
import time
from pathlib import Path

import pytest
from support.processes import START, start_script

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="prctl is of Linux")

PARENT = """
import sys
import time
from pathlib import Path
from tauten.service.cli import main
from tauten.service.plant import child

command = {command!r}

def program():
    sys.argv = ["tauten", *command]
    main()

with child(command[0], command[1:], Path("."), program if {copied!r} else None) as process:
    Path("number").write_text(str(process.process.pid))
    time.sleep(600.0)
"""


def is_running(process: int) -> bool:
    """Whether a process exists that has not ended."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def until(done: Path, text: str = "") -> str:
    """Wait for a file that contains a text; returns its contents."""
    end = time.monotonic() + START
    while True:
        found = done.read_text() if done.exists() else ""
        if found and text in found:
            return found
        assert time.monotonic() < end, found
        time.sleep(0.02)


@pytest.mark.parametrize("copied", [True, False])
def test_a_command_ends_with_a_parent_that_is_killed(copied: bool, tmp_path: Path) -> None:
    """A stream without a node waits for it for ever."""
    command = ["stream", "line", "--robot", "nobody_here"]
    script = tmp_path / "parent.py"
    script.write_text(PARENT.format(command=command, copied=copied))
    parent = start_script(tmp_path / "said.txt", script)
    number = int(until(tmp_path / "number"))
    assert is_running(number), parent.output.read_text()
    parent.end(signal.SIGKILL)
    end = time.monotonic() + START
    while is_running(number):
        assert time.monotonic() < end
        time.sleep(0.02)
