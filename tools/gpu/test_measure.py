"""The road of tools/gpu/measure.sh, by programs that only print: `python3 -m unittest discover tools/gpu`."""

import json
import os
import stat
import subprocess
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
# What a device that works prints for each step of --quick.
LINES = {
    "device": ['{"kind":"device","name":"a card"}'],
    "ceilings": ['{"kind":"ceiling"}'] * 9,
    "check": ['{"kind":"case"}'] * 2,
    "record": ['{"kind":"recorded"}'],
    "pictures": ['{"compared":3,"equal":3,"kind":"pictures"}'],
    "rows": ['{"kind":"row"}'] * 13,
    "rates": ['{"kind":"rate"}'] * 4,
    "pipelines": ['{"kind":"pipelines"}'],
}


class Steps(unittest.TestCase):
    def measured(self, **others):
        """Status, what was said, and the lines of results, where steps print or do something else."""
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "gpu-table"
            cases = ""
            for name, lines in LINES.items():
                commands = others.get(name, "\n".join(f"echo '{line}'" for line in lines))
                cases += f"{name})\n{commands}\n;;\n"
            program.write_text(f"#!/bin/bash\ncase $1 in\n{cases}esac\n", encoding="utf-8")
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            out = Path(folder) / "out"
            command, environment = [str(HERE / "measure.sh"), "--quick", folder], {**os.environ, "OUT": str(out)}
            done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
            lines = [json.loads(line) for line in (out / "measured.jsonl").read_text(encoding="utf-8").splitlines()]
            self.assertLessEqual(len(list(out.iterdir())), 8)
            return done.returncode, done.stderr, lines

    def steps(self, lines):
        return {line["name"]: line["status"] for line in lines if line["kind"] == "step"}

    def test_all_steps_that_work(self):
        status, said, lines = self.measured()
        self.assertEqual((status, said), (0, ""))
        self.assertEqual(self.steps(lines), dict.fromkeys(LINES, 0))
        self.assertEqual(lines[0]["kind"], "machine")
        self.assertEqual(sum(line["kind"] == "row" for line in lines), 13)

    def test_a_step_that_fails_stops_no_other(self):
        status, said, lines = self.measured(check="echo 'no memory' >&2; exit 3")
        self.assertEqual((status, said), (1, "failed: check: status 3: no memory\n"))
        self.assertEqual(self.steps(lines), {**dict.fromkeys(LINES, 0), "check": 3})

    def test_a_row_that_is_missing_is_a_failure(self):
        rows = "\n".join(["echo '{\"kind\":\"row\"}'"] * 12)
        status, said, _ = self.measured(rows=rows)
        self.assertEqual((status, said), (1, "failed: rows: 12 lines of row instead of 13\n"))

    def test_a_picture_that_differs_is_a_failure(self):
        for equal, compared in [(2, 3), (2, 2)]:
            line = f"echo '{{\"compared\":{compared},\"equal\":{equal},\"kind\":\"pictures\"}}'"
            status, said, _ = self.measured(pictures=line)
            self.assertEqual(status, 1)
            self.assertIn(f"failed: pictures: compared and equal: {compared},{equal}", said)

    def test_a_step_that_is_killed_stops_no_other(self):
        status, said, lines = self.measured(ceilings="kill -9 $$")
        self.assertEqual(status, 1)
        self.assertIn("failed: ceilings: status 137", said)
        self.assertEqual(self.steps(lines), {**dict.fromkeys(LINES, 0), "ceilings": 137})

    def test_half_a_line_of_a_process_that_was_ended_is_left_out(self):
        status, said, lines = self.measured(rates="echo '{\"kind\":\"rate\"}'; printf '{\"kind\":\"ra'; exit 1")
        self.assertEqual(status, 1)
        self.assertIn("failed: rates: status 1", said)
        self.assertEqual(sum(line["kind"] == "rate" for line in lines), 1)

    def test_a_number_of_seconds_is_needed(self):
        for arguments in [[], ["59"], ["421"], ["-5"], ["4m"]]:
            done = subprocess.run([str(HERE / "measure.sh"), *arguments], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2, arguments)
            self.assertIn("usage", done.stderr)


if __name__ == "__main__":
    unittest.main()
