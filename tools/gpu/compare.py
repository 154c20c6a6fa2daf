#!/usr/bin/env python3
"""Compares two measurements of tools/gpu/measure.sh: the times of each row, and what moved.

    tools/gpu/compare.py measured.jsonl                  # against the last one of this card in tools/gpu/measured
    tools/gpu/compare.py measured.jsonl before.json      # against this one
    tools/gpu/compare.py --keep measured.jsonl           # copies it there as CARD-DRIVER-COMMIT.json

A row counts if its calibration did not move while it was measured, and two rows are compared if their calibrations
agree within 5 %. A difference of more than 8 % is marked. The exit status is 1 if something is slower than that. It needs
nothing but Python 3.8.
"""

import json
import re
import shutil
import sys
from pathlib import Path

MEASURED = Path(__file__).resolve().parent / "measured"
# Times of equal work differ by less than this.
MOVED = 0.08
# Calibrations of the same clock differ by less than this.
STEADY = 0.05
# A pass of less time is not worth a line.
LEAST_MS = 0.02


def read(path):
    """The lines of a measurement; the last may be cut."""
    lines = []
    for text in Path(path).read_text(encoding="utf-8").splitlines():
        try:
            lines.append(json.loads(text))
        except ValueError:
            continue
    return [line for line in lines if isinstance(line, dict)]


def first(lines, kind):
    """The first line of a kind, or an empty one."""
    return next((line for line in lines if line.get("kind") == kind), {})


def key(row):
    """What identifies a row."""
    return row["scene"], row["method"], row.get("settings", ""), "x".join(str(side) for side in row["size"])


def rows(lines):
    """Rows by key, those that were measured."""
    return {key(line): line for line in lines if line.get("kind") == "row" and "median_ms" in line}


def card_and_driver(lines):
    """Names by which measurements are told apart."""
    device = first(lines, "device")
    return device.get("name", "unknown"), device.get("driver", "unknown")


def words(text):
    """The words of a name, joined by hyphens; brackets hold details."""
    text = re.sub(r"\(.*", "", text)
    return "-".join(re.findall(r"[a-z0-9.]+", text.lower()))


def file_name(lines):
    """CARD-DRIVER-COMMIT.json."""
    card, driver = (words(name) for name in card_and_driver(lines))
    # A driver's name may begin with the card's maker.
    driver = "-".join(word for word in driver.split("-") if word not in card.split("-"))
    return f"{card}-{driver}-{first(lines, 'machine').get('commit', 'unknown')}.json"


def moved(a, b):
    """The larger ratio, less one, of two calibrations, each of computing and copying."""
    ratios = [max(x, y) / min(x, y) - 1 if min(x, y) > 0 else float(x != y) for x, y in zip(a, b)]
    return max(ratios)


def is_used(row):
    """Whether the clock stayed as it was while a row was measured."""
    return bool(row.get("calibrated"))


def agree(row, before):
    """Whether two rows were measured at the same clock."""
    pairs = zip(row["calibration_ms"], before["calibration_ms"])
    return all(moved(a, b) <= STEADY for a, b in pairs)


def verdict(row, before):
    """The ratio of two rows' times, new over old, and what to say of it."""
    ratio = row["median_ms"] / before["median_ms"] if before["median_ms"] > 0 else float("inf")
    if not is_used(row) or not is_used(before):
        return ratio, "clock moved"
    if not agree(row, before):
        return ratio, "other clock"
    if ratio > 1 + MOVED:
        return ratio, "SLOWER"
    if ratio < 1 / (1 + MOVED):
        return ratio, "faster"
    return ratio, ""


def passes(row):
    """Milliseconds of each pass."""
    return {name: ms for name, ms, *_ in row.get("passes", [])}


def moved_passes(row, before):
    """Passes whose times moved, with both times."""
    old, new = passes(before), passes(row)
    found = []
    for name in {**old, **new}:
        a, b = old.get(name, 0.0), new.get(name, 0.0)
        if max(a, b) >= LEAST_MS and (min(a, b) == 0 or max(a, b) / min(a, b) > 1 + MOVED):
            found.append((name, a, b))
    return sorted(found, key=lambda one: abs(one[2] - one[1]), reverse=True)


def table(rows_of_cells):
    """Columns of equal width, the first to the left."""
    widths = [max(len(cell) for cell in column) for column in zip(*rows_of_cells)]
    lines = []
    for cells in rows_of_cells:
        padded = [cells[0].ljust(widths[0])] + [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:])]
        lines.append("  ".join(padded).rstrip())
    return lines


def summary(lines):
    """What the measurement found besides times."""
    card, driver = card_and_driver(lines)
    found = [f"{card}, {driver}, commit {first(lines, 'machine').get('commit', 'unknown')}"]
    check = first(lines, "check")
    if check:
        found.append(f"check: {check['passed']} of {check['cases']} passed, {check['failed']} failed")
        failed = [line["name"] for line in lines if line.get("kind") == "case" and line.get("verdict") == "fail"]
        found += [f"  FAIL {name}" for name in failed]
    pictures = first(lines, "pictures")
    if pictures:
        found.append(f"pictures: {pictures['equal']} of {pictures['compared']} equal to the last bit")
    every = [line for line in lines if line.get("kind") == "row"]
    unused = [line for line in every if "median_ms" in line and not is_used(line)]
    missing = [line for line in every if "median_ms" not in line]
    found.append(f"rows: {len(every)}, {len(unused)} not used since the clock moved, {len(missing)} without times")
    steps = [line for line in lines if line.get("kind") == "step" and line.get("status", 1) != 0]
    found += [f"  step {line['name']} failed" for line in steps]
    return found


def alone(lines):
    """The times of a measurement without another one."""
    cells = [("scene, method, size", "min", "median", "p95 ms", "passes", "")]
    for name, row in rows(lines).items():
        times = [f"{row[column]:.3f}" for column in ("min_ms", "median_ms", "p95_ms")]
        word = "" if is_used(row) else "clock moved"
        cells.append((" ".join(filter(None, name)), *times, str(len(row["passes"])), word))
    return table(cells)


def compared(lines, before):
    """The lines of a comparison, and whether something is slower."""
    old, new = rows(before), rows(lines)
    cells, details, slower = [("scene, method, size", "before", "now ms", "ratio", "")], [], False
    for name, row in new.items():
        label = " ".join(filter(None, name))
        if name not in old:
            cells.append((label, "-", f"{row['median_ms']:.3f}", "-", "new"))
            continue
        ratio, word = verdict(row, old[name])
        slower = slower or word == "SLOWER"
        cells.append((label, f"{old[name]['median_ms']:.3f}", f"{row['median_ms']:.3f}", f"{ratio:.2f}", word))
        if word in ("SLOWER", "faster"):
            parts = ", ".join(f"{part} {a:.3f} -> {b:.3f}" for part, a, b in moved_passes(row, old[name])[:4])
            details.append(f"{label}: {parts or 'no pass moved'}")
    gone = [" ".join(filter(None, name)) for name in old if name not in new]
    return table(cells) + details + [f"gone: {name}" for name in gone], slower


def last_of(card, driver, commit, folder=MEASURED):
    """The newest measurement of a card in the folder, of the same driver if there is one, but not of this commit."""
    found = []
    for path in sorted(folder.glob("*.json")):
        lines = read(path)
        machine = first(lines, "machine")
        its_card, its_driver = card_and_driver(lines)
        if its_card == card and machine.get("commit") != commit:
            found.append((its_driver == driver, machine.get("date", ""), path))
    return max(found)[2] if found else None


def main(arguments):
    """Prints the comparison; the exit status."""
    if len(arguments) == 2 and arguments[0] == "--keep":
        lines = read(arguments[1])
        target = MEASURED / file_name(lines)
        shutil.copyfile(arguments[1], target)
        print(target)
        return 0
    if len(arguments) not in (1, 2) or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    lines = read(arguments[0])
    commit = first(lines, "machine").get("commit")
    before = arguments[1] if len(arguments) == 2 else last_of(*card_and_driver(lines), commit)
    print("\n".join(summary(lines)))
    if before is None:
        print("no earlier measurement of this card")
        print("\n".join(alone(lines)))
        return 0
    print(f"against {before}")
    text, slower = compared(lines, read(before))
    print("\n".join(text))
    return int(slower)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
