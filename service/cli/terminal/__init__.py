"""Options that several commands share, and how commands show and write what they have."""

from tauten.service.cli.terminal.extras import ExtraError, missing_extra
from tauten.service.cli.terminal.logs import JsonLines, LogFormat, set_up_logging
from tauten.service.cli.terminal.options import (
    AcceptError,
    Basis,
    ClosedLoop,
    DriveOption,
    Json,
    Markdown,
    Model,
    Port,
    Rate,
    RobotName,
    StepsOption,
    YoungScale,
    ZenohConfig,
)
from tauten.service.cli.terminal.output import (
    progress_bar,
    show_mesh_error,
    show_tables,
    write_json,
)

__all__ = [
    "AcceptError",
    "Basis",
    "ClosedLoop",
    "DriveOption",
    "ExtraError",
    "Json",
    "JsonLines",
    "LogFormat",
    "Markdown",
    "Model",
    "Port",
    "Rate",
    "RobotName",
    "StepsOption",
    "YoungScale",
    "ZenohConfig",
    "missing_extra",
    "progress_bar",
    "set_up_logging",
    "show_mesh_error",
    "show_tables",
    "write_json",
]
