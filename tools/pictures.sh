#!/usr/bin/env bash
# Remakes the pictures of README and docs/gallery.md: tools/pictures.sh [FOLDER [PICTURE…]]. FOLDER holds the scans that the table
# in docs/gallery.md lists, by default ../shared/data; a picture is `garden`, `contact` or one of those below, by default all.
#
# A picture of README is made by the first command of the block above it, so that the two cannot differ: only the file's name, the
# size and the output are others. A scan that is missing is named and left out, and the script fails at its end. One that is not
# the table's by its SHA-256 is an error before anything is rendered.
set -euo pipefail
cd "$(dirname "$0")/.."

# Name, scan and size of README's pictures, which are in $folder as NAME.png.
pictures=(
    "first lidar/ahn3_delft_classified.laz 800x500"
    "forest lidar/lone_star_geyser_tls.copc.laz 800x450"
    "building lidar/ign_lidarhd_77050_627755_classified.laz 800x520"
    "classes lidar/ahn3_delft_classified.laz 800x600"
    "heritage photogrammetry/lion_takanawa.copc.laz 640x480"
    "model photogrammetry/lion_takanawa.copc.laz 640x480"
)
folder=docs/images/scans
# What the contact sheet renders each scan with.
sheet=(--see-through 0.5 --size 480x360)
# Largest files, in bytes.
max_picture=200000 max_garden=300000 max_sheet=700000

fail() { echo "error: $*" >&2; exit 1; }

case ${1:-} in
    -h | --help) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0"; exit 0 ;;
    -*) echo "error: unknown argument '$1'; usage: tools/pictures.sh [FOLDER [PICTURE…]]" >&2; exit 2 ;;
esac
data=${1:-../shared/data}
wanted=("${@:2}")
known=" garden contact "
for entry in "${pictures[@]}"; do known+="${entry%% *} "; done
for name in ${wanted[@]+"${wanted[@]}"}; do
    if [[ $known != *" $name "* ]]; then echo "error: no picture $name; there are:$known" >&2; exit 2; fi
done
is_wanted() { [[ ${#wanted[@]} = 0 || " ${wanted[*]} " == *" $1 "* ]]; }

pellucid=$(realpath -m "${PELLUCID:-target/release/pellucid}")
[[ -x $pellucid ]] || fail "$pellucid is missing (cargo build --release makes it, or PELLUCID names another)"
[[ -d $data ]] || fail "no folder of scans: $data"
data=$(realpath "$data")

# Tools with the Debian package of each.
for tool in montage:imagemagick mogrify:imagemagick pngquant:pngquant sha256sum:coreutils; do
    command -v "${tool%:*}" >/dev/null || fail "${tool%:*} is missing (Debian and Ubuntu: apt-get install ${tool#*:})"
done
font=DejaVu-Sans
# All of it is read: a pipe that closes early would fail.
[[ $(montage -list font) == *"Font: $font"$'\n'* ]] || fail "no font $font (Debian and Ubuntu: apt-get install fonts-dejavu-core)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The scans of the table, in its order, each with its SHA-256.
# shellcheck disable=SC2016 # The backticks are those of the table.
mapfile -t scans < <(sed -nE 's/^\| `([^`]+)` \|.* `([0-9a-f]{64})` \|$/\1 \2/p' docs/gallery.md)
[[ ${#scans[@]} -gt 0 ]] || fail "docs/gallery.md lists no scans"

failed=0
complain() { echo "error: $*" >&2; failed=1; }

# Which of them are used: all by the contact sheet, else those of the pictures.
used=" "
for entry in "${pictures[@]}"; do
    read -r name scan _ <<<"$entry"
    if is_wanted "$name"; then used+="$scan "; fi
    [[ " ${scans[*]} " == *" $scan "* ]] || fail "$scan, of the picture $name, is not in the table of docs/gallery.md"
done
for entry in "${scans[@]}"; do
    read -r scan sum <<<"$entry"
    is_wanted contact || [[ $used == *" $scan "* ]] || continue
    if [[ ! -f $data/$scan ]]; then
        complain "missing: $data/$scan"
    elif [[ $(sha256sum <"$data/$scan") != "$sum "* ]]; then
        fail "another file than the table's, by its SHA-256: $data/$scan"
    fi
done

# The first command of the block above README's picture of a name.
command_of() {
    awk -v picture="]($folder/$1.png)" '
        /^```sh$/ { first = ""; next }
        /^pellucid render scan\.laz/ && first == "" { sub(/ +# .*/, ""); first = $0 }
        index($0, picture) { print first; exit }
    ' README.md
}

# Writes a picture with a palette, of so many colors that it stays below a size in bytes.
shrink() {
    local from=$1 to=$2 most=$3 colors
    for colors in 256 160 96 64 40; do
        pngquant --force --speed 1 --output "$work/small.png" "$colors" "$from"
        if (($(stat -c %s "$work/small.png") <= most)); then
            mkdir -p "$(dirname "$to")"
            mv "$work/small.png" "$to"
            echo "$to: $(stat -c %s "$to") bytes, $colors colors"
            return
        fi
    done
    complain "$to would be larger than $most bytes"
}

if is_wanted garden; then
    echo "== garden: pellucid render"
    "$pellucid" render -o "$work/garden.png"
    # Smaller than `render` and tools/demo.sh make it.
    mogrify -strip -resize 840x630 "$work/garden.png"
    shrink "$work/garden.png" .github/garden.png "$max_garden"
fi

for entry in "${pictures[@]}"; do
    read -r name scan size <<<"$entry"
    if ! is_wanted "$name" || [[ ! -f $data/$scan ]]; then continue; fi
    command=$(command_of "$name")
    [[ -n $command ]] || fail "README has no command above the picture $folder/$name.png"
    echo "== $name: $command"
    # Without the output that the command may name.
    read -ra words <<<"$(sed -E 's/ (-o|--output) [^ ]+//' <<<"$command")"
    ln -sf "$data/$scan" "$work/scan.laz"
    (cd "$work" && "$pellucid" "${words[@]:1}" --size "$size" --output picture.png)
    shrink "$work/picture.png" "$folder/$name.png" "$max_picture"
done

if is_wanted contact; then
    tiles=()
    for entry in "${scans[@]}"; do
        read -r scan _ <<<"$entry"
        [[ -f $data/$scan ]] || continue
        file=$(basename "$scan")
        echo "== contact: pellucid render $scan ${sheet[*]}"
        ln -sf "$data/$scan" "$work/$file"
        if ! (cd "$work" && "$pellucid" render "$file" "${sheet[@]}" --verbose --output "$file.png") 2>"$work/log"; then
            cat "$work/log" >&2
            complain "$scan was not rendered"
            continue
        fi
        opacity=$(awk '/^see-through .*: opacity / { printf "%.3g", $4 }' "$work/log")
        method=$(awk '/^method / { sub(/:$/, "", $2); print $2; exit }' "$work/log")
        tiles+=(-label "$file"$'\n'"α = $opacity, $method" "$work/$file.png")
    done
    montage -font "$font" -pointsize 15 -background '#303030' -fill white -geometry 480x360+5+5 -tile 3x "${tiles[@]}" \
        "$work/contact.png"
    shrink "$work/contact.png" "$folder/contact.png" "$max_sheet"
fi
exit "$failed"
