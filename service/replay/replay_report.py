"""The result of a replay as files: the verdict as JSON, every tick as CSV."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

from tauten.service.process import write_text
from tauten.service.replay.replaying import Replay

VERDICT, TICKS = "replay.json", "replay.csv"


def write_report(replay: Replay, log: str, folder: Path) -> None:
    """Write both into a folder.

    Args:
        replay: the result.
        log: name of the log.
        folder: created where it does not exist.

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
        "cables": {
            name: {"pull_m": float(pull), "tension_n": float(tension)}
            for name, pull, tension in zip(replay.cables, replay.pull, replay.tension, strict=True)
        },
        "notes": list(replay.notes),
    }
    write_text(folder / VERDICT, json.dumps(verdict, indent=2) + "\n")
    write_text(folder / TICKS, tick_table(replay))


def tick_table(replay: Replay) -> str:
    """Every tick as a line of CSV: recorded and replayed pull [m], tension [N] and status."""
    courses, text = replay.courses, io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [
        f"{kind} {name} {when}"
        for name in replay.cables
        for kind in ("pull", "tension")
        for when in ("recorded", "replayed")
    ]
    writer.writerow(["tick", "time", *columns, "status recorded", "status replayed"])
    for tick, (time, status) in enumerate(zip(courses.time, courses.status, strict=True)):
        values = []
        for cable in range(len(replay.cables)):
            values += courses.pull[:, tick, cable].tolist()
            values += courses.tension[:, tick, cable].tolist()
        writer.writerow([tick, f"{time:.6f}", *(f"{value:.9g}" for value in values), *status])
    return text.getvalue()
