"""How wrong a robot's mesh is, and what else about its file is not plausible."""

from tauten.service.check.findings import Finding
from tauten.service.check.mesh_error import MeshErrorEstimate, VariantErrors, richardson
from tauten.service.check.mesh_variants import Variant, variant_robot
from tauten.service.check.robot_check import CheckSettings, RobotCheck, check_robot

__all__ = [
    "CheckSettings",
    "Finding",
    "MeshErrorEstimate",
    "RobotCheck",
    "Variant",
    "VariantErrors",
    "check_robot",
    "richardson",
    "variant_robot",
]
