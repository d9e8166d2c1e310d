#!/usr/bin/env bash
# All tests. The recorded oracles need data that may not be redistributed: ../shared/data beside this
# checkout, or the folder that PFRONT_DATA names. Those of the GPU run on the best adapter; where there is
# none, Mesa's lavapipe is installed, which runs on the CPU.
set -euo pipefail
cd "$(dirname "$0")"
export PFRONT_DATA="${PFRONT_DATA:-$(cd .. && pwd)/shared/data}"
.ci/vulkan
features=gpu
if [ -f "$PFRONT_DATA/oracle/cases.json" ]; then
  features=recorded,gpu
else
  echo "NOT RUN: tests/recorded.rs and tests/recorded_gpu.rs, for want of $PFRONT_DATA/oracle/cases.json (set PFRONT_DATA)" >&2
fi
cargo test --workspace --features "$features" "$@"
