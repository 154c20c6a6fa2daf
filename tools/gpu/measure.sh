#!/usr/bin/env bash
# Measures a machine with a GPU, in a bounded time. It needs bash, coreutils and the GPU's driver; what
# tools/gpu/prepare.sh packed must be in .gpu (docs/internals/measuring.md, "Measuring on a GPU").
#
#   OUT=DIR tools/gpu/measure.sh SECONDS      # results to DIR, at most 8 files; SECONDS from 60 to 420
#   tools/gpu/measure.sh --quick [FOLDER]     # a look at every step, with the programs of FOLDER, or those of .gpu
#
# Steps come in order of value. Each is a process with a time of its own, whose lines are written at once: one that
# fails or takes too long ends alone. DIR/measured.jsonl has a line of JSON for each thing that was measured, and one of
# kind "step" for each step. The exit status is 1 if a step failed, and with --quick also if a line is missing.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 2

usage="usage: OUT=DIR tools/gpu/measure.sh SECONDS | tools/gpu/measure.sh --quick [FOLDER]"
fail() { echo "error: $*" >&2; exit 2; }

quick=false seconds=0 programs=""
case ${1:-} in
    --quick) quick=true; seconds=90; programs=${2:-} ;;
    "" | *[!0-9]*) fail "$usage" ;;
    *) seconds=$1 ;;
esac
((seconds >= 60 && seconds <= 420)) || fail "SECONDS must be from 60 to 420; $usage"
# Lines that --quick has to find; tests of gpu-table compare the first with its own list.
quick_rows=13
quick_cases=2
quick_pictures=3

is_kept=true
if [[ -z ${OUT:-} ]]; then
    $quick || fail "OUT names no folder; $usage"
    OUT=$(mktemp -d) is_kept=false
fi
mkdir -p "$OUT" || fail "$OUT can't be made"
OUT=$(realpath "$OUT")
results=$OUT/measured.jsonl log=$OUT/log.txt
: >"$results"
: >"$log"
work=$(mktemp -d) || fail "no folder for work"
sampler=""
# Whatever ends this script ends what it started.
clean() {
    if [[ -n $sampler ]]; then kill "$sampler" 2>/dev/null; fi
    rm -rf "$work"
    if ! $is_kept; then rm -rf "$OUT"; fi
}
trap clean EXIT

json_text() { local text=${1//\\/\\\\}; text=${text//\"/\\\"}; printf '"%s"' "${text//[$'\n\r\t']/ }"; }

# Unpacks what was prepared, unless a folder of programs is given.
commit=unknown pictures=""
unpack() {
    if [[ -n $programs ]]; then
        programs=$(realpath "$programs")
        commit=$(git describe --always --dirty --abbrev=8 --exclude '*' 2>/dev/null || echo unknown)
        return
    fi
    [[ -s .gpu/bin/gpu-table.gz ]] || fail ".gpu is not here; run tools/gpu/prepare.sh first"
    mkdir "$work/bin"
    local file
    for file in .gpu/bin/*.gz; do
        gzip -dc "$file" >"$work/bin/$(basename "${file%.gz}")" || fail "$file can't be unpacked"
    done
    chmod +x "$work"/bin/*
    programs=$work/bin
    commit=$(cat .gpu/commit)
    tar -C "$work" -xf .gpu/pictures.tar && pictures=$work/pictures
    # The system's own loader knows where its drivers are; this one looks in the usual places.
    if ! PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1'; then
        gzip -dc .gpu/loader/libvulkan.so.1.gz >"$work/libvulkan.so.1"
        export LD_LIBRARY_PATH=$work${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
    fi
}

program() {
    if [[ -x $programs/$1 ]]; then echo "$programs/$1"; else echo "$programs/examples/$1"; fi
}

# step NAME SECONDS LEAST KIND COMMAND…: runs a command for at most so many seconds, and no longer than all may take.
# Its output are lines of results, of which --quick wants at least so many of a kind.
failed=()
step() {
    local name=$1 most=$2 least=$3 kind=$4
    shift 4
    local left=$((seconds - SECONDS)) begin=$SECONDS status=0 before after found
    if ((left < 5)); then
        failed+=("$name: no time was left")
        printf '{"kind":"step","name":"%s","left_out":"the time was over"}\n' "$name" >>"$results"
        return
    fi
    if ((most > left)); then most=$left; fi
    echo "== $name" >>"$log"
    before=$(wc -l <"$results")
    timeout --kill-after=5 "$most" "$@" >>"$results" 2>>"$log" </dev/null || status=$?
    # A process that is killed may leave half a line.
    if [[ -n $(tail -c 1 "$results") ]]; then
        sed -i '$d' "$results"
    fi
    after=$(wc -l <"$results")
    found=$(tail -n +$((before + 1)) "$results" | grep -c "\"kind\":\"$kind\"")
    printf '{"kind":"step","name":"%s","status":%d,"seconds":%d,"lines":%d}\n' \
        "$name" "$status" $((SECONDS - begin)) $((after - before)) >>"$results"
    if ((status == 124)); then
        failed+=("$name: took longer than $most s")
    elif ((status != 0)); then
        failed+=("$name: status $status: $(tail -n 1 "$log")")
    elif $quick && ((found < least)); then
        failed+=("$name: $found lines of $kind instead of $least")
    fi
    echo "$name: $((after - before)) lines in $((SECONDS - begin)) s, status $status"
}

# What a system says of itself, without a program of ours.
machine() {
    local glibc card=unknown driver=unknown
    glibc=$(getconf GNU_LIBC_VERSION 2>/dev/null || echo unknown)
    if command -v nvidia-smi >/dev/null; then
        timeout 20 nvidia-smi -q -x >"$OUT/nvidia-smi.xml" 2>>"$log" || true
        IFS=, read -r card driver < <(
            timeout 20 nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>>"$log" | head -n 1
        )
        # Clocks beside everything that follows; nothing is ever set.
        local query=timestamp,clocks.sm,clocks.mem,power.draw,temperature.gpu,utilization.gpu,pstate
        nvidia-smi --query-gpu=$query --format=csv -lms 100 >"$OUT/clocks.csv" 2>>"$log" </dev/null &
        sampler=$!
    fi
    {
        printf '{"kind":"machine","schema":1,"date":"%s","quick":%s,"cores":%d' "$(date -u +%FT%TZ)" $quick "$(nproc)"
        printf ',"commit":%s,"glibc":%s' "$(json_text "$commit")" "$(json_text "$glibc")"
        printf ',"system":%s' "$(json_text "$(uname -srm)")"
        printf ',"card":%s,"card_driver":%s}\n' "$(json_text "${card## }")" "$(json_text "${driver## }")"
    } >>"$results"
}

unpack
table=$(program gpu-table)
[[ -x $table ]] || fail "$table is missing"
# Pipelines are kept from step to step.
export PELLUCID_CACHE_DIR=${PELLUCID_CACHE_DIR:-$work/cache}
machine

if $quick; then
    step device 20 1 device "$table" device
    step ceilings 30 6 ceiling "$table" ceilings --quick
    step check 30 "$quick_cases" case "$table" check abuffer/coincident abuffer/equal-depths
    # Its own pictures, which must be equal.
    step record 30 1 recorded "$table" record "$work/pictures" --only peel
    step pictures 30 1 pictures "$table" pictures "$work/pictures"
    step rows 60 "$quick_rows" row "$table" rows --quick
    step rates 30 4 rate "$table" rates --quick
    step pipelines 30 1 pipelines "$table" pipelines --quick
    equal=$(grep -o '"compared":[0-9]*,"equal":[0-9]*' "$results" | tr -dc '0-9,' || true)
    if [[ ${equal%,*} != "${equal#*,}" ]] || ((${equal%,*} < quick_pictures)); then
        failed+=("pictures: compared and equal: ${equal:-none}, of at least $quick_pictures")
    fi
else
    step device 20 1 device "$table" device
    step ceilings 40 1 ceiling "$table" ceilings --seconds 30
    step check 100 1 case "$table" check
    step pictures 70 1 pictures "$table" pictures "$pictures" --keep "$work/differing"
    step rows 150 1 row "$table" rows --seconds 130
    step rates 70 1 rate "$table" rates --seconds 55
    step pipelines 60 1 pipeline "$table" pipelines
    # Pictures that differ, as far as they fit.
    if compgen -G "$work/differing/*" >/dev/null; then
        tar -C "$work" -cf "$work/differing.tar" differing
        if (($(wc -c <"$work/differing.tar") < 15 << 20)); then mv "$work/differing.tar" "$OUT"; fi
    fi
    # The last measurement of this card, where Python can compare.
    if command -v python3 >/dev/null; then
        timeout 20 python3 tools/gpu/compare.py "$results" 2>&1 | tee "$OUT/compared.txt" | tail -n 60
    fi
fi

if ((${#failed[@]} > 0)); then
    printf 'failed: %s\n' "${failed[@]}" | tee -a "$log" >&2
    exit 1
fi
