#!/usr/bin/env bash
# Makes the files of a release for this platform in target/package: an archive, and on Linux a Debian package and the
# Python wheel, with SHA256SUMS. Needs cargo-about, and on Linux cargo-deb:
#   cargo install --locked cargo-deb; cargo install --locked --features cli cargo-about
#
#   tools/package.sh                 builds and packs everything
#   tools/package.sh --no-wheel      without the wheel; --no-deb without the Debian package
#   tools/package.sh --crates        packs the .crate files as well, unverified
#   tools/package.sh --binary FILE   packs this binary instead of building one; with --target TRIPLE it is that target's
#   tools/package.sh --try ROOT      installs what is in target/package into ROOT, the folder of a bare Debian, and
#                                    renders there;
#                                    with --scan FILE this scan, and with --no-wheel without Python
set -euo pipefail
cd "$(dirname "$0")/.."

say() { echo "== $*"; }
fail() { echo "error: $*" >&2; exit 1; }

packages=$PWD/target/package
stage=$packages/stage
version=$(sed -nE '/^\[workspace.package\]/,/^\[/s/^version = "(.*)"/\1/p' Cargo.toml)
target=$(rustc -vV | sed -n 's/^host: //p')
binary="" root="" scan=tests/data/lidar/sample_c_2k.las wheel=true deb=true crates=false
while (($# > 0)); do
    case $1 in
        --no-wheel) wheel=false ;;
        --no-deb) deb=false ;;
        --crates) crates=true ;;
        --binary) binary=$2; shift ;;
        --target) target=$2; shift ;;
        --try) root=$2; shift ;;
        --scan) scan=$2; shift ;;
        -h | --help) sed -n '2,12s/^# \{0,1\}//p' "$0"; exit 0 ;;
        *) fail "unknown argument '$1'; tools/package.sh --help lists them" ;;
    esac
    shift
done

# The newest version of glibc that a binary asks for.
glibc_of() { objdump -T "$1" | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -n 1; }

# The licenses of all that the crate in a folder is built from, into another folder.
licenses() {
    cargo about generate --locked --fail -m "$1/Cargo.toml" -c about.toml tools/about.hbs -o "$2/THIRD-PARTY-LICENSES.html"
}

# Contents of all packages besides the program: licenses, manual pages, completions. The program that runs here makes
# them.
make_stage() {
    rm -rf "$packages"
    mkdir -p "$stage/completions"
    licenses crates/cli "$stage"
    "$runs" man "$stage/man"
    local shell
    while read -r shell file; do "$runs" completions "$shell" >"$stage/completions/$file"; done <<'LIST'
bash pellucid.bash
zsh _pellucid
fish pellucid.fish
powershell _pellucid.ps1
elvish pellucid.elv
LIST
    cp README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$stage"
}

make_archive() {
    local name=pellucid-$version-$target
    local folder=$packages/$name
    mkdir "$folder"
    cp -r "$stage"/{README.md,CHANGELOG.md,LICENSE-MIT,LICENSE-APACHE,THIRD-PARTY-LICENSES.html,man,completions} "$binary" "$folder"
    if [[ $target == *windows* ]]; then
        (cd "$packages" && python3 -m zipfile -c "$name.zip" "$name")
    else
        tar -C "$packages" --owner=0 --group=0 --numeric-owner -cJf "$packages/$name.tar.xz" "$name" 2>/dev/null ||
            tar -C "$packages" -cJf "$packages/$name.tar.xz" "$name"
    fi
    rm -rf "$folder"
}

# Licenses and changes in the form that Debian wants.
make_deb() {
    {
        printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: pellucid\n\n'
        printf 'Files: *\nCopyright: 2026 the pellucid developers\nLicense: Expat or Apache-2.0\n\nLicense: Expat\n'
        sed -n '/^Permission/,$p' LICENSE-MIT | sed 's/^$/./; s/^/ /'
        printf '\nLicense: Apache-2.0\n On Debian systems the text is in /usr/share/common-licenses/Apache-2.0.\n'
        printf '\nComment:\n The program holds code of other crates. Their licenses are in THIRD-PARTY-LICENSES.html beside this file.\n'
    } >"$stage/copyright"
    printf 'pellucid (%s-1) stable; urgency=medium\n\n  * New release; changelog.gz lists its changes.\n\n -- The pellucid developers <pellucid@localhost>  %s\n' \
        "$version" "$(date -R)" >"$stage/changelog"
    gzip -9nc CHANGELOG.md >"$stage/changelog.gz"
    cp "$binary" "$stage/pellucid"
    cargo deb --locked --no-build -p pellucid-cli -o "$packages/"
}

make_wheel() {
    licenses crates/python python
    if [[ $target == *linux* ]]; then
        tools/python.sh --wheel
    else
        (cd python && maturin build --locked --out ../target/wheels)
    fi
    rm python/THIRD-PARTY-LICENSES.html
    cp target/wheels/*.whl "$packages"
}

# A bare Debian, as of `debootstrap --variant=minbase bookworm ROOT`: each package by its own installer, and a picture
# by each.
try_in() {
    [[ $(id -u) == 0 && -x $1/usr/bin/apt-get ]] || fail "--try wants root and a folder with a Debian in it, found neither apt nor root in '$1'"
    local within=(chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive SCAN="${scan##*/}" WHEEL=$wheel)
    mkdir -p "$1/packages"
    cp "$packages"/*.deb "$packages"/*.tar.xz "$scan" "$1/packages"
    if $wheel; then cp "$packages"/*.whl "$1/packages"; fi
    cp /etc/resolv.conf "$1/etc/resolv.conf"
    "${within[@]}" bash -euo pipefail -s <<'TRY'
cd /packages
mountpoint -q /proc || mount -t proc proc /proc
trap 'umount /proc' EXIT
# Not from standard input, which holds these lines.
apt-get() { command apt-get -o=Dpkg::Use-Pty=0 "$@" </dev/null; }
apt-get update -qq
apt-get install -y -qq ./*.deb xz-utils >install.log
pellucid --version
pellucid devices
pellucid scene garden -o garden
pellucid render garden/scene.toml --size 640x360 -o deb-garden.png
pellucid render "$SCAN" --see-through 0.5 --size 640x360 -o deb-scan.png
test -e /usr/share/man/man1/pellucid-render.1.gz && test -e /usr/share/bash-completion/completions/pellucid
apt-get remove -y -qq pellucid >remove.log
test ! -e /usr/bin/pellucid
tar -xJf pellucid-*.tar.xz
pellucid-*/pellucid render "$SCAN" --see-through 0.5 --size 640x360 -o archive-scan.png
cmp deb-scan.png archive-scan.png
ls -l ./*.png
if ! $WHEEL; then exit 0; fi
apt-get install -y -qq python3-venv >python.log
python3 -m venv venv
venv/bin/pip install -q ./*.whl
venv/bin/python -c "import os, pellucid; pellucid.render(os.environ['SCAN'], see_through=0.5, size=(640, 360), accuracy='8-bit').save('wheel-scan.png')"
ls -l wheel-scan.png
TRY
}

if [[ -n $root ]]; then
    try_in "$root"
    exit 0
fi
runs=$PWD/target/release/pellucid
if [[ -z $binary ]]; then
    say "cargo build --release"
    cargo build --locked --release -p pellucid-cli
    binary=$runs
    if [[ $target == *windows* ]]; then binary+=.exe; fi
fi
if [[ ! -x $runs ]]; then runs=$binary; fi
say "pellucid $version for $target"
make_stage
make_archive
if [[ $target == *linux* ]]; then say "the program needs $(glibc_of "$binary")"; fi
if $deb && [[ $target == *linux* ]]; then make_deb; fi
if $wheel; then make_wheel; fi
if $crates; then
    # Into this very folder.
    cargo package --locked --no-verify -p pellucid-fault -p pellucid-core -p pellucid-io -p pellucid-scene \
        -p pellucid-reference -p pellucid-gpu -p pellucid-window -p pellucid-engine -p pellucid-session -p pellucid-lab -p pellucid-viewer -p pellucid-cli -p pellucid
    # Sources of the packed files.
    rm -rf "$packages"/pellucid-*/ "$packages"/tmp-*
fi
rm -rf "$stage"
sum=(sha256sum)
command -v sha256sum >/dev/null || sum=(shasum -a 256)
(cd "$packages" && "${sum[@]}" pellucid* >"$packages.sums")
mv "$packages.sums" "$packages/SHA256SUMS"
cat "$packages/SHA256SUMS"
