"""Benchmarks of robots on this machine: steps, reduced models, the node, closed loops."""

from tauten.service.bench.closed_loop import ClosedLoopBench, bench_closed_loop
from tauten.service.bench.comparison import (
    CompareError,
    Comparison,
    Equilibrium,
    compare_equilibria,
    equilibrium,
)
from tauten.service.bench.doctor import examine
from tauten.service.bench.following import Trace, follow, reach_targets, rms, warmed
from tauten.service.bench.node import Deadlines, NodeBench, NodeBenchSettings, bench_node
from tauten.service.bench.reduced import (
    REACH,
    PathAccuracy,
    ReducedBench,
    ReducedCase,
    bench_reduced,
    path_accuracy,
    ramp_snapshots,
    unseen,
)
from tauten.service.bench.steps import (
    WARM_UP,
    Sizes,
    StepBench,
    bench_steps,
    forward_steps,
    sizes_of,
)

__all__ = [
    "ClosedLoopBench",
    "CompareError",
    "Comparison",
    "Deadlines",
    "Equilibrium",
    "NodeBench",
    "NodeBenchSettings",
    "PathAccuracy",
    "REACH",
    "ReducedBench",
    "ReducedCase",
    "Sizes",
    "StepBench",
    "Trace",
    "WARM_UP",
    "bench_closed_loop",
    "bench_node",
    "bench_reduced",
    "bench_steps",
    "compare_equilibria",
    "equilibrium",
    "examine",
    "follow",
    "forward_steps",
    "path_accuracy",
    "ramp_snapshots",
    "reach_targets",
    "rms",
    "sizes_of",
    "unseen",
    "warmed",
]
