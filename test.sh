#!/usr/bin/env bash
# All tests, with a summary of what ran and what did not.
#
# ./test.sh [--fast | --all] [arguments of cargo test]
#
# GPU tests run on the best adapter; where there is none, Mesa's lavapipe is installed (about 100 MB), which runs on
# the CPU. The recorded oracles need data that may not be redistributed: ../shared/data beside this checkout, or the
# folder that PFRONT_DATA names. --fast leaves out everything about GPUs and the command. Only --all has the tests of the lab, which measures
# and is not published, and for which another library is compiled.
set -euo pipefail
cd "$(dirname "$0")"
export PFRONT_DATA="${PFRONT_DATA:-$(cd .. && pwd)/shared/data}"
left_out=()
what=(--workspace) features=gpu,glam033,glam034,serde
if [ "${1:-}" = --all ]; then
  shift
else
  what+=(--exclude pfront-lab)
  left_out+=("the lab (--all)")
fi
if [ "${1:-}" = --fast ]; then
  shift
  what=(-p pfront -p pfront-core -p pfront-blob -p pfront-cpu -p pfront-shaders) features=glam033,glam034,serde
  left_out+=("GPUs and the command (--fast)")
else
  .ci/vulkan
fi
if [ -f "$PFRONT_DATA/oracle/cases.json" ]; then
  features=recorded,$features
else
  left_out+=("tests/recorded, for want of $PFRONT_DATA/oracle/cases.json (set PFRONT_DATA)")
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
outcome=0
cargo test "${what[@]}" --features "$features" "$@" 2>&1 | tee "$log" || outcome=$?

printf '\n== summary, after %d minutes\n' $((SECONDS / 60))
awk '/^test result:/ { suites++; passed += $4; failed += $6; ignored += $8 }
  END { printf "%d suites: %d tests passed, %d failed, %d ignored\n", suites, passed, failed, ignored }' "$log"
sed -n 's/^test \(.*\) \.\.\. FAILED$/FAILED: \1/p' "$log"
for name in "${left_out[@]}"; do echo "NOT RUN: $name"; done
exit "$outcome"
