"""Speed of this computer: the time of a control step, and the rate that it permits."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

from tauten.controller import Controller, part_files, target_beside
from tauten.model import Robot
from tauten.model.load import command_name, is_shipped
from tauten.model.schema import ACTUATOR_TABLES, read_toml
from tauten.reduction.state import SUFFIX as STATES
from tauten.service.process import busy

log = logging.getLogger(__name__)

_STEPS = 25
_SHARE = 0.8  # of the period that a step may take at the rate that is recommended
_ROUNDING = 1e-9  # relative


class RateError(ValueError):
    """A rate that this computer cannot hold; the text names one that it can."""


def step_seconds(
    controller: Controller, steps: int = _STEPS, clock: Callable[[], float] = perf_counter
) -> float:
    """Median time of a control step [s] towards a target beside the robot; ends at rest.

    Args:
        controller: at its start.
        steps: how many.
        clock: `perf_counter`, or `thread_time` for the time of a computer that does nothing else.
    """
    away = target_beside(controller)
    times = []
    for _ in range(steps):
        begin = clock()
        controller.step(away)
        controller.prepare()
        times.append(clock() - begin)
    controller.reset()
    controller.prepare()
    return float(np.median(times))


def rate_for(seconds: float) -> float:
    """Largest rate [Hz] of two digits at which a step of this time leaves a fifth of the period."""
    rate = _SHARE / seconds
    digit = 10.0 ** (math.floor(math.log10(rate)) - 1)
    return float(f"{digit * math.floor(rate / digit * (1.0 + _ROUNDING)):.2g}")


def fits(rate: float, seconds: float) -> bool:
    """Whether a control step of this time leaves a part of the period [Hz, s] for all else."""
    return seconds * rate <= _SHARE * (1.0 + _ROUNDING)


def reducing(path: Path) -> str:
    """What gives a reduced model of a robot: commands, of one of parts one for each part with actuators.

    The file of a shipped robot is not changed, and `--model reduced` takes the state basis that is shipped.

    Raises:
        RobotFileError: it cannot be read.
    """
    parts = dict.fromkeys(part_files(read_toml(path), path))
    files = [file for file in parts if not read_toml(file).keys().isdisjoint(ACTUATOR_TABLES)]
    return " and ".join(dict.fromkeys(map(_reducing, files or [path])))


def _reducing(file: Path) -> str:
    """What gives a reduced model of the robot of one file."""
    if not is_shipped(file):
        return f"tauten reduce {command_name(file)} --states --write"
    if file.with_suffix(STATES).is_file():
        return "--model reduced"
    return f"tauten reduce --states --write with a copy of the files of {file.stem}"


def faster(
    path: Path,
    seconds: float,
    reduced: bool,
    robot: Robot | None = None,
    option: bool = False,
    here: bool = False,
) -> str:
    """How the steps of a robot come to fit its period, in one sentence.

    Args:
        path: of the robot file; that of a shipped robot is not to be changed.
        seconds: time of a control step.
        reduced: whether its model is reduced already.
        robot: what moves objects by friction throws them where its actuators move farther in a tick; None:
            nothing is known of it.
        option: whether the command has an option for the rate.
        here: whether the real clock timed the step, which is longer where other programs run: that is said.

    Raises:
        RobotFileError: the file cannot be read.
    """
    shipped, rate = is_shipped(path), f"{rate_for(seconds):g}"
    if option:
        rate = f"use --rate {rate}"
    else:
        rate = f"serve it with --rate {rate}" if shipped else f"set controller.rate = {rate}"
    if robot is not None and robot.contacts.frictional and robot.contacts.loose:
        rate += " and every max_rate lower by the same factor (else objects are thrown)"
    if not reduced:
        rate = f"{reducing(path)} gives a model with faster steps; or {rate}"
    elif not shipped:
        rate += ", or reduce with fewer modes"
    others = busy() if here else ""
    return f"{rate}; {others}" if others else rate


def check_rate(rate: float, seconds: float, requested: bool, advice: str) -> None:
    """Make sure that the rate can be held.

    Args:
        rate: of the loop [Hz].
        seconds: time of a control step.
        requested: whether the rate was given on the command line; the robot file's gives only a warning.
        advice: how the steps of this robot come to fit.

    Raises:
        RateError: a rate given on the command line cannot be held.
    """
    if seconds * rate <= 1.0:
        return
    text = f"{rate:g} Hz cannot be held: a control step takes {1e3 * seconds:.1f} ms here; {advice}"
    if requested:
        raise RateError(text)
    log.warning("%s", text)
