"""The commands of docs/papers.md run in a small form and print the figures that the page takes from them."""

import re
import sys
from pathlib import Path

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools" / "papers"))

from catalog import Row, load
from papers import figures_of, run_commands

ROWS = load().rows


@pytest.mark.parametrize("row", [row for row in ROWS if row.in_small()], ids=lambda row: row.name)
def test_a_row_of_the_papers_runs(row: Row, binary: Path) -> None:
    found = figures_of(row, run_commands(row.in_small(), binary.resolve()))
    assert found.keys() == dict(row.find).keys()


def test_tools_have_small_forms_of_their_own() -> None:
    """tools/test.sh runs the tests of every example that the page runs at full size."""
    script = (ROOT / "tools" / "test.sh").read_text()
    tested = re.search(r"^for name in (.*); do units", script, re.MULTILINE)
    assert tested is not None
    commands = " ".join(command for row in ROWS for command in row.commands)
    examples = set(re.findall(r"--example (\S+)", commands))
    assert examples <= set(tested[1].split())
