#!/usr/bin/env bash
# Builds the Python package, installs it into target/python, an environment with everything that its tests want, and
# runs the tests, mypy, stubtest and ruff. Arguments go to pytest. The wheel is in target/wheels; it is installed into
# an environment with nothing else as well, where README's lines must run.
#
#   tools/python.sh --environment   makes the environment alone
#   tools/python.sh --install       builds and installs, and tests nothing
#   tools/python.sh --wheel         builds the wheel for all Linux distributions (manylinux), and checks its size
set -euo pipefail
cd "$(dirname "$0")/.."

say() { echo "== $*"; }
fail() { echo "error: $*" >&2; exit 1; }

largest_wheel=$((15 << 20))
# The compiler of wheels for all distributions, which no test needs.
ziglang=ziglang==0.17.1
environment=$PWD/target/python
mode=test
case ${1:-} in
    --environment) mode=environment; shift ;;
    --install) mode=install; shift ;;
    --wheel) mode=wheel; shift ;;
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac

# Packages that Debian leaves out of python3 and of a system without a desktop: environments, and libraries of
# Open3D and VTK.
install_packages() {
    local libraries packages=()
    libraries=$(PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null || true)
    command -v python3 >/dev/null || packages+=(python3)
    python3 -c "import ensurepip, venv" 2>/dev/null || packages+=(python3-venv)
    if [[ $mode == test || $mode == environment ]] && [[ $(uname -s) == Linux ]]; then
        local library package
        while read -r library package; do
            if [[ $libraries != *"$library"* ]]; then packages+=("$package"); fi
        done <<'LIST'
libusb-1.0.so.0 libusb-1.0-0
libgomp.so.1 libgomp1
libGL.so.1 libgl1
libX11.so.6 libx11-6
libXrender.so.1 libxrender1
LIST
    fi
    if ((${#packages[@]} == 0)); then return; fi
    command -v apt-get >/dev/null || fail "missing: ${packages[*]}; please install them with your system's package manager"
    local as_root=()
    if [[ $(id -u) != 0 ]]; then as_root=(sudo); fi
    say "installing ${packages[*]}"
    "${as_root[@]}" apt-get update -qq || true
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq -o=Dpkg::Use-Pty=0 --no-install-recommends "${packages[@]}"
}

# The environment, made anew where its list has changed.
make_environment() {
    local list=python/requirements-test.txt
    # The package needs 3.10, and what its tests need 3.11.
    python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' || fail "Python 3.11 or newer is needed, found $(python3 --version)"
    if ! cmp -s "$list" "$environment/requirements.txt"; then
        say "making $environment"
        python3 -m venv --clear "$environment"
        # What is imported is compiled then; the rest, most of it, never.
        "$environment/bin/pip" install -q --disable-pip-version-check --only-binary :all: --no-compile -r "$list"
        cp "$list" "$environment/requirements.txt"
    fi
}

build_wheel() {
    rm -rf target/wheels
    # A library for Python has no use for symbols; the workspace's release profile strips them as well.
    # maturin finds zig by the Python that comes first.
    (cd python && PATH="$environment/bin:$PATH" maturin build --locked --out ../target/wheels "$@")
    wheel=$(ls target/wheels/pellucid-*.whl)
    local bytes
    bytes=$(wc -c <"$wheel")
    say "$wheel: $bytes bytes"
    if [[ " $* " == *" dev "* ]]; then return; fi
    ((bytes <= largest_wheel)) || fail "$wheel has $bytes bytes, more than the $largest_wheel that are allowed"
}

install_packages
make_environment
if [[ $mode == environment ]]; then exit 0; fi
if [[ $mode == wheel ]]; then
    "$environment/bin/pip" install -q --disable-pip-version-check --only-binary :all: "$ziglang"
    build_wheel --zig --compatibility manylinux_2_17
    exit 0
fi
say "maturin build"
# In CI with the profile and the features of what tools/test.sh built, so that no crate is compiled again. No other code
# gets in.
if [[ $mode == test && ${CI:-} == true ]]; then build_wheel --profile dev --features unified; else build_wheel; fi
"$environment/bin/pip" install -q --disable-pip-version-check --force-reinstall --no-deps "$wheel"
if [[ $mode == install ]]; then exit 0; fi

say "README's lines in an environment of their own"
rm -rf target/python-clean
# It has nothing but Python; the pip of the other one serves both.
python3 -m venv --without-pip target/python-clean
"$environment/bin/pip" --python target/python-clean install -q --disable-pip-version-check "$wheel"
readme=$(awk '/^```python$/ { on = 1; next } /^```$/ { if (on) exit } on' python/README.md)
(cd target/python-clean && bin/python -c "$readme" && cmp -n 8 cloud.png <(printf '\x89PNG\r\n\x1a\n'))

say "ruff, mypy, stubtest"
(cd python && "$environment/bin/ruff" check . && "$environment/bin/ruff" format --check .)
(cd python && "$environment/bin/mypy")
# Against what is installed, from a folder where nothing else is called pellucid.
(cd target/wheels && "$environment/bin/python" -m mypy.stubtest pellucid._pellucid --mypy-config-file ../../python/pyproject.toml)

say "pytest"
if [[ -z ${PELLUCID_BINARY:-} ]]; then
    # Of the same sources: pictures are compared byte by byte.
    cargo build --locked --release
    export PELLUCID_BINARY=$PWD/target/release/pellucid
fi
exec "$environment/bin/python" -m pytest -c python/pyproject.toml --rootdir python python/tests "$@"
