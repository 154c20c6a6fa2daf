#!/usr/bin/env bash
# Remakes docs/images/methods.jpg: one scan of the built-in garden by every method, at one size, each with its name.
# PELLUCID names the program, by default target/release/pellucid. Needs imagemagick and fonts-dejavu-core (Debian's names).
set -euo pipefail
cd "$(dirname "$0")/../.."
pellucid=$(realpath "${PELLUCID:-target/release/pellucid}")
methods=(points squares circles paraboloid cone sphere hqs splats image-space peel-layers abuffer linked-list sorted peel
    stochastic hybrid mlab moments wavelet weighted average unsorted soft-base soft-concentric soft-express one-layer spbr
    spbr-simplified)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$pellucid" scene garden --set points=200000 -o "$work/scene" --quiet
for method in "${methods[@]}"; do
    # At their defaults hardly a point would be soft here, and parts of so many ensembles too thin to be seen.
    case $method in
        soft-* | one-layer) keys=(--set method.threshold=0.1) ;;
        spbr-simplified) keys=(--set method.ensembles=4) ;;
        *) keys=() ;;
    esac
    "$pellucid" render "$work/scene/scene.toml" --method "$method" ${keys[@]+"${keys[@]}"} --size 200x150 --quiet -o "$work/$method.png"
done
pictures=("${methods[@]/%/.png}")
montage -font DejaVu-Sans -pointsize 15 -label '%t' "${pictures[@]/#/$work/}" -tile 4x -geometry +4+4 -sampling-factor 2x2 -quality 72 docs/images/methods.jpg
