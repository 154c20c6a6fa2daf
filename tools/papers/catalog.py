"""docs/papers.toml as records: the papers, and a row for each figure, table or equation that can be run."""

import json
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
# What the last run of each row printed.
MEASURED = Path(__file__).parent / "measured.json"
# A row's verdict, and how the page says it.
VERDICTS = {
    "yes": "agrees",
    "partly": "agrees in part",
    "no": "does not agree",
    "own": "own data",
    "none": "not done",
}


class CatalogError(Exception):
    """Something in the catalog that a person must repair."""


@dataclass(frozen=True)
class Row:
    """A figure, table or equation. Its commands are both what is run and what the page shows."""

    name: str
    paper: str
    item: str
    theirs: str
    ours: str
    verdict: str
    commands: tuple[str, ...] = ()
    # Pairs of texts: what the commands have, and what they have in the test.
    small: tuple[tuple[str, str], ...] = ()
    # Patterns with one group, whose text `ours` shows by their names.
    find: tuple[tuple[str, str], ...] = ()

    def in_small(self) -> tuple[str, ...]:
        """The commands as the test runs them, without tools that have tests of their own."""
        commands = list(self.commands)
        for old, new in self.small:
            commands = [command.replace(old, new) for command in commands]
        return tuple(command for command in commands if command.startswith("pellucid "))


@dataclass(frozen=True)
class Catalog:
    """All of docs/papers.toml."""

    head: str
    # Title and closing text of each paper, by its name.
    papers: dict[str, tuple[str, str]]
    rows: tuple[Row, ...]


def parse(text: str) -> Catalog:
    """The catalog of a TOML text; names that nothing defines are errors."""
    try:
        table = tomllib.loads(text)
        papers = {p["name"]: (p["title"], p["deviations"]) for p in table["paper"]}
        rows = tuple(
            Row(
                **{
                    **r,
                    "commands": tuple(r.get("commands", ())),
                    "small": tuple((old, new) for old, new in r.get("small", ())),
                    "find": tuple(r.get("find", {}).items()),
                }
            )
            for r in table["row"]
        )
        catalog = Catalog(table["head"], papers, rows)
    except (tomllib.TOMLDecodeError, KeyError, TypeError, ValueError) as error:
        raise CatalogError(f"docs/papers.toml: {error}") from error
    check(catalog)
    return catalog


def check(catalog: Catalog) -> None:
    """Refuses what would leave the page with a hole."""
    names = [row.name for row in catalog.rows]
    for row in catalog.rows:
        where = f"docs/papers.toml: {row.name}"
        if names.count(row.name) > 1:
            raise CatalogError(f"{where}: two rows have this name")
        if row.paper not in catalog.papers:
            raise CatalogError(f"{where}: no paper is named {row.paper}")
        if row.verdict not in VERDICTS:
            raise CatalogError(f"{where}: the verdict is one of {', '.join(VERDICTS)}, not {row.verdict}")
        if (row.verdict == "none") != (not row.commands):
            raise CatalogError(f"{where}: a row has commands, or the verdict none")
        for command in row.commands:
            if not command.startswith(("pellucid ", "cargo run --release -p pellucid-lab --example ")):
                raise CatalogError(f"{where}: neither a command of pellucid nor one of its tools: {command}")
        for old, _ in row.small:
            if not any(old in command for command in row.commands):
                raise CatalogError(f"{where}: no command has {old}")


def load() -> Catalog:
    """The catalog of this repository."""
    return parse((DOCS / "papers.toml").read_text())


def load_measured() -> dict[str, dict[str, str]]:
    """What was printed, by row and name; empty before the first run."""
    return json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
