#!/usr/bin/env bash
# Builds in release, once and with one set of features, what CI tests of it: pellucid, pellucid-mpi, gpu-shape, and all
# that the wheel is made of. tools/python.sh, tools/mpi.sh and tools/barriers.sh take it from there with CI=true.
# Arguments replace `build` and its targets: tools/mpi.sh runs `tools/release.sh test --test mpi`.
#
# Cargo compiles a crate anew for each set of features of what it depends on. The sets of two builds are the same only
# if both name the same packages and features, and if both or neither need what is for tests and examples. The features
# of the wheel alone, which maturin builds, are made the same by `unified` (crates/python/Cargo.toml). To look at the
# difference, compare `cargo tree --prefix none -f '{p} {f}'` of both, with `-e normal,build,dev` here and
# `-e normal,build` for the wheel.
set -euo pipefail
cd "$(dirname "$0")/.."

if (($# == 0)); then set -- build --bins --example gpu-shape; fi
command=$1
shift
exec cargo "$command" --locked --release --workspace --features pellucid-cli/mpi,pellucid-python/unified "$@"
