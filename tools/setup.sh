#!/usr/bin/env bash
# Installs what pellucid needs in addition to Rust: a Vulkan loader, a Vulkan driver, a C compiler; with --tests the
# validation layers, a browser, ffmpeg, jq and a display without a screen with a window manager as well; in CI (CI=true)
# also a Wayland compositor, which takes 95 MB, and OpenEXR for Python, which comes from PyPI and goes to
# target/openexr. On Debian and Ubuntu missing packages are installed with apt, elsewhere they are named. Does nothing,
# at once, where nothing is missing. With --mpi also Open MPI, unless there is an MPI already, and libclang, to build
# pellucid-mpi (docs/many-machines.md).
set -euo pipefail

usage="usage: tools/setup.sh [--tests] [--mpi]"
for_tests=false
for_mpi=false
for argument in "$@"; do
    case $argument in
        --tests) for_tests=true ;;
        --mpi) for_mpi=true ;;
        -h | --help) echo "$usage"; exit 0 ;;
        *) echo "error: unknown argument '$argument'; $usage" >&2; exit 2 ;;
    esac
done

min_rust=1.90
# Debian keeps ldconfig out of the PATH of ordinary users.
libraries=$(PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null || true)
# Where the loader looks for the manifests of drivers and layers.
vulkan_dirs=(
    "${XDG_CONFIG_HOME:-${HOME:-}/.config}/vulkan" /etc/xdg/vulkan /usr/local/etc/vulkan /etc/vulkan
    "${XDG_DATA_HOME:-${HOME:-}/.local/share}/vulkan" /usr/local/share/vulkan /usr/share/vulkan
)

say() { echo "setup: $*" >&2; }
fail() { echo "error: $*" >&2; exit 1; }

has_rust() {
    command -v cargo >/dev/null || return 1
    local version
    version=$(cargo --version | sed -E 's/^cargo ([0-9]+\.[0-9]+).*/\1/')
    [[ $(printf '%s\n' "$min_rust" "$version" | sort -V | head -n 1) == "$min_rust" ]]
}

has_compiler() { command -v cc >/dev/null; }

has_loader() { [[ $libraries == *libvulkan.so.1* ]]; }

# Checks that the library that a driver's manifest names is there; a manifest alone drives nothing.
driver_library_exists() {
    local library
    library=$(sed -nE 's/.*"library_path"[[:space:]]*:[[:space:]]*"([^"]+)".*/\1/p' "$1")
    case $library in
        "") return 1 ;;
        /*) [[ -e $library ]] ;;
        */*) [[ -e $(dirname "$1")/$library ]] ;;
        *) [[ $libraries == *"$library"* ]] ;;
    esac
}

# A driver can be used if it runs on the CPU, or if a GPU's device file is there as well.
has_driver() {
    if [[ -n ${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-} ]]; then
        return 0
    fi
    local dir manifest
    for dir in "${vulkan_dirs[@]}"; do
        for manifest in "$dir"/icd.d/*.json; do
            # A pattern without a match stands for itself.
            if [[ ! -e $manifest ]] || ! driver_library_exists "$manifest"; then continue; fi
            case ${manifest##*/} in
                lvp_icd* | vk_swiftshader_icd*) return 0 ;;
                nvidia_icd*) if [[ -e /dev/nvidiactl ]]; then return 0; fi ;;
                *) if compgen -G "/dev/dri/renderD*" >/dev/null; then return 0; fi ;;
            esac
        done
    done
    return 1
}

has_layers() {
    if [[ -n ${VK_LAYER_PATH:-} && -e $VK_LAYER_PATH/VkLayer_khronos_validation.json ]]; then
        return 0
    fi
    local dir
    for dir in "${vulkan_dirs[@]}"; do
        if [[ -e $dir/explicit_layer.d/VkLayer_khronos_validation.json ]]; then return 0; fi
    done
    return 1
}

# The names that crates/testing/src/browser.rs looks for.
has_browser() {
    [[ -n ${CHROME:-} ]] || command -v google-chrome || command -v chromium || command -v chromium-browser
} >/dev/null

# Libraries that the window library loads when `view` runs on X11; Wayland's are part of its desktops.
has_x11() {
    local library
    for library in libX11.so.6 libX11-xcb.so.1 libXcursor.so.1 libXi.so.6 libxkbcommon-x11.so.0; do
        [[ $libraries == *"$library"* ]] || return 1
    done
}

# Checks that tests can read deep EXR files by OpenEXR's own library.
openexr=$(dirname "$0")/../target/openexr
has_openexr() { [[ -x $openexr/bin/python ]] && "$openexr/bin/python" -c "import OpenEXR, numpy" 2>/dev/null; }

has_mpi() { command -v mpicc && command -v mpirun; } >/dev/null

# By which the bindings to MPI are made.
has_libclang() {
    [[ -n ${LIBCLANG_PATH:-} ]] || compgen -G "/usr/lib/llvm-*/lib/libclang.so*" || compgen -G "/usr/lib/llvm-*/lib/libclang-[0-9]*.so*"
} >/dev/null

# Fills `names` and `packages` with what is missing.
find_missing() {
    names=() packages=()
    if ! has_compiler; then names+=("a C compiler (cc)") packages+=(gcc libc6-dev); fi
    if ! has_loader; then names+=("the Vulkan loader (libvulkan.so.1)") packages+=(libvulkan1); fi
    if ! has_driver; then
        names+=("a Vulkan driver (a GPU's, or Mesa's lavapipe for the CPU)") packages+=(mesa-vulkan-drivers)
    fi
    if $for_tests && ! has_layers; then
        names+=("the Vulkan validation layers (VK_LAYER_KHRONOS_validation)") packages+=(vulkan-validationlayers)
    fi
    if $for_tests && ! command -v jq >/dev/null; then names+=("jq, which docs/ci/pellucid.yml uses") packages+=(jq); fi
    if $for_tests && ! has_browser; then
        names+=("a browser (Chromium or Chrome; or name it in CHROME)") packages+=(chromium)
    fi
    if $for_tests && ! { command -v ffmpeg && command -v ffprobe; } >/dev/null; then
        names+=("ffmpeg and ffprobe, by which films are encoded and looked at") packages+=(ffmpeg)
    fi
    if $for_tests && ! { command -v Xvfb && command -v xdotool; } >/dev/null; then
        names+=("Xvfb and xdotool, a display and a user for the tests of the window") packages+=(xvfb xdotool)
    fi
    if $for_tests && ! command -v man >/dev/null; then names+=("man, by which manual pages are rendered") packages+=(man-db); fi
    if $for_tests && ! command -v ctwm >/dev/null; then
        names+=("ctwm, a window manager for the tests of the window") packages+=(ctwm)
    fi
    if $for_tests && [[ ${CI:-} == true ]] && ! command -v weston >/dev/null; then
        names+=("weston, a Wayland compositor for a test of the window") packages+=(weston)
    fi
    if $for_tests && [[ ${CI:-} == true ]] && ! command -v python3 >/dev/null; then
        names+=("python3, for the tests of the scripts in tools") packages+=(python3)
    fi
    # Debian's python3 makes no environments by itself.
    if $for_tests && [[ ${CI:-} == true ]] && ! has_openexr && ! python3 -c "import ensurepip" 2>/dev/null; then
        names+=("python3-venv, for an environment with OpenEXR") packages+=(python3-venv)
    fi
    if $for_mpi && ! has_mpi; then names+=("an MPI (mpicc, mpirun)") packages+=(libopenmpi-dev openmpi-bin); fi
    if $for_mpi && ! has_libclang; then names+=("libclang") packages+=(libclang-dev); fi
    if $for_tests && ! has_x11; then
        names+=("the X11 libraries of a window") packages+=(libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0)
    fi
}

# The distribution's suite that offers the newest Mesa, as in bookworm-backports; nothing without apt's lists.
newest_mesa_suite() {
    apt-cache madison mesa-vulkan-drivers 2>/dev/null | awk -F ' *[|] *' '{ print $2, $3 }' | sort -rV |
        awk 'NR == 1 { sub("/.*", "", $3); print $3 }'
}

# Which Mesa drives the CPU, and whether the distribution has a newer one, which is faster.
say_mesa() {
    command -v dpkg-query >/dev/null && command -v apt-cache >/dev/null || return 0
    local installed offered
    installed=$(dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null) || return 0
    offered=$(apt-cache madison mesa-vulkan-drivers 2>/dev/null | awk -F ' *[|] *' '{ print $2 }' | sort -rV | head -n 1)
    if [[ -n $offered ]] && dpkg --compare-versions "$offered" gt "$installed"; then
        say "Mesa $installed is installed; $offered is offered, and faster: apt-get install -t $(newest_mesa_suite) mesa-vulkan-drivers"
    elif $installs; then
        say "took Mesa $installed"
    fi
}

list() { printf '  %s\n' "$@" >&2; }

install() {
    local as_root=()
    if [[ $(id -u) != 0 ]]; then
        command -v sudo >/dev/null || fail "not root and no sudo; as root run: apt-get install ${packages[*]}"
        as_root=(sudo)
    fi
    say "installing ${packages[*]}"
    # Old lists may still do when a mirror is out of reach, so that a failed update decides nothing.
    "${as_root[@]}" apt-get update -qq || say "apt-get update failed; trying with the lists at hand"
    local get=(env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq -o=Dpkg::Use-Pty=0 --no-install-recommends)
    local suite=""
    if [[ " ${packages[*]} " == *" mesa-vulkan-drivers "* ]]; then suite=$(newest_mesa_suite); fi
    # Backports are enabled by whoever wants newer packages, but taken only where asked for by name.
    if [[ $suite == *-backports ]]; then
        "${as_root[@]}" "${get[@]}" -t "$suite" mesa-vulkan-drivers >&2 ||
            say "apt-get could not install mesa-vulkan-drivers of $suite; taking the distribution's own"
    fi
    "${as_root[@]}" "${get[@]}" "${packages[@]}" >&2 || fail "apt-get could not install ${packages[*]}"
}

has_rust || fail "cargo $min_rust or newer is needed, found $(cargo --version 2>/dev/null || echo none); get it at https://rustup.rs"

find_missing
installs=false
if ((${#packages[@]} > 0)); then
    if ! command -v apt-get >/dev/null; then
        say "missing:"
        list "${names[@]}"
        fail "please install them with your system's package manager and try again"
    fi
    install
    installs=true
    libraries=$(PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null || true)
    find_missing
    if ((${#packages[@]} > 0)); then
        say "still missing after the installation:"
        list "${names[@]}"
        exit 1
    fi
fi
if $for_tests && [[ ${CI:-} == true ]] && ! has_openexr; then
    say "downloading OpenEXR and numpy from PyPI to target/openexr"
    python3 -m venv "$openexr" &&
        "$openexr/bin/pip" install -q --disable-pip-version-check --only-binary :all: \
            -r "$(dirname "$0")/../crates/cli/tests/cli/deep/requirements.txt" >&2 ||
        fail "pip could not install OpenEXR, by which tests read deep EXR files"
fi
say_mesa
