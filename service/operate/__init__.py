"""Tools of an operator: commands, metrics, recording, diagnosis."""

from tauten.service.operate.commands import (
    NodeAnswer,
    OrderError,
    ask_metrics,
    is_there,
    node_of,
    put_command,
    send_command,
    serve_metrics,
)
from tauten.service.operate.doctor import examine
from tauten.service.operate.locks import check_order, send_lock
from tauten.service.operate.record import record_robot

__all__ = [
    "NodeAnswer",
    "OrderError",
    "ask_metrics",
    "check_order",
    "examine",
    "is_there",
    "node_of",
    "put_command",
    "record_robot",
    "send_command",
    "send_lock",
    "serve_metrics",
]
