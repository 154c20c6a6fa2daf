#!/usr/bin/env bash
# Installs MPI (tools/setup.sh --mpi), builds pellucid-mpi in release, lints it and runs its tests with up to 4 ranks,
# however few cores there are. With CI=true the build is the one that tools/test.sh made.
# PELLUCID_MPIRUN names another mpirun than the one in the PATH; MPICC then has to name its compiler, as in
#   MPICC=mpicc.mpich PELLUCID_MPIRUN=mpirun.mpich tools/mpi.sh
# Arguments go to the tests.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh --tests --mpi
export PELLUCID_REQUIRE_GPU="${PELLUCID_REQUIRE_GPU:-1}"
# Bindings stay those of the MPI for which they were made.
made=${CARGO_TARGET_DIR:-target}/mpicc
if [[ $(cat "$made" 2>/dev/null || echo mpicc) != "${MPICC:-mpicc}" ]]; then
    cargo clean --locked -p mpi-sys
    cargo clean --locked --release -p mpi-sys
fi
mkdir -p "${made%/*}"
echo "${MPICC:-mpicc}" >"$made"
if [[ ${CI:-} == true ]]; then
    # tools/check.sh linted it, and tools/test.sh runs the tests of units with this feature.
    exec cargo test --locked --workspace --features pellucid-cli/mpi,pellucid-python/unified --test mpi -- "$@"
fi
cargo clippy --locked -p pellucid-cli --features mpi --all-targets -- -D warnings
cargo build --locked --release -p pellucid-cli --features mpi --bin pellucid-mpi --bin pellucid
tests=(--locked --release -p pellucid-cli --features mpi)
cargo test "${tests[@]}" --lib -- mpi documents
exec cargo test "${tests[@]}" --test mpi -- "$@"
