"""Making a seed: the entries that programs used, out of the caches that have them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tauten.model.kernels import (
    KernelCache,
    KernelCacheFile,
    Seed,
    SeedFile,
    has_ir,
    pack,
    portable_machine,
    without_ir,
)


def gather(
    caches: Iterable[KernelCache],
    folder: Path,
    seed: Seed | None,
    target: Path,
    everything: bool = False,
) -> None:
    """Copy the portable entries of these functions into a new folder, as entries that nothing used yet.

    Entries `without_ir` of functions that another kernel calls are left out: they have to be compiled again.

    Args:
        caches: of all kernels.
        folder: of entries that were compiled here.
        seed: entries that are shipped; None: there are none.
        target: to make.
        everything: whether the copies count as used, but for those of files from 1970, see `used_archive`.
    """
    target.mkdir(parents=True)
    caches = list(caches)
    called = _called(caches)
    for cache in caches:
        sources: list[KernelCacheFile] = [cache.file_in(folder)]
        if seed is not None:
            sources.append(SeedFile(seed, cache.file_name, cache.digest))
        for source in sources:
            for key, name in source.entries().items():
                data, copy = _portable(key, name, source), cache.file_in(target)
                if data is not None and (has_ir(data) or cache.name not in called):
                    copy.save(key, data)  # type: ignore[no-untyped-call]
                    shipped = isinstance(source, SeedFile)
                    if not (everything and (shipped or _used(folder / name))):
                        os.utime(target / copy.entries()[key], (0.0, 0.0))


def used_archive(caches: Iterable[KernelCache], folder: Path, target: Path) -> tuple[bytes, int]:
    """Pack the entries that programs used or made in a folder of `gather`: those of files not from 1970.

    Those of kernels that no other one calls are packed `without_ir`, which makes the archive half as large.

    Returns:
        The archive, and how many entries it has.
    """
    target.mkdir()
    caches, count = list(caches), 0
    called = _called(caches)
    for cache in caches:
        source = cache.file_in(folder)
        linked = cache.name in called
        used = {key: name for key, name in source.entries().items() if _used(folder / name)}
        for key in sorted(used, key=str):
            data = _portable(key, used[key], source)
            if data is not None:
                data = data if linked else without_ir(data)
                cache.file_in(target).save(key, data)  # type: ignore[no-untyped-call]
                count += 1
    return pack((path.name, path.read_bytes()) for path in target.iterdir()), count


def _used(file: Path) -> bool:
    return file.is_file() and file.stat().st_mtime > 1.0


def _called(caches: Iterable[KernelCache]) -> frozenset[str]:
    """Names of the functions that kernels call."""
    return frozenset[str]().union(*(cache.callees for cache in caches))


def _portable(key: tuple[Any, ...], name: str, source: KernelCacheFile) -> tuple[Any, ...] | None:
    """An entry for portable machines, in the file of this name; None where there is none that can be read."""
    if key[1] != portable_machine():
        return None
    try:
        found: tuple[Any, ...] = source.entry(name)
    except FileNotFoundError:
        return None
    return found
