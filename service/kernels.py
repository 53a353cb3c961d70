"""Which kernels tauten has, and which of them the shipped file serves on this machine."""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from numba.core.dispatcher import Dispatcher

from tauten.model.kernels import (
    OFF,
    SEED,
    SHIPPED,
    SUFFIX,
    KernelCache,
    compiled_machine,
    kernel_folder,
    make_folder,
    open_seed,
    portable_machine,
    seed_file,
    seed_name,
)

PACKAGES = ("tauten.model", "tauten.reduction", "tauten.controller", "tauten.service")


@dataclass(frozen=True, slots=True)
class Inventory:
    """Kernels on this machine.

    Attributes:
        kernels: how many tauten has.
        machine: processor or level of instructions that this process compiles for.
        served: kernels whose code is shipped for this machine.
        changed: kernels whose sources have changed since the file was packed.
        entries: shipped entries of those that are served, one for each set of types of the arguments.
        why_not: why none is served, in one sentence; empty where some are.
        folder: of what was compiled here.
        not_kept: why what is compiled is not kept there; empty where it is.
        compiled: how many entries it has.
        size: of them [bytes].
    """

    kernels: int
    machine: str
    served: int
    changed: int
    entries: int
    why_not: str
    folder: str
    not_kept: str
    compiled: int
    size: int


def take_inventory() -> Inventory:
    """Look at all kernels of tauten, at the shipped file and at the user's folder."""
    caches = kernel_caches()
    seed = open_seed() if portable_machine() is not None else None
    names = set() if seed is None else seed.names()
    unchanged = [cache for cache in caches if f"{cache.file_name}.nbi" in names]
    shipped = {name.rpartition("-")[0] for name in names}
    known = [cache for cache in caches if cache.file_name.rpartition("-")[0] in shipped]
    served, here = {cache.file_name for cache in unchanged}, compiled_here()
    return Inventory(
        len(caches), compiled_machine()[1], len(unchanged), len(known) - len(unchanged),
        sum(name.endswith(".nbc") and name.rsplit(".", 2)[0] in served for name in names),
        "" if unchanged else why_none(),
        str(kernel_folder()), why_not_kept(), len(here), sum(path.stat().st_size for path in here),
    )  # fmt: skip


def compiled_here() -> list[Path]:
    """The kernels that have been compiled on this machine."""
    return list(kernel_folder().glob("*.nbc")) if kernel_folder().is_dir() else []


def waiting() -> str:
    """That kernels are compiled on this machine, for a text about a start; "" where they are shipped."""
    if portable_machine() is not None and open_seed() is not None:
        return ""
    return f"kernels are compiled the first time, which takes some minutes ({why_none()})"


def why_not_kept() -> str:
    """Why the user's folder does not keep what is compiled; empty where it does."""
    try:
        make_folder(kernel_folder())
        with tempfile.TemporaryFile(dir=kernel_folder()):
            return ""
    except OSError as error:
        return f"{error.filename}: {error.strerror.lower()}" if error.strerror else str(error)


def why_none() -> str:
    """Why no shipped kernel is used on this machine, in one sentence."""
    file = seed_file()
    if file is None:
        return f"{SEED} is {OFF}"
    if portable_machine() is None:
        return (
            "this processor lacks instructions of x86-64-v3, or NUMBA_CPU_NAME chooses another one"
        )
    if not file.is_file() and os.environ.get(SEED):
        return f"{SEED} is {file}, which is no file"
    if not file.is_file():
        have = sorted(path.name.removesuffix(SUFFIX) for path in SHIPPED.glob(f"*{SUFFIX}"))
        here = seed_name().removesuffix(SUFFIX)
        return f"here is {here}, shipped are {', '.join(have) if have else 'none'}"
    if open_seed() is None:
        return f"{file} cannot be unpacked"
    return "the sources of all of them have changed since they were packed"


def kernel_caches() -> list[KernelCache]:
    """Those of all kernels of tauten, of all its modules."""
    for name in PACKAGES:
        package = importlib.import_module(name)
        for module in pkgutil.walk_packages(package.__path__, f"{name}."):
            if not module.name.endswith("__main__"):
                _import(module.name)
    found = {}
    for name, loaded in list(sys.modules.items()):
        if name.startswith(PACKAGES):
            for value in list(vars(loaded).values()):
                cached = getattr(value, "_cache", None) if isinstance(value, Dispatcher) else None
                if isinstance(cached, KernelCache):
                    found[id(value)] = cached
    return sorted(found.values(), key=lambda cache: cache.file_name)


def _import(name: str) -> None:
    """Import a module, unless it needs an extra that is not installed."""
    try:
        importlib.import_module(name)
    except ImportError as error:
        if str(error.name).startswith("tauten"):
            raise
