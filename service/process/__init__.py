"""The process around the service: signals, logs, files, host facts, real-time priority."""

from tauten.service.process.atomic_write import write_text
from tauten.service.process.host import HostInfo, host_info
from tauten.service.process.logs import JsonLines, set_up_logging
from tauten.service.process.realtime import (
    ORDINARY,
    RealtimeError,
    RealtimeSettings,
    apply_realtime,
    has_realtime_priority,
    realtime_permitted,
)
from tauten.service.process.runtime import collector_at_hand, one_blas_thread, short_turns, versions
from tauten.service.process.stopping import StopFlag, stop_on_signals

__all__ = [
    "HostInfo",
    "JsonLines",
    "ORDINARY",
    "RealtimeError",
    "RealtimeSettings",
    "StopFlag",
    "apply_realtime",
    "collector_at_hand",
    "has_realtime_priority",
    "host_info",
    "one_blas_thread",
    "realtime_permitted",
    "set_up_logging",
    "short_turns",
    "stop_on_signals",
    "versions",
    "write_text",
]
