"""Tools of an operator: commands, metrics, recording, diagnosis."""

from tauten.service.operate.commands import (
    ask_metrics,
    is_there,
    node_of,
    send_command,
    serve_metrics,
)
from tauten.service.operate.doctor import examine
from tauten.service.operate.locks import OrderError, check_order, send_lock
from tauten.service.operate.record import record_robot

__all__ = [
    "OrderError",
    "ask_metrics",
    "check_order",
    "examine",
    "is_there",
    "node_of",
    "record_robot",
    "send_command",
    "send_lock",
    "serve_metrics",
]
