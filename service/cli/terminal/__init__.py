"""Options that several commands share, and how commands show and write what they have."""

from tauten.service.cli.terminal.extras import ExtraError, missing_extra
from tauten.service.cli.terminal.logs import general_options
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
    Robots,
    ServedName,
    StepsOption,
    YoungScale,
    ZenohConfig,
    basis_of,
)
from tauten.service.cli.terminal.output import (
    drawable,
    progress_bar,
    show_mesh_error,
    show_result,
    writable,
    write_json,
)

__all__ = [
    "AcceptError",
    "Basis",
    "ClosedLoop",
    "DriveOption",
    "ExtraError",
    "Json",
    "Markdown",
    "Model",
    "Port",
    "Rate",
    "RobotName",
    "Robots",
    "ServedName",
    "StepsOption",
    "YoungScale",
    "ZenohConfig",
    "basis_of",
    "general_options",
    "missing_extra",
    "progress_bar",
    "show_mesh_error",
    "show_result",
    "drawable",
    "writable",
    "write_json",
]
