"""Benchmark of the QPCC solver: problems, oracles, quality, times."""

from benchmarks.qpcc.bench import QpccBench, bench_qpcc
from benchmarks.qpcc.global_optimum import branch_and_bound
from benchmarks.qpcc.oracle import enumerate_pieces, scip_optimum
from benchmarks.qpcc.quality import QpccCase, Quality, generated, measure
from benchmarks.qpcc.random_problems import (
    RobotLike,
    degenerate,
    known_global,
    known_stationary,
    nasty,
    nonsense,
    robot_like,
)
from benchmarks.qpcc.recorded import Recorded, load_recorded, save_recorded
from benchmarks.qpcc.times import Size, SolveTimes, make_problems, time_solves

__all__ = [
    "QpccBench",
    "QpccCase",
    "Quality",
    "Recorded",
    "RobotLike",
    "Size",
    "SolveTimes",
    "bench_qpcc",
    "branch_and_bound",
    "degenerate",
    "enumerate_pieces",
    "generated",
    "known_global",
    "known_stationary",
    "load_recorded",
    "make_problems",
    "measure",
    "nasty",
    "nonsense",
    "robot_like",
    "save_recorded",
    "scip_optimum",
    "time_solves",
]
