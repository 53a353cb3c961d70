"""The contents of robot files, validated field by field."""

from tauten.model.schema.beam_file import BarSettings, BeamConfig, Structure, TubeSettings, Vertebra
from tauten.model.schema.effector import COMPONENTS, EffectorKind, EffectorSettings
from tauten.model.schema.material import LawName, MaterialSettings
from tauten.model.schema.robot_file import (
    CableSettings,
    Changes,
    ControlPeriod,
    ElementName,
    RobotConfig,
    RobotSettings,
    SurfaceSettings,
    check_surfaces,
    model_tables,
)
from tauten.model.schema.section import (
    LARGEST_COORDINATE,
    Box,
    Name,
    Positive,
    Rate,
    RobotFileError,
    Section,
    in_range,
    read_text,
    read_toml,
    validated,
)

__all__ = [
    "BarSettings",
    "BeamConfig",
    "Box",
    "COMPONENTS",
    "CableSettings",
    "Changes",
    "ControlPeriod",
    "EffectorKind",
    "EffectorSettings",
    "ElementName",
    "LARGEST_COORDINATE",
    "LawName",
    "MaterialSettings",
    "Name",
    "Positive",
    "Rate",
    "RobotConfig",
    "RobotFileError",
    "RobotSettings",
    "Section",
    "Structure",
    "SurfaceSettings",
    "TubeSettings",
    "Vertebra",
    "check_surfaces",
    "in_range",
    "model_tables",
    "read_text",
    "read_toml",
    "validated",
]
