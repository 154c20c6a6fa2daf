"""From measurements of whole commands to tables. No device, no numpy: plain numbers in, Markdown out.

A measurement is a dict: `job`, `kind`, `tool`, `version`, `command`, `repeat`, `cal_ms`, and either `wall_s`, `cpu_s`,
`threads`, `peak_bytes`, `picture_bytes`, or `failed` (why). One of a row may have `error`: `differ` and `rmse`.
"""

import shlex
from statistics import median

from report import NOTHING, markdown, number

HEADER = [
    "job, file",
    "tool",
    "least s",
    "median s",
    "÷ pellucid",
    "runs",
    "CPU s",
    "threads",
    "peak MB",
    "picture kB",
    "pixels off",
    "RMSE",
]


def key(measurement):
    """What makes a row."""
    return measurement["job"], measurement["kind"], measurement["tool"]


def rows_of(measurements):
    """The rows in the order of the first repeat, each a list of measurements."""
    rows = {}
    for measurement in measurements:
        rows.setdefault(key(measurement), []).append(measurement)
    return list(rows.values())


def worked(row):
    """The measurements of a row that made a picture."""
    return [m for m in row if "failed" not in m]


def least(row):
    """The shortest time of a row in seconds, or None."""
    return min((m["wall_s"] for m in worked(row)), default=None)


def ratio(row, rows):
    """The least time of a row over that of pellucid's first row of the same job and file, or None."""
    ours = [r for r in rows if key(r[0])[:2] == key(row[0])[:2] and r[0]["tool"].startswith("pellucid")]
    here, there = least(row), least(ours[0]) if ours else None
    return here / there if here and there else None


def share(value):
    """A share as a percentage, or a dash."""
    return NOTHING if value is None else f"{value:.3%}"


def rounded(error):
    """An error with two digits, or a dash."""
    if error is None:
        return NOTHING
    return f"{error:.1e}" if error else "0"


def cells(row, rows):
    """A row of the table."""
    job, kind, tool = key(row[0])
    done = worked(row)
    name = [f"{job}, {kind.upper()}", tool]
    if not done:
        return [*name, "failed", *[NOTHING] * (len(HEADER) - 3)]
    error = next((m["error"] for m in done if m.get("error")), {})
    runs = str(len(done)) if len(done) == len(row) else f"{len(done)} of {len(row)}"
    return [
        *name,
        number(least(row)),
        number(median(m["wall_s"] for m in done)),
        number(ratio(row, rows)),
        runs,
        number(min(m["cpu_s"] for m in done)),
        str(max(m["threads"] for m in done)),
        number(median(m["peak_bytes"] for m in done) / 1e6),
        number(done[0]["picture_bytes"] / 1e3),
        share(error.get("differ")),
        rounded(error.get("rmse")),
    ]


def table(measurements):
    """Every row that was asked for, measured or failed."""
    rows = rows_of(measurements)
    return markdown(HEADER, [cells(row, rows) for row in rows])


def failures(measurements):
    """The reasons of failures, each once."""
    found = dict.fromkeys(
        f"- {m['tool']}, {m['job']}, {m['kind'].upper()}: {m['failed']}" for m in measurements if "failed" in m
    )
    return "\n".join(found) or "Nothing failed."


def commands(measurements):
    """The version and the command of every row."""
    lines = []
    for first, *_ in rows_of(measurements):
        job, kind, tool = key(first)
        told = first["version"] or "no version told"
        lines.append(f"- {tool}, {job}, {kind.upper()} ({told}): `{shlex.join(first['command'])}`")
    return "\n".join(lines)


def report(measurements, machine):
    """The whole report."""
    calibrations = [m["cal_ms"] for m in measurements]
    about = "; ".join(f"{name} {value}" for name, value in machine.items())
    return "\n\n".join(
        [
            f"Machine: {about}; calibration {min(calibrations):.0f} to {max(calibrations):.0f} ms.",
            table(measurements),
            failures(measurements),
            commands(measurements),
        ]
    )
