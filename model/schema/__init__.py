"""What a robot file may say, validated field by field."""

from tauten.model.schema.beam_file import BarSettings, BeamConfig, Structure, TubeSettings, Vertebra
from tauten.model.schema.robot_file import (
    Box,
    CableSettings,
    RobotConfig,
    RobotFileError,
    RobotSettings,
    SurfaceSettings,
    check_surfaces,
    read_toml,
    validated,
)

__all__ = [
    "BarSettings",
    "BeamConfig",
    "Box",
    "CableSettings",
    "RobotConfig",
    "RobotFileError",
    "RobotSettings",
    "Structure",
    "SurfaceSettings",
    "TubeSettings",
    "Vertebra",
    "check_surfaces",
    "read_toml",
    "validated",
]
