"""Benchmarks."""

from tauten.service.bench.arm_accuracy import KINDS, PostureError, draw_errors, posture_error
from tauten.service.bench.arm_postures import bent_tensions, random_postures, settled
from tauten.service.bench.arm_speed import Speed, gauss_seidel_step, measure_speed
from tauten.service.bench.closed_loop import (
    Bench,
    BenchSettings,
    ClosedLoopBench,
    bench_closed_loop,
    planned,
)
from tauten.service.bench.closed_loop_cases import CASES, Case, make_cases
from tauten.service.bench.closed_loop_figures import draw_case
from tauten.service.bench.closed_loop_run import Outcome, Trace, follow, judge, settling
from tauten.service.bench.comparison import CompareError, Comparison, compare, equilibrium
from tauten.service.bench.contact_basis import Inputs, bench_contact_basis
from tauten.service.bench.contact_basis_results import (
    ContactBasisBench,
    HeldOutError,
    TrainingError,
)
from tauten.service.bench.manipulator import ArmBench, parse_ks
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
    PathError,
    ReducedBench,
    ReducedCase,
    bench_reduced,
)
from tauten.service.bench.stages import STAGES, WHOLE, StepTimes
from tauten.service.bench.steps import ControlBench, StepBench, bench_control, bench_steps

__all__ = [
    "ArmBench",
    "Bench",
    "BenchSettings",
    "CASES",
    "Case",
    "ClosedLoopBench",
    "CompareError",
    "Comparison",
    "ContactBasisBench",
    "ControlBench",
    "Deadlines",
    "HeldOutError",
    "Inputs",
    "KINDS",
    "MeshCase",
    "NodeBench",
    "NodeBenchSettings",
    "Outcome",
    "PathError",
    "PostureError",
    "ReducedBench",
    "ReducedCase",
    "STAGES",
    "Speed",
    "StepBench",
    "StepTimes",
    "Trace",
    "TrainingError",
    "WHOLE",
    "bench_closed_loop",
    "bench_contact_basis",
    "bench_control",
    "bench_node",
    "bench_reduced",
    "bench_steps",
    "bent_tensions",
    "compare",
    "deadlines",
    "draw_case",
    "draw_errors",
    "equilibrium",
    "follow",
    "gauss_seidel_step",
    "idle_loop",
    "judge",
    "make_cases",
    "measure_speed",
    "parse_ks",
    "planned",
    "posture_error",
    "random_postures",
    "settled",
    "settling",
]
