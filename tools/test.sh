#!/usr/bin/env bash
# Runs every test; arguments go to `cargo test`. A machine without a Vulkan device fails, since tests that skip show
# nothing: set PELLUCID_REQUIRE_GPU=0 to run the others there.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh --tests
export PELLUCID_REQUIRE_GPU="${PELLUCID_REQUIRE_GPU:-1}"
exec cargo test --locked "$@"
