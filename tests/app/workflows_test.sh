#!/usr/bin/env bash
# workflows_test.sh SOURCE_DIR: actionlint finds nothing wrong in .github/workflows. Exit code 77, skipped, where there is none.
set -euo pipefail
command -v actionlint >/dev/null || { echo "SKIPPED: there is no actionlint on the PATH"; exit 77; }
actionlint "$1"/.github/workflows/*.yml
