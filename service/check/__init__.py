"""How wrong a robot's mesh is, and what else about its file is not plausible."""

from tauten.service.check.findings import Finding, Level
from tauten.service.check.mesh_error import (
    LoadError,
    MeshErrorEstimate,
    Reference,
    VariantErrors,
    richardson,
)
from tauten.service.check.mesh_variants import Load, LoadedState, Variant, VariantStates
from tauten.service.check.robot_check import CheckSettings, RobotCheck, check_robot

__all__ = [
    "CheckSettings",
    "Finding",
    "Level",
    "Load",
    "LoadError",
    "LoadedState",
    "MeshErrorEstimate",
    "Reference",
    "RobotCheck",
    "Variant",
    "VariantErrors",
    "VariantStates",
    "check_robot",
    "richardson",
]
