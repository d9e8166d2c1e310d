#!/usr/bin/env bash
# All tests. The recorded oracles need data that may not be redistributed: ../shared/data beside this
# checkout, or the folder that PFRONT_DATA names.
set -euo pipefail
cd "$(dirname "$0")"
export PFRONT_DATA="${PFRONT_DATA:-$(cd .. && pwd)/shared/data}"
features=()
if [ -f "$PFRONT_DATA/oracle/cases.json" ]; then
  features=(--features recorded)
else
  echo "NOT RUN: tests/recorded.rs, for want of $PFRONT_DATA/oracle/cases.json (set PFRONT_DATA)" >&2
fi
cargo test --workspace "${features[@]}" "$@"
