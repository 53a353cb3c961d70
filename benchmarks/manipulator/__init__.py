"""The manipulator: steps per second, effect of contact, errors over modes."""

from benchmarks.manipulator.accuracy import KINDS, PostureError, posture_error
from benchmarks.manipulator.postures import arm_in_equilibrium, bent_tensions, random_postures
from benchmarks.manipulator.speed import Speed, gauss_seidel_step, measure_speed
from benchmarks.manipulator.study import ArmBench, ArmBenchSettings, bench_manipulator, parse_ks

__all__ = [
    "ArmBench",
    "ArmBenchSettings",
    "KINDS",
    "PostureError",
    "Speed",
    "arm_in_equilibrium",
    "bench_manipulator",
    "bent_tensions",
    "gauss_seidel_step",
    "measure_speed",
    "parse_ks",
    "posture_error",
    "random_postures",
]
