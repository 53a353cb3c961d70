"""Real-time priority and processors of the loop's thread, where the system permits them.

Both are set once the other threads run: these keep the ordinary policy and all processors.
"""

from __future__ import annotations

import os
from dataclasses import dataclass


class RealtimeError(RuntimeError):
    """Priority or processors that the system does not permit; the message names the way to get them."""


@dataclass(frozen=True, slots=True)
class RealtimeSettings:
    """Scheduling of the loop's thread.

    Attributes:
        priority: of SCHED_FIFO, 1 to 99; None: the ordinary scheduler.
        cpus: processors it may use; empty: all.
    """

    priority: int | None = None
    cpus: tuple[int, ...] = ()


ORDINARY = RealtimeSettings()
_LESS_URGENT, _LEAST_URGENT = 10, 19  # niceness


def apply_realtime(settings: RealtimeSettings) -> None:
    """Set priority and processors of the calling thread.

    Raises:
        RealtimeError: not permitted, or no such processor.
    """
    if settings.cpus:
        allowed = os.sched_getaffinity(0)
        missing = sorted(set(settings.cpus) - allowed)
        if missing:
            raise RealtimeError(f"no processor {missing[0]} here: allowed are {sorted(allowed)}")
        os.sched_setaffinity(0, settings.cpus)
    if settings.priority is not None:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(settings.priority))
        except PermissionError as error:
            raise RealtimeError(
                f"SCHED_FIFO at priority {settings.priority} is not permitted: run with the capability "
                "CAP_SYS_NICE, set LimitRTPRIO in the systemd unit or rtprio in limits.conf, or "
                "leave --priority out"
            ) from error


def has_realtime_priority() -> bool:
    """Whether the calling thread runs under SCHED_FIFO or SCHED_RR."""
    policy = os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK
    return policy in (os.SCHED_FIFO, os.SCHED_RR)


def realtime_permitted() -> bool:
    """Whether SCHED_FIFO is permitted; the policy is the same afterwards."""
    before, param = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except PermissionError:
        return False
    os.sched_setscheduler(0, before, param)
    return True


def give_lower_priority(process: int) -> None:
    """Make a process or thread, which has not ended, less urgent than the caller, as far as that is possible.

    The niceness follows that of the caller: under `nice -n 15` a fixed one of 10 would be a higher priority,
    which an ordinary user may not give. Number 0 is the caller.

    Raises:
        ProcessLookupError: there is none of this number.
    """
    niceness = min(os.getpriority(os.PRIO_PROCESS, 0) + _LESS_URGENT, _LEAST_URGENT)
    os.setpriority(os.PRIO_PROCESS, process, niceness)
