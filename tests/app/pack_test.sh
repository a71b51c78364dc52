#!/usr/bin/env bash
# pack_test.sh SOURCE BUILD: what tools/pack packs runs elsewhere, on its own libraries, and its summary counts.
set -euo pipefail
source=$1 build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "pack_test: $*" >&2; exit 1; }

"$source/tools/pack" --build "$build" -o "$work/pack.tgz"
mkdir "$work/elsewhere"
tar -xzf "$work/pack.tgz" -C "$work/elsewhere"
cd "$work/elsewhere/drench-pack"

# MPI is the machine's own where it has one. A file for each process; that of the shell, which becomes the program, is the one that names it.
LD_DEBUG=libs LD_DEBUG_OUTPUT=$work/libraries bin/drench --version >/dev/null
foreign=$(cat "$(grep -l 'programs/drench' "$work"/libraries.*)" | sed -n 's/.*calling init: //p' | grep -v "^$PWD/" |
  grep -Ev '/(ld-linux[^/]*|lib(c|m|pthread|dl|rt|cuda)\.so[^/]*)$' | grep -Ev '/lib(mpi|open-|event|hwloc|pmix)[^/]*$' || true)
[[ -z $foreign ]] || fail "libraries from outside the pack: $foreign"

# Without a policy for threads that wait, the program would start itself anew with one; the loader that runs it cannot.
env -u OMP_NUM_THREADS -u OMP_WAIT_POLICY -u GOMP_SPINCOUNT bin/drench info >/dev/null || fail "info fails"

cd "$work"
pack=elsewhere/drench-pack
"$pack/run-tests" -j 2 app -- --gtest_filter='Commands.Info*:Commands.FramesMatch*:SceneLoader.LoadsAndRewritesEvery*' >log || { cat log; fail "tests fail"; }
grep -q '^  app: 3 of 3 passed' log || { cat log; fail "the summary does not count"; }
"$pack/run-tests" app -- --gtest_filter='no.such.test' >log && fail "no test ran, and that passed"
# A scene that cannot be loaded is a failure that is printed, and an exit code.
echo "drench: 7" >"$pack/scenes/bad.yaml"
"$pack/run-tests" app -- --gtest_filter='SceneLoader.LoadsAndRewritesEvery*:Commands.Info*' >log && fail "a failure passed"
grep -q 'bad.yaml' log || { cat log; fail "the failure is not shown"; }
grep -q '^  app: 1 of 2 passed.*FAILED' log || { cat log; fail "the summary does not count failures"; }
# A test that takes too long, and one that crashes: both are named, and the others still run.
cat >"$pack/bin/drench_tests_slow" <<'END'
#!/bin/sh
case "$*" in
  *list_tests*) printf 'Slow.\n  Quick\n  Sleeps\n  Crashes  # GetParam() = 1\n' ;;
  *Sleeps*) sleep 60 ;;
  *Crashes*) kill -SEGV $$ ;;
  *) echo '[==========] 1 test from 1 test suite ran. (0 ms total)' ;;
esac
END
chmod +x "$pack/bin/drench_tests_slow"
"$pack/run-tests" -j 2 --timeout 1 slow >log && fail "a test without end passed"
for line in '^  slow: 1 of 3 passed.*FAILED: 2' 'Slow.Sleeps (timed out)' 'Slow.Crashes (exit code 139)'; do
  grep -q "$line" log || { cat log; fail "the summary lacks '$line'"; }
done
"$pack/run-tests" --only '^Slow.Qu' slow >log || { cat log; fail "--only takes what it should not"; }
# A bundle runs its scene without a build, also where no compiler is found.
"$source/tools/pack" --build "$build" --bundle -o "$work/bundle.tgz" >/dev/null
tar -xzf "$work/bundle.tgz" -C "$work"
cd "$work"/drench-*-linux-*
[[ -x $(echo build/*/drench) && -f README.md && ! -e prebuilt/*/bin/drench_tests_app ]] || fail "the bundle lacks files"
kind=$(basename "$(echo prebuilt/*)")
CXX=/bin/false tools/run --build "${kind%-*}" --precision "${kind#*-}" scenes/water_on_cloth.yaml --steps 2 --set output.every=0 -o out/two >log 2>&1 ||
  { cat log; fail "the bundle does not run"; }
[[ -s out/two/stats.csv && ! -e build/$kind/CMakeCache.txt ]] || fail "the bundle built something"
echo "pack_test: passed"
