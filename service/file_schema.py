"""The JSON Schema of a robot file, over the tables of all layers.

Editors complete and check TOML files with it: `tauten schema > tauten.schema.json`, and as first line of a
robot file `#:schema tauten.schema.json`.
"""

from __future__ import annotations

from typing import Any

from pydantic import Field, TypeAdapter

from tauten.controller import ControllerTable, ModelSettings
from tauten.model.schema import PartsConfig, RobotConfig, Section
from tauten.service.settings import ServiceSettings

DIALECT = "https://json-schema.org/draft/2020-12/schema"


CONTROLLER = Field(default=ControllerTable(), description="Control rate and inverse control.")


class ServiceTables(Section):
    """The tables of model and service, which every kind of robot file has."""

    model: ModelSettings = Field(default=ModelSettings(), description="The model that decides.")
    service: ServiceSettings = Field(
        default=ServiceSettings(), description="Time-outs and feedback of the node."
    )


class RobotFile(ServiceTables, RobotConfig):
    """The file of a robot of one or several bodies."""

    controller: ControllerTable = CONTROLLER


class PartsRobotFile(ServiceTables, PartsConfig):
    """The file of a robot of several parts, each of which has a robot file."""

    controller: ControllerTable = CONTROLLER


def robot_file_schema() -> dict[str, Any]:
    """The JSON Schema of all robot files, with a description of each field."""
    kinds: TypeAdapter[RobotFile | PartsRobotFile] = TypeAdapter(RobotFile | PartsRobotFile)
    made = kinds.json_schema()
    return {"$schema": DIALECT, "title": "tauten robot file", **made}
