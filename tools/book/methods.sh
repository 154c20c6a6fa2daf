#!/usr/bin/env bash
# Remakes docs/images/methods: one scan of the built-in garden by every method, at one size, a small WebP file for each.
# PELLUCID names the program, by default target/release/pellucid. Needs imagemagick.
set -euo pipefail
cd "$(dirname "$0")/../.."
pellucid=$(realpath "${PELLUCID:-target/release/pellucid}")
methods=(points squares circles paraboloid cone sphere hqs splats image-space peel-layers abuffer linked-list sorted peel
    stochastic hybrid mlab moments wavelet weighted average unsorted soft-base soft-concentric soft-express one-layer spbr
    spbr-simplified)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p docs/images/methods
"$pellucid" scene garden --set points=200000 -o "$work/scene" --quiet
for method in "${methods[@]}"; do
    # At their defaults hardly a point would be soft here, and parts of so many ensembles too thin to be seen.
    case $method in
        soft-* | one-layer) keys=(--set method.threshold=0.1) ;;
        spbr-simplified) keys=(--set method.ensembles=4) ;;
        *) keys=() ;;
    esac
    "$pellucid" render "$work/scene/scene.toml" --method "$method" ${keys[@]+"${keys[@]}"} --size 200x150 --quiet -o "$work/$method.png"
    # At most 6 KiB each: the page has all of them.
    for quality in 50 35 20; do
        convert "$work/$method.png" -strip -quality "$quality" -define webp:method=6 "docs/images/methods/$method.webp"
        if (($(wc -c <"docs/images/methods/$method.webp") <= 6144)); then break; fi
    done
done
