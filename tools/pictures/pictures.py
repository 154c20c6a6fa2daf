#!/usr/bin/env python3
"""Remakes the pictures of README and of docs/gallery.md, and that page: tools/pictures/pictures.py FOLDER [PICTURE…].

FOLDER holds the files that docs/gallery.toml lists. A picture of README is made by the first command of the block above it, so that
the two cannot differ; only the file's name, the size, the samples and the output are others. `--page` writes the page alone.

All files are compared by their SHA-256 before anything is rendered. A missing one is named, its pictures are left out, and the
script fails at its end.
"""

import argparse
import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from catalog import (
    DOCS,
    IMAGES,
    MAX_PICTURE,
    MEASURED,
    ROOT,
    SCENES,
    Catalog,
    CatalogError,
    Picture,
    load,
    load_measured,
)
from page import page

FONT = "DejaVu-Sans"
README_IMAGES = DOCS / "images" / "scans"
# Largest files of README's pictures, in bytes.
MAX_README = 200_000
MAX_GARDEN = 300_000
# Tools with the Debian package of each.
TOOLS = {"montage": "imagemagick", "mogrify": "imagemagick", "pngquant": "pngquant"}


def replace(path: Path, text: str) -> None:
    """Writes a text whole or not at all."""
    draft = path.with_name(path.name + ".new")
    draft.write_text(text)
    draft.replace(path)


def sha256(path: Path) -> str:
    """A file's SHA-256; a folder's is that of what `sha256sum *` prints in it."""
    if path.is_dir():
        lines = "".join(f"{sha256(f)}  {f.name}\n" for f in sorted(path.iterdir()))
        return hashlib.sha256(lines.encode()).hexdigest()
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def missing_files(catalog: Catalog, data: Path, paths: set[str]) -> set[str]:
    """The files that are missing. Another file than the catalog's is an error."""
    missing = set()
    for path in sorted(paths):
        if not (data / path).exists():
            missing.add(path)
        elif sha256(data / path) != catalog.sources[path].sha256:
            raise CatalogError(f"another file than docs/gallery.toml's, by its SHA-256: {data / path}")
    return missing


def find_program() -> Path:
    """The program that renders."""
    program = Path(os.environ.get("PELLUCID", ROOT / "target" / "release" / "pellucid")).resolve()
    if not os.access(program, os.X_OK):
        raise CatalogError(f"{program} is missing (cargo build --release makes it, or PELLUCID names another)")
    for tool, package in TOOLS.items():
        if shutil.which(tool) is None:
            raise CatalogError(f"{tool} is missing (Debian and Ubuntu: apt-get install {package})")
    fonts = subprocess.run(["montage", "-list", "font"], capture_output=True, text=True, check=False).stdout
    if f"Font: {FONT}\n" not in fonts:
        raise CatalogError(f"no font {FONT} (Debian and Ubuntu: apt-get install fonts-dejavu-core)")
    return program


def execute(program: Path, words: list[str], folder: Path) -> str:
    """Runs the program and returns its output; its failure is ours."""
    done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CatalogError(f"pellucid {shlex.join(words)}: status {done.returncode}\n{done.stderr}")
    return done.stderr + done.stdout


def shrink_to_webp(picture: Path, out: Path) -> None:
    """Stores a picture as WebP, at the best quality that stays below the limit."""
    draft = picture.with_suffix(".webp")
    for quality in range(92, 49, -6):
        subprocess.run(
            [
                "mogrify",
                "-strip",
                "-format",
                "webp",
                "-quality",
                str(quality),
                "-define",
                "webp:method=6",
                str(picture),
            ],
            check=True,
        )
        if draft.stat().st_size <= MAX_PICTURE:
            out.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(draft, out)
            print(f"{out.relative_to(ROOT)}: {out.stat().st_size} bytes, quality {quality}")
            return
    raise CatalogError(f"{out.name} would be larger than {MAX_PICTURE} bytes")


def shrink_to_palette(picture: Path, out: Path, most: int) -> None:
    """Stores a picture as PNG with a palette, of so many colors that it stays below a limit."""
    draft = picture.with_name("small.png")
    for colors in (256, 160, 96, 64, 40):
        subprocess.run(["pngquant", "--force", "--speed", "1", "--output", draft, str(colors), picture], check=True)
        if draft.stat().st_size <= most:
            shutil.copy(draft, out)
            print(f"{out.relative_to(ROOT)}: {out.stat().st_size} bytes, {colors} colors")
            return
    raise CatalogError(f"{out.name} would be larger than {most} bytes")


def assemble(picture: Picture, work: Path, errors: dict[str, str]) -> Path:
    """Joins the panels to a picture, each above its label."""
    parts = []
    for panel in picture.panels:
        parts += ["-label", panel.label.format(rmse=errors.get(panel.file, "")), panel.file]
    out = work / "assembled.png"
    rest = ["-background", "white", "-fill", "#202020", "-geometry", "+6+4", "-tile", f"{picture.columns}x"]
    subprocess.run(["montage", "-font", FONT, "-pointsize", "19", *parts, *rest, out], cwd=work, check=True)
    return out


def make(picture: Picture, catalog: Catalog, data: Path, program: Path) -> dict:
    """Renders a picture into docs/images/gallery. What it measured."""
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        for path in picture.files:
            link = work / catalog.sources[path].local
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to((data / path).resolve())
        for scene in picture.scenes:
            if (SCENES / scene).exists():
                shutil.copy(SCENES / scene, work)
        errors: dict[str, str] = {}
        measured: dict = {}
        start = time.monotonic()
        for command in picture.commands:
            print(f"== {picture.name}: {command}", flush=True)
            words = shlex.split(command)[1:]
            said = execute(program, [*words, "--verbose"], work)
            if found := re.search(r"^(\d+) (?:points|splats).* pixels$", said, re.MULTILINE):
                measured.setdefault("points", int(found[1]))
            if words[0] == "compare" and (found := re.search(r"^rmse +(\S+)", said, re.MULTILINE)):
                errors[words[2]] = f"{float(found[1]):.2g}"
        measured["seconds"] = round(time.monotonic() - start, 1)
        out = assemble(picture, work, errors) if picture.panels else work / f"{picture.name}.png"
        shrink_to_webp(out, IMAGES / f"{picture.name}.webp")
    return measured


def command_of(readme: str, name: str) -> list[str]:
    """The first command of the block above README's picture of a name."""
    before, found, _ = readme.partition(f"](docs/images/scans/{name}.png)")
    block = before.rpartition("```sh\n")[2].partition("```")[0]
    for line in block.splitlines():
        if found and line.startswith("pellucid render scan.laz"):
            return shlex.split(re.sub(r" (-o|--output) \S+", "", line), comments=True)[1:]
    raise CatalogError(f"README has no command above the picture docs/images/scans/{name}.png")


def make_readme(entry: dict, data: Path, program: Path) -> None:
    """Renders a picture of README."""
    words = command_of((ROOT / "README.md").read_text(), entry["name"])
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        (work / "scan.laz").symlink_to((data / entry["file"]).resolve())
        print(f"== README, {entry['name']}: pellucid {shlex.join(words)}", flush=True)
        execute(program, [*words, "--size", entry["size"], "--samples", "16", "--output", "picture.png"], work)
        shrink_to_palette(work / "picture.png", README_IMAGES / f"{entry['name']}.png", MAX_README)


def make_front(program: Path) -> None:
    """The built-in scene as README shows it, smaller than `render` and tools/demo.sh make it."""
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        print("== README: pellucid render", flush=True)
        execute(program, ["render", "--output", "garden.png"], work)
        subprocess.run(["mogrify", "-strip", "-resize", "840x630", work / "garden.png"], check=True)
        shrink_to_palette(work / "garden.png", ROOT / ".github" / "garden.png", MAX_GARDEN)


def select(catalog: Catalog, wanted: list[str]) -> tuple[list[Picture], bool]:
    """Pictures of the gallery by their names, and if those of README are wanted."""
    known = ["README", *(p.name for p in catalog.pictures)]
    for name in wanted:
        if name not in known:
            raise CatalogError(f"no picture {name}; there are: {' '.join(known)}")
    return [p for p in catalog.pictures if not wanted or p.name in wanted], not wanted or "README" in wanted


def run(data: Path, wanted: list[str]) -> int:
    """Makes pictures and the page; the exit status."""
    catalog = load()
    pictures, front = select(catalog, wanted)
    readme = catalog.readme if front else ()
    program = find_program()
    if not data.is_dir():
        raise CatalogError(f"no folder of data: {data}")
    used = {path for p in pictures for path in p.files} | {e["file"] for e in readme}
    missing = missing_files(catalog, data, used)
    for path in sorted(missing):
        print(f"error: missing: {data / path}", file=sys.stderr)
    if front:
        make_front(program)
    for entry in readme:
        if entry["file"] not in missing:
            make_readme(entry, data, program)
    measured = load_measured()
    for picture in pictures:
        if missing.isdisjoint(picture.files):
            measured[picture.name] = make(picture, catalog, data, program)
            in_order = {p.name: measured[p.name] for p in catalog.pictures if p.name in measured}
            replace(MEASURED, json.dumps(in_order, indent=1) + "\n")
    write_page(catalog)
    return 1 if missing else 0


def write_page(catalog: Catalog) -> None:
    """Writes docs/gallery.md."""
    replace(DOCS / "gallery.md", page(catalog, load_measured()))


def main() -> int:
    """Reads the command line; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, help="the folder of the files that docs/gallery.toml lists")
    parser.add_argument("picture", nargs="*", help="names of pictures of the gallery, or README for those of that; by default all")
    parser.add_argument("--page", action="store_true", help="write docs/gallery.md alone, and render nothing")
    arguments = parser.parse_args()
    if arguments.page == (arguments.folder is not None):
        parser.error("either FOLDER or --page must be given")
    try:
        if arguments.page:
            write_page(load())
            return 0
        return run(arguments.folder, arguments.picture)
    except (CatalogError, OSError, subprocess.CalledProcessError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
