"""The process around the service: signals, host facts, real-time priority. It loads nothing of the model."""

from tauten.service.process.host import HostInfo, busy, host_info
from tauten.service.process.locking import alone_in, locked_new
from tauten.service.process.progress import Progress
from tauten.service.process.queues import drained
from tauten.service.process.realtime import (
    ORDINARY,
    RealtimeError,
    RealtimeSettings,
    apply_realtime,
    give_lower_priority,
    has_realtime_priority,
    realtime_permitted,
)
from tauten.service.process.runtime import (
    manual_garbage_collection,
    short_switch_interval,
    versions,
)
from tauten.service.process.stopping import Interrupted, StopFlag, stop_on_signals

__all__ = [
    "Progress",
    "HostInfo",
    "ORDINARY",
    "RealtimeError",
    "RealtimeSettings",
    "Interrupted",
    "StopFlag",
    "alone_in",
    "apply_realtime",
    "busy",
    "drained",
    "give_lower_priority",
    "has_realtime_priority",
    "host_info",
    "locked_new",
    "manual_garbage_collection",
    "realtime_permitted",
    "short_switch_interval",
    "stop_on_signals",
    "versions",
]
