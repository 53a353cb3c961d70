#!/usr/bin/env bash
# The steps of the image, each a command of its own, so that they run without a container engine too:
#   docker/build_steps.sh install PREFIX SOURCE    a virtual environment with tauten from a source tree
#   docker/build_steps.sh warm PREFIX              compile its kernels into PREFIX/cache
#   docker/build_steps.sh check PREFIX             what the image must be able to do
set -euo pipefail

install_into() {
  python3 -m venv "$1"
  "$1/bin/pip" install --quiet --no-cache-dir --constraint "$2/.ci/constraints.txt" "$2[fast]"
}

warm() {
  # a short run of the finger and its plant compiles all that they need
  NUMBA_CACHE_DIR="$1/cache" OMP_NUM_THREADS=1 "$1/bin/python" - <<'PYTHON'
from tauten.controller import warm_controller
from tauten.model import one_blas_thread
from tauten.service.node import ControlLoop
from tauten.service.plant.plant import PlantSettings, warm_simulator
from tauten.service.setup import load_setup

setup = load_setup("finger")
with one_blas_thread():
    ControlLoop(warm_controller(setup))
    for robot in (setup.robot, setup.in_full_order().robot):  # the plant takes either
        simulator = warm_simulator(robot, PlantSettings())
        for share in (0.25, 0.5, 0.75):
            simulator.settle(position=share * robot.limits.position_max, tolerance=1e-4)
PYTHON
  test -n "$(find "$1/cache" -name '*.nbi' -print -quit)"
}

check() {
  cd /
  "$1/bin/tauten" --help >/dev/null
  NUMBA_CACHE_DIR="$1/cache" OMP_NUM_THREADS=1 "$1/bin/tauten" --log-level error doctor finger --seconds 1
}

case "${1:-}" in
  install) install_into "$2" "$3" ;;
  warm) warm "$2" ;;
  check) check "$2" ;;
  *) sed -n '2,5p' "$0" >&2; exit 2 ;;
esac
