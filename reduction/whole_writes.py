"""Files that are written whole or not at all, also when the process or the power fails."""

from __future__ import annotations

import os
import secrets
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

_OWN_OUTPUT = {Path("/dev/stdout"): 1, Path("/dev/stderr"): 2}  # their descriptors


@contextmanager
def atomic_write(path: Path) -> Iterator[BinaryIO]:
    """A temporary file beside `path` that replaces it when the block ends without an exception.

    Content and name are on the disk (fsync) when this returns. The folder is made when missing. A file that
    is replaced keeps its permissions; a new one has those that the umask leaves. A device or a pipe remains
    what it is: it gets what the block has written. So does /dev/stdout, also where the shell has led it into
    a file. A link remains one: its file is replaced.

    Raises:
        OSError: the folder cannot be written to.
    """
    own = _OWN_OUTPUT.get(path)
    if own is not None or (path.exists() and not path.is_file() and not path.is_dir()):
        with tempfile.TemporaryFile() as file:
            yield file
            file.seek(0)
            # by its descriptor, whose place in the file is that of what the process prints
            with path.open("wb") if own is None else os.fdopen(os.dup(own), "wb") as device:
                shutil.copyfileobj(file, device)
        return
    path = Path(os.path.realpath(path))  # Path.resolve fails at links that lead to each other
    path.parent.mkdir(parents=True, exist_ok=True)
    # a name that is known before there is a file: Ctrl-C at any point leaves none
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    try:
        with temporary.open("xb") as file:
            if path.is_file():
                temporary.chmod(stat.S_IMODE(path.stat().st_mode))
            yield file
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.filename is None:  # as that of a full disk
            error.filename = str(path)
        raise
    if sys.platform == "win32":  # it opens no folders
        return
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file by `atomic_write`.

    Raises:
        OSError: the folder cannot be written to.
    """
    with atomic_write(path) as file:
        file.write(text.encode("utf-8"))
