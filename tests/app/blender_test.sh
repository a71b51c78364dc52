#!/usr/bin/env bash
# blender_test.sh SOURCE BUILD: the Blender extension, from installation to rendered pictures, in Blender as a Python module. Exit
# code 77, skipped, without tools/setup blender.
set -euo pipefail
python=${DRENCH_BLENDER_PYTHON:-$1/.deps/blender-venv/bin/python}
[[ -x $python ]] || { echo "skipped: tools/setup blender makes the Python that this test needs"; exit 77; }
DRENCH_PROGRAM=$2/drench exec "$python" "$1/python/blender/tests/run.py"
