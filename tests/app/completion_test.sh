#!/usr/bin/env bash
# completion_test.sh SOURCE BUILD: tools/completion/drench.bash completes what drench knows.
set -euo pipefail
# shellcheck source=/dev/null
source "$1/tools/completion/drench.bash"
expect() {  # WANTED WORD...: the last word is the one to complete
  local wanted=$1
  shift
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
  _drench
  [[ "${COMPREPLY[*]}" == "$wanted" ]] || { echo "$*: got '${COMPREPLY[*]}', wanted '$wanted'"; exit 1; }
}
cd "$1/scenes"
expect 'check' "$2/drench" ch
expect '--until' "$2/drench" run water_on_cloth.yaml --un
expect '--tolerance-scale' "$2/drench" compare --tol
expect 'reference' "$2/drench" run --backend ref
expect 'wring.yaml' "$2/drench" run wri
expect 'export' "$2/drench" ex
expect '--fps' "$2/drench" export gallery --f
expect '--prim' "$2/drench" import ladle.usdc --pr
expect 'bgeo' "$2/drench" export gallery --to bg
expect 'gallery' "$2/drench" export gal
expect 'report' "$2/drench" rep
expect 'gallery' "$2/drench" report gal
expect 'gallery' "$2/drench" report paper gal
if [[ -x $2/drench-view ]]; then
  expect 'view' "$2/drench" vi
  expect '--screenshot' "$2/drench" view gallery --scr
  expect 'surface' "$2/drench" view gallery --liquid su
  expect 'gallery' "$2/drench" view gal
  expect '--view' "$2/drench" run --vi
fi
expect 'bowl.obj' "$2/drench" new bo
expect 'iso811' "$2/drench" test iso8
expect '--fabric' "$2/drench" test iso811 --fa
expect 'fit' "$2/drench" fi
expect '--hold-out --hold-out-test' "$2/drench" fit heights.csv --hold
expect 'iso811' "$2/drench" fit heights.csv --test iso8
expect 'weft' "$2/drench" fit heights.csv --direction we
echo "all completed"
