"""The way to a node, with Zenoh alone: keys, modes, sessions, commands and their answers.

A command in an emergency loads this folder and nothing of the model.
"""

from tauten.service.link.commanding import (
    OrderError,
    ask,
    ask_metrics,
    is_there,
    node_of,
    put_command,
    send_command,
    step_at_start,
)
from tauten.service.link.keys import Keys
from tauten.service.link.modes import Cause, LockOrder, Mode, OperatorCommand, OperatorOrder
from tauten.service.link.network import (
    HIGHEST_PORT,
    HOST,
    LOWEST_PORT,
    ZENOH_CONFIG_VARIABLE,
    Network,
    NetworkError,
    Role,
    address,
    announced,
    await_token,
    close_session,
    default_port,
    is_alive,
    open_session,
    read_config,
    served_name,
    session_of,
)

__all__ = [
    "HOST",
    "LOWEST_PORT",
    "HIGHEST_PORT",
    "ZENOH_CONFIG_VARIABLE",
    "Cause",
    "Keys",
    "LockOrder",
    "Mode",
    "Network",
    "NetworkError",
    "OperatorCommand",
    "OperatorOrder",
    "OrderError",
    "Role",
    "address",
    "announced",
    "ask",
    "ask_metrics",
    "await_token",
    "default_port",
    "is_alive",
    "is_there",
    "node_of",
    "close_session",
    "open_session",
    "put_command",
    "read_config",
    "send_command",
    "served_name",
    "session_of",
    "step_at_start",
]
