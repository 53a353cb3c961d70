"""Benchmarks."""

from tauten.service.bench.arm_accuracy import KINDS, PostureError, posture_error
from tauten.service.bench.arm_postures import arm_in_equilibrium, bent_tensions, random_postures
from tauten.service.bench.arm_speed import Speed, gauss_seidel_step, measure_speed
from tauten.service.bench.closed_loop import (
    CaseRuns,
    ClosedLoopBench,
    ClosedLoopRunner,
    ClosedLoopSettings,
    bench_closed_loop,
    planned,
)
from tauten.service.bench.closed_loop_cases import CASES, Case, make_cases
from tauten.service.bench.closed_loop_run import Outcome, Trace, case_outcome, follow, settling
from tauten.service.bench.comparison import (
    CompareError,
    Comparison,
    Equilibrium,
    compare_equilibria,
    equilibrium,
)
from tauten.service.bench.contact_basis import ContactBasisInputs, bench_contact_basis
from tauten.service.bench.contact_basis_results import (
    ContactBasisBench,
    HeldOutError,
    TrainingError,
)
from tauten.service.bench.gallery import GalleryBench, GalleryRow, LoadRow, bench_gallery
from tauten.service.bench.manipulator import ArmBench, ArmBenchSettings, bench_manipulator, parse_ks
from tauten.service.bench.node import (
    Deadlines,
    NodeBench,
    NodeBenchSettings,
    bench_node,
    deadlines,
    idle_loop,
)
from tauten.service.bench.reduced import (
    MeshCase,
    PathAccuracy,
    ReducedBench,
    ReducedCase,
    bench_reduced,
)
from tauten.service.bench.stages import STAGES, WHOLE, StepTimes
from tauten.service.bench.steps import (
    ControlBench,
    SofaMeshBench,
    StepBench,
    bench_control,
    bench_sofa_meshes,
    bench_steps,
)

__all__ = [
    "GalleryBench",
    "GalleryRow",
    "bench_gallery",
    "ArmBench",
    "ArmBenchSettings",
    "CASES",
    "Case",
    "CaseRuns",
    "ClosedLoopBench",
    "ClosedLoopRunner",
    "ClosedLoopSettings",
    "CompareError",
    "Comparison",
    "ContactBasisBench",
    "ContactBasisInputs",
    "ControlBench",
    "Deadlines",
    "Equilibrium",
    "HeldOutError",
    "KINDS",
    "LoadRow",
    "MeshCase",
    "NodeBench",
    "NodeBenchSettings",
    "Outcome",
    "PathAccuracy",
    "PostureError",
    "ReducedBench",
    "ReducedCase",
    "STAGES",
    "SofaMeshBench",
    "Speed",
    "StepBench",
    "StepTimes",
    "Trace",
    "TrainingError",
    "WHOLE",
    "arm_in_equilibrium",
    "bench_closed_loop",
    "bench_contact_basis",
    "bench_control",
    "bench_manipulator",
    "bench_node",
    "bench_reduced",
    "bench_sofa_meshes",
    "bench_steps",
    "bent_tensions",
    "case_outcome",
    "compare_equilibria",
    "deadlines",
    "equilibrium",
    "follow",
    "gauss_seidel_step",
    "idle_loop",
    "make_cases",
    "measure_speed",
    "parse_ks",
    "planned",
    "posture_error",
    "random_postures",
    "settling",
]
