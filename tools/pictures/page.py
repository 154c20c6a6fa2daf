"""The text of docs/gallery.md, from the catalog and what was measured."""

import re
import textwrap

from catalog import SCENES, Catalog, Picture, Source

HEAD = """# Gallery

<!-- Generated: edit docs/gallery.toml, then run tools/pictures/pictures.py --page. -->

Scans, Gaussian splats and built-in scenes, each with the command that made the picture. Download the file, or take one of your own,
and run the command; the [table of sources](#sources) says where files are. Pictures here are stored as WebP to stay small; `render`
writes PNG and EXR.

Each time is that of all the commands shown, from reading the file to writing the picture, on 2 cores without a GPU (Mesa's lavapipe).
The machine was shared: read times as orders of magnitude.
"""

REMAKE = """## Making these pictures again

One script makes all pictures of this page and of the README, from a folder that holds the files by the names in the table below. It
first compares their SHA-256. A file that is missing is named, its pictures are left out, and the script fails at its end.

```sh
tools/pictures/pictures.py FOLDER                # all pictures, and this page
tools/pictures/pictures.py FOLDER town playbot   # some of them; README means those of the README
tools/pictures/pictures.py --page                # this page alone
```

It takes `target/release/pellucid`, or what `PELLUCID` names, and needs Python 3.11 and, by Debian's names, `imagemagick`, `pngquant`
and `fonts-dejavu-core`. [gallery.toml](gallery.toml) holds titles, commands and sources.

## Sources

Copyright is with the authors named here. Where a file carries no note of its own, the license is that of the repository. The
SHA-256 of a folder is that of what `sha256sum *` prints in it.

| file | what was done to it | source | license | SHA-256 |
|---|---|---|---|---|
"""


def slug(title: str) -> str:
    """The anchor that Git hosts and mdBook make of a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def about(seconds: float) -> str:
    """A time as an order of magnitude."""
    if seconds < 10:
        return f"{max(1, round(seconds))} s"
    if seconds < 100:
        return f"{5 * round(seconds / 5)} s"
    return f"{max(2, round(seconds / 60))} min"


def facts(picture: Picture, sources: dict[str, Source], measured: dict) -> str:
    """The line below a picture: points, time and whose data."""
    parts = []
    if points := measured.get("points"):
        parts.append(f"{points:,} points")
    if "seconds" in measured:
        parts.append(f"about {about(measured['seconds'])}")
    credits = [sources[path].credit for path in picture.files]
    parts.append("data: " + "; ".join(dict.fromkeys(credits)) if credits else "built-in scene, no data needed")
    scenes = [s for s in picture.scenes if (SCENES / s).exists()]
    parts += [f"scene file: [{s}](scenes/{s})" for s in scenes]
    folders = [sources[path] for path in picture.files if sources[path].name]
    parts += [f"the file's folder stands as `{f.name}`" for f in folders]
    return " · ".join(parts)


def wrap(command: str) -> str:
    """A command of at most 100 columns, continued as a shell has it."""
    # An option and its value stay together.
    glued = re.sub(r"( --?[^ ]+) (?!-)", "\\1\0", command)
    lines = textwrap.wrap(glued, 96, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return " \\\n".join(lines).replace("\0", " ")


def entry(picture: Picture, sources: dict[str, Source], measured: dict) -> str:
    """A picture's section."""
    commands = "\n".join(map(wrap, picture.commands))
    return (
        f"### {picture.title}\n\n"
        f"![{picture.alt}](images/gallery/{picture.name}.webp)\n\n"
        f"{picture.text}\n\n"
        f"```sh\n{commands}\n```\n\n"
        f"*{facts(picture, sources, measured)}*\n"
    )


def index(catalog: Catalog) -> str:
    """Links to all pictures, by theme."""
    lines = []
    for name, title in catalog.themes.items():
        links = [f"[{p.title}](#{slug(p.title)})" for p in catalog.pictures if p.theme == name]
        lines.append(f"- **{title}:** {' · '.join(links)}")
    return "\n".join(lines) + "\n"


def table(catalog: Catalog) -> str:
    """The files, one a line."""
    return "".join(f"| `{s.path}` | {s.done} | {s.source} | {s.license} | `{s.sha256}` |\n" for s in catalog.sources.values())


def page(catalog: Catalog, measured: dict) -> str:
    """All of docs/gallery.md."""
    sections = []
    for name, title in catalog.themes.items():
        entries = [entry(p, catalog.sources, measured.get(p.name, {})) for p in catalog.pictures if p.theme == name]
        sections.append(f"## {title}\n\n" + "\n".join(entries))
    return HEAD + "\n" + index(catalog) + "\n" + "\n".join(sections) + "\n" + REMAKE + table(catalog)
