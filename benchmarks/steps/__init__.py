"""Times of whole steps: by kind of contact, on SOFA's meshes, of the gallery. Errors of reduced models."""

from benchmarks.steps.control import ControlBench, bench_control
from benchmarks.steps.gallery import GalleryBench, bench_gallery
from benchmarks.steps.load_bench import LoadBench, LoadRow, RobotLoads, bench_load_errors
from benchmarks.steps.load_comparison import ForeignLoadError, load_errors
from benchmarks.steps.mesh_distance import DistanceBench, bench_mesh_distance
from benchmarks.steps.reduced_meshes import MeshCase, ReducedMeshes, bench_reduced_meshes
from benchmarks.steps.sofa_meshes import SofaMeshBench, bench_sofa_meshes
from benchmarks.steps.stages import STAGES, WHOLE, StepTimes, time_controller

__all__ = [
    "ForeignLoadError",
    "load_errors",
    "ControlBench",
    "DistanceBench",
    "GalleryBench",
    "LoadBench",
    "LoadRow",
    "MeshCase",
    "ReducedMeshes",
    "RobotLoads",
    "STAGES",
    "StepTimes",
    "WHOLE",
    "SofaMeshBench",
    "bench_control",
    "bench_gallery",
    "bench_load_errors",
    "bench_mesh_distance",
    "bench_reduced_meshes",
    "bench_sofa_meshes",
    "time_controller",
]
