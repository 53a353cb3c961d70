#!/usr/bin/env bash
# The first hour: from a part of CAD (STEP) to a robot that follows targets, with the time of each command.
# Usage: examples/first_hour.sh [PART.step] [FOLDER]   needs the extras mesh and viewer; no display, no network
set -euo pipefail
export LC_ALL=C.UTF-8 # times with a point

folder=$(realpath -m "${2:-$(mktemp -d)/first-hour}")
part=${1:-}
[ -z "$part" ] || part=$(realpath "$part")
mkdir -p "$folder"
cd "$folder"
begin=$EPOCHREALTIME

timed() { # what it does, then the command
  local what=$1 start=$EPOCHREALTIME
  shift
  echo "== $what: $*"
  "$@"
  printf '== %s took %.1f s, %.1f s since the start, load %s\n\n' "$what" \
    "$(awk "BEGIN { print $EPOCHREALTIME - $start }")" "$(awk "BEGIN { print $EPOCHREALTIME - $begin }")" \
    "$(cut -d' ' -f1 /proc/loadavg 2>/dev/null || echo unknown)"
}

draw_part() { # a finger with a channel for its cable and notches below: its weight bends it towards the cable
  python3 - <<'PYTHON'
from netgen.occ import Box, Cylinder, X

finger = Box((0, 0, 0), (90, 16, 18))
for x in range(14, 89, 15):
    finger = finger - Box((x, -1, -1), (x + 4, 17, 11))
(finger - Cylinder((-1, 8, 3), X, 0.8, 92)).WriteStep("finger.step")
PYTHON
}

if [ -z "$part" ]; then
  timed "part" draw_part
  part=finger.step
fi
timed "robot file" tauten new finger --mesh "$part" --young 1e6
timed "fast model" tauten reduce finger/finger.toml --states --write
timed "targets" tauten demo finger/finger.toml --seconds 20 --out finger/demo
timed "replay" tauten replay finger/demo/log.mcap
timed "page" tauten view finger/demo/log.mcap --export finger/demo/run.html
echo "all of it is in $folder"
