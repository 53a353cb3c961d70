"""The computer that a measurement was made on."""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from pathlib import Path

from tauten.service.process.runtime import versions


@dataclass(frozen=True, slots=True)
class HostInfo:
    """Facts that times depend on.

    Attributes:
        processor: model name.
        cores: processors that this process may use.
        system: operating system.
        python: version.
        factorisations: installed back ends, fastest first.
        versions: of the packages that numbers depend on.
        load: mean number of processes ready to run in the last minute; other programs that run at the
            same time make a benchmark slower.
    """

    processor: str
    cores: int
    system: str
    python: str
    factorisations: tuple[str, ...]
    versions: dict[str, str]
    load: float


def host_info() -> HostInfo:
    """Facts about this computer."""
    from tauten.model.numerics import installed_backends

    return HostInfo(
        processor=_processor(),
        cores=len(os.sched_getaffinity(0)),
        system=platform.platform(),
        python=platform.python_version(),
        factorisations=installed_backends(),
        versions=versions(),
        load=os.getloadavg()[0],
    )


def busy() -> str:
    """That other programs take the processors that this one may use, "" where they do not."""
    load, cores = os.getloadavg()[0], len(os.sched_getaffinity(0))
    if load <= cores:
        return ""
    return f"this computer is busy (load {load:.1f} on {cores} processors), on an idle one steps are shorter"


def _processor() -> str:
    facts = Path("/proc/cpuinfo")
    if facts.is_file():
        for line in facts.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown"
