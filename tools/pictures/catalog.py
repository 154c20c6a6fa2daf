"""docs/gallery.toml as records: files with their SHA-256, themes, pictures, and the pictures of README."""

import json
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
IMAGES = DOCS / "images" / "gallery"
SCENES = DOCS / "scenes"
# Measurements of the last run of each picture.
MEASURED = IMAGES / "measured.json"
# Largest files, in bytes.
MAX_PICTURE = 160_000
MAX_ALL = 4_000_000


class CatalogError(Exception):
    """Something in the catalog or the data that a person must repair."""


@dataclass(frozen=True)
class Source:
    """A file of the data folder, or a folder there that stands for one cloud."""

    path: str
    sha256: str
    done: str
    source: str
    license: str
    credit: str
    # The path by which commands name it.
    name: str = ""

    @property
    def local(self) -> str:
        """The path by which commands name it."""
        return self.name or Path(self.path).name


@dataclass(frozen=True)
class Panel:
    """A part of a picture that is put together of several."""

    file: str
    label: str


@dataclass(frozen=True)
class Picture:
    """An entry of the gallery. Its commands are both what is run and what the page shows."""

    name: str
    theme: str
    title: str
    text: str
    alt: str
    commands: tuple[str, ...]
    files: tuple[str, ...] = ()
    panels: tuple[Panel, ...] = ()
    columns: int = 2

    @property
    def scenes(self) -> list[str]:
        """Scene files of docs/scenes that the commands name."""
        words = " ".join(self.commands).split()
        return [w for w in words if w.endswith(".toml") and "/" not in w]


@dataclass(frozen=True)
class Catalog:
    """All of docs/gallery.toml."""

    sources: dict[str, Source]
    themes: dict[str, str]
    pictures: tuple[Picture, ...]
    readme: tuple[dict, ...] = field(default=())


def parse(text: str) -> Catalog:
    """The catalog of a TOML text; names that nothing defines are errors."""
    try:
        table = tomllib.loads(text)
        sources = {f["path"]: Source(**f) for f in table["file"]}
        themes = {t["name"]: t["title"] for t in table["theme"]}
        pictures = tuple(
            Picture(
                **{
                    **p,
                    "commands": tuple(p["commands"]),
                    "files": tuple(p.get("files", ())),
                    "panels": tuple(Panel(**panel) for panel in p.get("panels", ())),
                }
            )
            for p in table["picture"]
        )
    except (tomllib.TOMLDecodeError, KeyError, TypeError) as error:
        raise CatalogError(f"docs/gallery.toml: {error}") from error
    catalog = Catalog(sources, themes, pictures, tuple(table.get("readme", ())))
    check(catalog)
    return catalog


def check(catalog: Catalog) -> None:
    """Refuses what would leave the page with a hole."""
    names = [p.name for p in catalog.pictures]
    for name in names:
        if names.count(name) > 1:
            raise CatalogError(f"docs/gallery.toml: two pictures are named {name}")
    for picture in catalog.pictures:
        if picture.theme not in catalog.themes:
            raise CatalogError(f"docs/gallery.toml: {picture.name}: no theme is named {picture.theme}")
        for path in picture.files:
            if path not in catalog.sources:
                raise CatalogError(f"docs/gallery.toml: {picture.name}: no file is named {path}")
        for command in picture.commands:
            if not command.startswith("pellucid "):
                raise CatalogError(f"docs/gallery.toml: {picture.name}: not a command of pellucid: {command}")
    for entry in catalog.readme:
        if entry["file"] not in catalog.sources:
            raise CatalogError(f"docs/gallery.toml: {entry['name']}: no file is named {entry['file']}")


def load() -> Catalog:
    """The catalog of this repository."""
    return parse((DOCS / "gallery.toml").read_text())


def load_measured() -> dict:
    """The measurements by picture; empty before the first run."""
    return json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
