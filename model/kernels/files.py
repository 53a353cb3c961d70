"""Files of machine code: written whole or not at all, and read only where no other user can write them."""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import uuid
from pathlib import Path

from numba.misc.appdirs import user_cache_dir

_NEW_FILE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
_DIGEST = 32  # bytes of a SHA-256


def cache_folder() -> Path:
    """Where tauten keeps files: in NUMBA_CACHE_DIR, otherwise in the user's folder for caches."""
    given = os.environ.get("NUMBA_CACHE_DIR") or user_cache_dir()  # type: ignore[no-untyped-call]
    return Path(given or Path.home() / ".cache", "tauten")  # an empty XDG_CACHE_HOME is none


def kernel_folder(cache: Path | None = None) -> Path:
    """Where machine code is kept; `cache` as the value of NUMBA_CACHE_DIR, None: what it is."""
    return (cache_folder() if cache is None else cache / "tauten") / "kernels"


def read_checked(path: Path) -> bytes:
    """The content of a file of `write_checked`.

    Raises:
        OSError: it cannot be read, others can write it, or it was damaged.
    """
    with path.open("rb") as file:
        if written_by_others(os.fstat(file.fileno())) or written_by_others(path.parent.stat()):
            raise PermissionError(f"{path}: others can write it")
        content = file.read()
    return checked(content, str(path))


def checked(content: bytes, name: str) -> bytes:
    """What `with_digest` was given.

    Raises:
        OSError: it was damaged.
    """
    content, digest = content[:-_DIGEST], content[-_DIGEST:]
    if hashlib.sha256(content).digest() != digest:
        raise OSError(f"{name}: damaged")
    return content


def with_digest(content: bytes) -> bytes:
    """A content and its SHA-256."""
    return content + hashlib.sha256(content).digest()


def write_checked(path: Path, content: bytes) -> None:
    """Write a file and the digest of its content, which only the user can write; whole or not at all.

    Raises:
        OSError: it cannot be written, or others can write its folder.
    """
    if written_by_others(path.parent.stat()):
        raise PermissionError(f"{path.parent}: others can write it")
    temporary = path.with_name(f"{path.name}.tmp.{uuid.uuid4().hex[:16]}")
    try:
        with os.fdopen(os.open(temporary, _NEW_FILE, 0o644), "wb") as file:
            file.write(with_digest(content))
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def written_by_others(found: os.stat_result) -> bool:
    """Whether another user than this one and root owns a file or folder, or can write it."""
    if sys.platform == "win32":  # folders of a user are writable by this user alone
        return False
    strange = found.st_uid not in (os.geteuid(), 0)
    return strange or bool(found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


def make_folder(folder: Path) -> None:
    """Make a folder that only the user can write.

    Raises:
        OSError: it cannot be made, or is there and others can write it.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o755, exist_ok=True)
    if written_by_others(folder.stat()):
        raise PermissionError(f"{folder}: others can write it")
