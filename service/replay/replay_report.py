"""The result of a replay as files: the verdict as JSON, every tick as CSV."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

from tauten.reduction import write_text
from tauten.service.replay.replaying import Replay

VERDICT, TICKS = "replay.json", "replay.csv"


def write_report(replay: Replay, log: str, folder: Path) -> None:
    """Write both into a folder.

    Raises:
        OSError: the folder cannot be written to.
    """
    verdict = {
        "log": log,
        "same": replay.same,
        "ticks": replay.ticks,
        "tolerance": replay.tolerance,
        "fraction": replay.fraction,
        "worst_tick": replay.worst_tick,
        "statuses": replay.statuses,
        "speed": replay.speed,
        "actuators": {
            name: {
                "kind": kind.value,
                "pull": float(replay.position[i]),
                "pull_unit": kind.position.unit,
                "tension": float(replay.effort[i]),
                "tension_unit": kind.effort.unit,
            }
            for i, (name, kind) in enumerate(
                zip(replay.actuators.names, replay.actuators.kinds, strict=True)
            )
        },
        "notes": list(replay.notes),
        "mesh_error": replay.mesh_error,
    }
    write_text(folder / VERDICT, json.dumps(verdict, indent=2) + "\n")
    write_text(folder / TICKS, tick_table(replay))


def tick_table(replay: Replay) -> str:
    """Every tick as a line of CSV: recorded and replayed position, effort and status, in SI units."""
    courses, text = replay.courses, io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [
        f"{kind} {name} {when}"
        for name in replay.actuators.names
        for kind in ("pull", "tension")
        for when in ("recorded", "replayed")
    ]
    writer.writerow(["tick", "time", *columns, "status recorded", "status replayed"])
    for tick, (time, status) in enumerate(zip(courses.time, courses.status, strict=True)):
        values = []
        for place in range(len(replay.actuators)):
            values += courses.position[:, tick, place].tolist()
            values += courses.effort[:, tick, place].tolist()
        writer.writerow([tick, f"{time:.6f}", *(f"{value:.9g}" for value in values), *status])
    return text.getvalue()
