#!/usr/bin/env bash
# Runs every test; arguments go to `cargo test`. A machine without a Vulkan device fails: set PELLUCID_REQUIRE_GPU=0 to
# run the others there. What is skipped is printed, as `skipped: <test>: <reason>`.
#
# With CI=true all that CI demands: tools/check.sh's lints, `pellucid check`, the book (tools/book.sh), the Python
# package (tools/python.sh), pellucid-mpi (tools/mpi.sh), the barriers of the release build (tools/barriers.sh) and the
# budget of registers on a GPU (docs/gpu-shape.md) before the tests, the long tests in a short form among them, and no
# skip but for the reasons that are named below.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh --tests
export PELLUCID_REQUIRE_GPU="${PELLUCID_REQUIRE_GPU:-1}"
# A first build has nothing to be incremental to.
if [[ ! -d target/debug/incremental ]]; then export CARGO_INCREMENTAL=0; fi
# Targets with tests. With no target named, `cargo test` builds every example as well, which tools/check.sh's clippy
# does faster.
targets=(--lib --bins --tests --example drivers --example gpu-shape --example study)
if [[ ${CI:-} != true ]]; then
    # Arguments may name targets of their own.
    if (($# > 0)); then exec cargo test --locked --workspace "$@"; fi
    cargo test --locked --workspace "${targets[@]}"
    exec cargo test --locked --workspace --doc
fi

# Nobody has the real clouds but some developers; tests/data stands in for them.
export PELLUCID_REQUIRE_ALL=1 PELLUCID_ALLOWED_SKIPS="${PELLUCID_ALLOWED_SKIPS:-no real clouds}"
# Nothing is built twice.
export CARGO_INCREMENTAL=0
tools/check.sh --lints
echo "== pellucid check, release build"
cargo build --locked --release
target/release/pellucid check
echo "== the book"
tools/book.sh
echo "== Python"
PELLUCID_BINARY=$PWD/target/release/pellucid tools/python.sh
echo "== MPI"
tools/mpi.sh
echo "== barriers of the release build"
tools/barriers.sh
echo "== registers, scratch and code size on a GPU's compiler"
cargo run --locked --release -p pellucid-lab --example gpu-shape -- --check
echo "== cargo test"
export PELLUCID_SHORT_SWEEPS=1
# GPU-assisted validation needs layers that no distribution has yet: CONTRIBUTING.md says how it is run.
cargo test --locked --workspace "${targets[@]}" -- --include-ignored --skip gpu_assisted_validation
exec cargo test --locked --workspace --doc -- --include-ignored
