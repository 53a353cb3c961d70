"""Scripts that make the shipped robots: meshes and robot files."""

from benchmarks.robots.arm import ArmShape, bending_tensions

__all__ = ["ArmShape", "bending_tensions"]
