"""What a robot file may say, validated field by field."""

from tauten.model.schema.beam_file import BarSettings, BeamConfig, Structure, TubeSettings, Vertebra
from tauten.model.schema.material import LawName, SolidMaterialSettings
from tauten.model.schema.robot_file import (
    CableSettings,
    ElementName,
    RobotConfig,
    RobotFileError,
    RobotSettings,
    SurfaceSettings,
    check_surfaces,
    read_toml,
    validated,
)
from tauten.model.schema.section import Box

__all__ = [
    "BarSettings",
    "BeamConfig",
    "Box",
    "CableSettings",
    "ElementName",
    "LawName",
    "RobotConfig",
    "RobotFileError",
    "RobotSettings",
    "SolidMaterialSettings",
    "Structure",
    "SurfaceSettings",
    "TubeSettings",
    "Vertebra",
    "check_surfaces",
    "read_toml",
    "validated",
]
