#!/usr/bin/env bash
# over_ranks.sh RANKS FILTER [--same] TESTS...: runs a program of tests, with --gtest_filter=FILTER, on so many MPI ranks.
# --same: and in one process, and compares the bits of the states that either comes to.
# Exit code 77 if there is no mpirun, or the program knows no MPI.
set -euo pipefail
ranks=$1 filter=$2 same=''
shift 2
if [[ $1 == --same ]]; then same=1; shift; fi
command -v mpirun >/dev/null || exit 77
ldd "$1" | grep -q libmpi || exit 77
for name in OMPI_ALLOW_RUN_AS_ROOT OMPI_ALLOW_RUN_AS_ROOT_CONFIRM PRTE_ALLOW_RUN_AS_ROOT PRTE_ALLOW_RUN_AS_ROOT_CONFIRM \
            OMPI_MCA_rmaps_base_oversubscribe OMPI_MCA_mpi_yield_when_idle; do
  export "$name=${!name:-1}"
done
export OMPI_MCA_hwloc_base_binding_policy=none PRTE_MCA_hwloc_default_binding_policy=none \
       PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
OMP_NUM_THREADS=1 mpirun -n "$ranks" "$1" --gtest_filter="$filter" ${same:+--gtest_output=xml:ranks.xml}
[[ $same ]] || exit 0
"$1" --gtest_filter="$filter" --gtest_output=xml:one.xml --gtest_brief=1 >/dev/null
# The bits, in the order of the tests.
bits() { grep -oE '(testcase name="[^"]*")|(name="bits_[0-9]+" value="[0-9a-f]*")' "$1"; }
bits one.xml > one
bits ranks.xml > ranks
grep -c bits_ one | sed 's/$/ states compared/'
diff one ranks
