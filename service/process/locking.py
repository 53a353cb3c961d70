"""Files and folders that one process at a time writes."""

from __future__ import annotations

import errno
import fcntl
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


def lock(number: int, path: str | Path) -> None:
    """Lock an open file or folder, by its number, until it is closed, here and in copies of this process.

    Where a file system has no locks nothing is locked.

    Raises:
        OSError: another process has locked it.
    """
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise OSError(errno.EBUSY, "another process writes to it", str(path)) from error
    except OSError:
        return


def locked_new(path: str, flags: int) -> int:
    """Open a new file for `open`, locked; one of that name is emptied only where nothing else writes it.

    Raises:
        OSError: it cannot be opened, or another process has locked it.
    """
    number = os.open(path, flags & ~os.O_TRUNC, 0o666)
    try:
        lock(number, path)
        if stat.S_ISREG(os.fstat(number).st_mode):
            os.ftruncate(number, 0)
    except OSError:
        os.close(number)
        raise
    return number


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """A folder that only this process writes into.

    Raises:
        OSError: another process says the same of it.
    """
    number = os.open(folder, os.O_RDONLY)
    try:
        lock(number, folder)
        yield
    finally:
        with suppress(OSError):
            fcntl.flock(number, fcntl.LOCK_UN)  # for copies of this process, too
        os.close(number)
