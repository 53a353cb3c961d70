"""The shipped robots: files, meshes, contact bases and the scripts that make them."""

from tauten.model.robots.arm import ArmShape, bending_tensions

__all__ = ["ArmShape", "bending_tensions"]
