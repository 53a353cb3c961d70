"""From a robot file to a robot."""

from tauten.model.load.beam_bodies import beam_network
from tauten.model.load.beams import groups
from tauten.model.load.bodies import Bodies, build_bodies, mesh_files, read_bodies
from tauten.model.load.extensions import check_interface, extension, extension_names, made
from tauten.model.load.robot import (
    build_robot,
    command_name,
    is_shipped,
    load_part,
    load_robot,
    make_robot,
    part_path,
    robot_path,
    shipped_folder,
)

__all__ = [
    "Bodies",
    "beam_network",
    "build_bodies",
    "build_robot",
    "check_interface",
    "command_name",
    "extension",
    "extension_names",
    "made",
    "groups",
    "is_shipped",
    "load_part",
    "load_robot",
    "make_robot",
    "mesh_files",
    "part_path",
    "read_bodies",
    "robot_path",
    "shipped_folder",
]
