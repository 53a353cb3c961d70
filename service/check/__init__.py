"""How wrong a robot's mesh is, and what else about its file is not plausible."""

from tauten.service.check.certificate import (
    MeshCertificate,
    certified,
    mesh_error_text,
    not_compared,
)
from tauten.service.check.control_findings import DECISION, PERIOD, first_decision
from tauten.service.check.findings import Finding
from tauten.service.check.mesh_error import MESH_ERROR, MeshErrorEstimate, VariantErrors
from tauten.service.check.mesh_variants import (
    Load,
    LoadedState,
    Variant,
    equilibria,
    make_loads,
    variant_robot,
)
from tauten.service.check.rate import (
    RateError,
    check_rate,
    faster,
    fits,
    rate_for,
    step_seconds,
)
from tauten.service.check.region_findings import RegionParts
from tauten.service.check.robot_check import CheckSettings, RobotCheck, check_robot, selected

__all__ = [
    "CheckSettings",
    "DECISION",
    "MESH_ERROR",
    "PERIOD",
    "Finding",
    "Load",
    "LoadedState",
    "MeshCertificate",
    "MeshErrorEstimate",
    "RateError",
    "RegionParts",
    "RobotCheck",
    "Variant",
    "VariantErrors",
    "certified",
    "check_rate",
    "check_robot",
    "equilibria",
    "faster",
    "first_decision",
    "fits",
    "make_loads",
    "mesh_error_text",
    "not_compared",
    "rate_for",
    "selected",
    "step_seconds",
    "variant_robot",
]
