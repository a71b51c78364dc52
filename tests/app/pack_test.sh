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

foreign=$(LD_DEBUG=libs bin/drench --version 2>&1 | sed -n 's/.*calling init: //p' | grep -v "^$PWD/" |
  grep -Ev '/(ld-linux[^/]*|lib(c|m|pthread|dl|rt|cuda)\.so[^/]*)$' || true)
[[ -z $foreign ]] || fail "libraries from outside the pack: $foreign"

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
echo "pack_test: passed"
