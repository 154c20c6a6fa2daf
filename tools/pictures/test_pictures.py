"""The gallery's page is what its data say, without the data: `python3 -m unittest discover tools/pictures`."""

import hashlib
import re
import tempfile
import unittest
from pathlib import Path

from catalog import DOCS, IMAGES, MAX_ALL, MAX_PICTURE, ROOT, CatalogError, load, load_measured, parse
from page import about, page, slug, wrap
from pictures import command_of, missing_files, sha256

FILE = '[[file]]\npath = "a/b.laz"\nsha256 = "0"\ndone = "d"\nsource = "s"\nlicense = "l"\ncredit = "Ann"\n'
THEME = '[[theme]]\nname = "t"\ntitle = "Theme"\n'
PICTURE = '[[picture]]\nname = "p"\ntheme = "t"\ntitle = "A picture, of it"\ntext = "Text."\nalt = "Alt"\n'


class Gallery(unittest.TestCase):
    """The files of this repository."""

    def test_page_is_what_the_data_say(self):
        self.assertEqual((DOCS / "gallery.md").read_text(), page(load(), load_measured()))

    def test_every_picture_is_there_and_small(self):
        catalog = load()
        files = {p.name: IMAGES / f"{p.name}.webp" for p in catalog.pictures}
        self.assertEqual(set(files.values()), set(IMAGES.glob("*.webp")))
        self.assertEqual(set(files), set(load_measured()))
        sizes = [f.stat().st_size for f in files.values()]
        self.assertLessEqual(max(sizes), MAX_PICTURE)
        self.assertLessEqual(sum(sizes), MAX_ALL)

    def test_every_link_of_the_index_has_its_heading(self):
        text = (DOCS / "gallery.md").read_text()
        headings = [slug(h) for h in re.findall(r"^#+ (.*)$", text, re.MULTILINE)]
        links = re.findall(r"\]\(#([^)]+)\)", text)
        self.assertTrue(links)
        for link in links:
            self.assertEqual(headings.count(link), 1, link)

    def test_commands_name_the_files_of_their_picture(self):
        catalog = load()
        for picture in catalog.pictures:
            text = " ".join(picture.commands)
            text += "".join((DOCS / "scenes" / s).read_text() for s in picture.scenes if (DOCS / "scenes" / s).exists())
            for path in picture.files:
                self.assertIn(catalog.sources[path].local, text, picture.name)
            if not picture.panels:
                self.assertIn(f"-o {picture.name}.png", text)

    def test_readme_has_a_command_for_each_of_its_pictures(self):
        readme = (ROOT / "README.md").read_text()
        names = re.findall(r"\]\(docs/images/scans/(\w+)\.png\)", readme)
        self.assertEqual(names, [entry["name"] for entry in load().readme])
        for name in names:
            self.assertEqual(command_of(readme, name)[:2], ["render", "scan.laz"])


class Parts(unittest.TestCase):
    """Known answers."""

    def test_mistakes_are_named(self):
        good = FILE + THEME + PICTURE + 'files = ["a/b.laz"]\ncommands = ["pellucid render b.laz -o p.png"]\n'
        self.assertEqual(parse(good).pictures[0].title, "A picture, of it")
        for old, new, message in [
            ('theme = "t"', 'theme = "u"', "no theme is named u"),
            ('files = ["a', 'files = ["b', "no file is named b/b.laz"),
            ("pellucid render", "rm -rf", "not a command"),
            ('alt = "Alt"', "", "alt"),
            ("[[picture]]", "[[picture", "gallery.toml"),
        ]:
            with self.assertRaisesRegex(CatalogError, message):
                parse(good.replace(old, new))

    def test_page_shows_command_credit_points_and_time(self):
        text = page(
            parse(FILE + THEME + PICTURE + 'files = ["a/b.laz"]\ncommands = ["pellucid render b.laz"]\n'),
            {"p": {"points": 1234567, "seconds": 41.0}},
        )
        self.assertIn("- **Theme:** [A picture, of it](#a-picture-of-it)\n", text)
        self.assertIn("```sh\npellucid render b.laz\n```\n\n*1,234,567 points · about 40 s · data: Ann*\n", text)

    def test_long_commands_are_continued(self):
        for picture in load().pictures:
            for command in picture.commands:
                text = wrap(command)
                self.assertLessEqual(max(map(len, text.split("\n"))), 100)
                self.assertEqual(text.replace(" \\\n    ", " "), command)

    def test_times_are_orders_of_magnitude(self):
        self.assertEqual([about(s) for s in (0.2, 3.6, 23, 88, 130)], ["1 s", "4 s", "25 s", "90 s", "2 min"])

    def test_checksums_find_other_and_missing_files(self):
        with tempfile.TemporaryDirectory() as folder:
            data = Path(folder)
            catalog = parse(FILE + THEME + PICTURE + 'commands = ["pellucid render"]\n')
            self.assertEqual(missing_files(catalog, data, {"a/b.laz"}), {"a/b.laz"})
            (data / "a").mkdir()
            (data / "a" / "b.laz").write_bytes(b"x")
            with self.assertRaisesRegex(CatalogError, "SHA-256"):
                missing_files(catalog, data, {"a/b.laz"})
            line = hashlib.sha256(b"x").hexdigest() + "  b.laz\n"
            self.assertEqual(sha256(data / "a"), hashlib.sha256(line.encode()).hexdigest())


if __name__ == "__main__":
    unittest.main()
