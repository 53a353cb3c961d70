"""Making a seed: the entries that programs used, out of the caches that have them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tauten.model.kernels.cache import KernelCache, KernelCacheFile, SeedFile
from tauten.model.kernels.linking import without_ir
from tauten.model.kernels.seed import Seed, pack
from tauten.model.kernels.target import portable_machine


def gather(caches: Iterable[KernelCache], folder: Path, seed: Seed | None, target: Path) -> None:
    """Copy the portable entries of these functions into a new folder, as entries that nothing used yet."""
    target.mkdir(parents=True)
    for cache in caches:
        sources: list[KernelCacheFile] = [cache.file_in(folder)]
        if seed is not None:
            sources.append(SeedFile(seed, cache.file_name, cache.digest))
        for source in sources:
            for key in source.entries():
                _copy(key, source, cache.file_in(target))
    for path in target.iterdir():
        os.utime(path, (0.0, 0.0))


def used_archive(
    caches: Iterable[KernelCache], folder: Path, target: Path, everything: bool = False
) -> tuple[bytes, int]:
    """Pack the entries that programs used or made in a folder of `gather`.

    Those of kernels that no other one calls are packed `without_ir`, which makes the archive half as large.

    Args:
        caches: of all kernels.
        folder: of `gather`.
        target: to make, for the entries.
        everything: whether to pack the entries too that no program used, but for those of kernels that others
            call: most of these are there for the callers, whose machine code contains them.

    Returns:
        The archive, and how many entries it has.
    """
    target.mkdir()
    caches, count = list(caches), 0
    called = frozenset[str]().union(*(cache.callees for cache in caches))
    for cache in caches:
        source = cache.file_in(folder)
        linked = cache.name in called
        unused = everything and not linked
        used = [key for key, name in source.entries().items() if unused or _used(folder / name)]
        for key in sorted(used, key=str):
            count += _copy(key, source, cache.file_in(target), linked)
    return pack((path.name, path.read_bytes()) for path in target.iterdir()), count


def _used(file: Path) -> bool:
    return file.is_file() and file.stat().st_mtime > 1.0


def _copy(
    key: tuple[Any, ...], source: KernelCacheFile, target: KernelCacheFile, linked: bool = True
) -> bool:
    """Copy an entry for portable machines; whether there is one that can be read."""
    data = source.load(key) if key[1] == portable_machine() else None  # type: ignore[no-untyped-call]
    if data is None:
        return False
    target.save(key, data if linked else without_ir(data))  # type: ignore[no-untyped-call]
    return True
