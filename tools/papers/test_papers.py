"""docs/papers.md is what its data say, without running anything: `python3 -m unittest discover tools/papers`."""

import sys
import unittest
from pathlib import Path

from catalog import DOCS, CatalogError, load, load_measured, parse
from page import page
from papers import figures_of, run_commands, select

HEAD = "head = 'Head'\n[[paper]]\nname = 'p'\ntitle = 'Paper'\ndeviations = 'Text.'\n"
ROW = "[[row]]\nname = 'r'\npaper = 'p'\nitem = 'Fig. 1'\ntheirs = 'falls'\nours = '{x} falls'\nverdict = 'yes'\n"
RUN = "commands = ['pellucid scene a --set points=9']\nsmall = [['=9', '=1']]\nfind = { x = 'x (.*)' }\n"


class Page(unittest.TestCase):
    """The files of this repository."""

    def test_page_is_what_the_data_say(self):
        self.assertEqual((DOCS / "papers.md").read_text(), page(load(), load_measured()))


class Parts(unittest.TestCase):
    """Known answers."""

    def test_mistakes_are_named(self):
        good = HEAD + ROW + RUN
        self.assertEqual(parse(good).rows[0].in_small(), ("pellucid scene a --set points=1",))
        for old, new, message in [
            ("paper = 'p'", "paper = 'q'", "no paper is named q"),
            ("'yes'", "'perhaps'", "the verdict is one of"),
            ("pellucid scene", "rm -rf", "neither a command"),
            ("'=9', '=1'", "'=8', '=1'", "no command has =8"),
            ("commands = ['pellucid scene a --set points=9']\nsmall = [['=9', '=1']]", "", "has commands, or"),
            ("theirs = 'falls'", "", "theirs"),
            ("[[row]]", "[[row", "papers.toml"),
        ]:
            with self.assertRaisesRegex(CatalogError, message):
                parse(good.replace(old, new))
        with self.assertRaisesRegex(CatalogError, "two rows"):
            parse(good + ROW + RUN)

    def test_page_shows_figures_verdict_and_command(self):
        catalog = parse(HEAD + ROW + RUN)
        text = page(catalog, {"r": {"x": "0.5"}})
        self.assertIn("| Fig. 1 | falls | 0.5 falls | agrees |", text)
        self.assertIn("```sh\n# Fig. 1\npellucid scene a --set points=9\n```", text)
        with self.assertRaisesRegex(CatalogError, "was not run: x"):
            page(catalog, {})

    def test_a_failed_command_and_a_missing_figure_are_errors(self):
        row = parse(HEAD + ROW + RUN).rows[0]
        program = Path(sys.executable)
        self.assertEqual(figures_of(row, run_commands(("pellucid -c 'print(\"x 3\")'",), program)), {"x": "3"})
        with self.assertRaisesRegex(CatalogError, "nothing printed is like"):
            figures_of(row, "3")
        with self.assertRaisesRegex(CatalogError, "status 2"):
            run_commands(("pellucid -c 'exit(2)'",), program)

    def test_rows_are_chosen_by_name(self):
        rows = parse(HEAD + ROW + RUN).rows
        self.assertEqual(len(select(rows, [])), 1)
        with self.assertRaisesRegex(CatalogError, "no row q"):
            select(rows, ["q"])


if __name__ == "__main__":
    unittest.main()
