#!/usr/bin/env python3
"""Runs the commands of docs/papers.toml at full size and writes docs/papers.md: tools/papers/papers.py [ROW…].

Figures of rows that are not named stay as they were measured last. `--page` writes the page alone. The program is
target/release/pellucid, or what PELLUCID names; rows of tools build them with cargo.
"""

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from catalog import DOCS, MEASURED, ROOT, CatalogError, Row, load, load_measured
from page import page


def find_program() -> Path:
    """The program whose commands are run."""
    program = Path(os.environ.get("PELLUCID", ROOT / "target" / "release" / "pellucid")).resolve()
    if not os.access(program, os.X_OK):
        raise CatalogError(f"{program} is missing (cargo build --release makes it, or PELLUCID names another)")
    return program


def execute(command: str, program: Path, folder: Path) -> str:
    """Runs a command and returns what it printed; its failure is ours. Tools run where they are built."""
    words = shlex.split(command)
    of_program = words[0] == "pellucid"
    if of_program:
        words[0] = str(program)
    done = subprocess.run(words, cwd=folder if of_program else ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CatalogError(f"{command}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def run_commands(commands: tuple[str, ...], program: Path) -> str:
    """Runs commands one after the other in an empty folder and returns what they printed."""
    with tempfile.TemporaryDirectory() as folder:
        return "\n".join(execute(command, program, Path(folder)) for command in commands)


def figures_of(row: Row, said: str) -> dict[str, str]:
    """A row's figures by their names, from what its commands printed. A pattern that finds nothing is an error."""
    found = {}
    for name, pattern in row.find:
        match = re.search(pattern, said, re.MULTILINE)
        if match is None:
            raise CatalogError(f"{row.name}: {name}: nothing printed is like {pattern}\n{said}")
        found[name] = match[1]
    return found


def select(rows: tuple[Row, ...], wanted: list[str]) -> list[Row]:
    """Rows that are run, by their names."""
    known = [row.name for row in rows if row.commands]
    for name in wanted:
        if name not in known:
            raise CatalogError(f"no row {name} has commands; there are: {' '.join(known)}")
    return [row for row in rows if row.commands and (not wanted or row.name in wanted)]


def replace(path: Path, text: str) -> None:
    """Writes a text whole or not at all."""
    draft = path.with_name(path.name + ".new")
    draft.write_text(text)
    draft.replace(path)


def run(wanted: list[str]) -> None:
    """Runs rows and keeps what each printed, so that a run that was ended goes on with the others."""
    catalog = load()
    program = find_program()
    # Rows with the same commands share one run.
    said: dict[tuple[str, ...], str] = {}
    for row in select(catalog.rows, wanted):
        print(f"== {row.name}", flush=True)
        if row.commands not in said:
            said[row.commands] = run_commands(row.commands, program)
        measured = {**load_measured(), row.name: figures_of(row, said[row.commands])}
        in_order = {r.name: measured[r.name] for r in catalog.rows if measured.get(r.name)}
        replace(MEASURED, json.dumps(in_order, indent=1, ensure_ascii=False) + "\n")


def main() -> int:
    """Reads the command line; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("row", nargs="*", help="names of rows of docs/papers.toml; by default all")
    parser.add_argument("--page", action="store_true", help="write docs/papers.md alone, and run nothing")
    arguments = parser.parse_args()
    if arguments.page and arguments.row:
        parser.error("either rows or --page must be given")
    try:
        if not arguments.page:
            run(arguments.row)
        replace(DOCS / "papers.md", page(load(), load_measured()))
    except (CatalogError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
