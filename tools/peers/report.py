"""From measurements to tables. No device, no numpy: plain numbers in, Markdown out.

A measurement is a dict: `scene`, `tool`, `repeat`, `cal_ms`, and either `ms` (one per frame), or `missing` (why).
One of them per scene and tool may have `error`.
"""

from statistics import median

# Hand-tuned native code (AVX2, two threads) on the same scenes, ms per frame from float32 positions to a float32 image,
# measured once on a quiet machine of the kind that docs/performance.md names; quoted, not measured by these scripts.
NATIVE_MS = {
    "pellucid sorted": {"S1": 30, "S2_32": 11, "S2_128": 18, "S2_512": 21},
    "pellucid sorted for png": {"S1": 30, "S2_32": 11, "S2_128": 18, "S2_512": 21},
    "pellucid abuffer": {"S1": 60, "S2_32": 38, "S2_128": 105, "S2_512": 400},
    "pellucid points": {"S3": 20},
}

# Columns of the table of ratios: heading, target, numerator, denominator ("native": the constant above).
RATIOS = [
    ("sorted / painter", "≤ 0.6", "pellucid sorted", "painter sorted"),
    ("sorted for png / painter", "", "pellucid sorted for png", "painter sorted"),
    ("sorted / native", "≤ 4", "pellucid sorted", "native"),
    ("sorted for png / native", "", "pellucid sorted for png", "native"),
    ("VTK peel100 / abuffer", "≥ 40", "vtk peel100", "pellucid abuffer"),
    ("abuffer / native", "≤ 10", "pellucid abuffer", "native"),
    ("points / VTK", "< 1", "pellucid points", "vtk opaque"),
    ("points / vispy", "< 1", "pellucid points", "vispy opaque"),
    ("points / native", "≤ 6", "pellucid points", "native"),
]
PER_FRAGMENT = ("abuffer ns per fragment / at S2_32", "≤ 2.5")
NOTHING = "–"


def of(measurements, scene, tool):
    """The measurements of one row that have times."""
    return [m for m in measurements if m["scene"] == scene and m["tool"] == tool and m.get("ms")]


def frame_ms(measurements, scene, tool):
    """Median over all frames of all repeats, or None."""
    times = [ms for m in of(measurements, scene, tool) for ms in m["ms"]]
    return median(times) if times else None


def ratio(measurements, scene, above, below):
    """Median over the repeats that measured both of the ratio of their medians, or None.

    Within a repeat the two ran within minutes of each other, so that slow drift of the machine cancels.
    """
    if below == "native":
        time, limit = frame_ms(measurements, scene, above), NATIVE_MS[above].get(scene)
        return time / limit if time and limit else None
    by_repeat = {m["repeat"]: median(m["ms"]) for m in of(measurements, scene, below)}
    pairs = [(m, by_repeat[m["repeat"]]) for m in of(measurements, scene, above) if m["repeat"] in by_repeat]
    return median(median(m["ms"]) / other for m, other in pairs) if pairs else None


def fragment_ns(measurements, facts, scene, tool):
    """Nanoseconds of a frame per fragment of the scene, or None."""
    time = frame_ms(measurements, scene, tool)
    return time * 1e6 / facts[scene]["fragments"] if time else None


def per_fragment_growth(measurements, facts, scene):
    """The A-buffer's time per fragment over that at 32 layers, or None."""
    if not scene.startswith("S2") or "S2_32" not in facts:
        return None
    here, there = (fragment_ns(measurements, facts, name, "pellucid abuffer") for name in (scene, "S2_32"))
    return here / there if here and there else None


def number(value, digits=3):
    """A number to some significant digits without an exponent, or a dash."""
    if value is None:
        return NOTHING
    if value >= 10 ** (digits - 1):
        return f"{value:.0f}"
    return f"{float(f'{value:.{digits}g}'):g}"


def markdown(header, rows):
    """A Markdown table whose first two columns are text and whose others are numbers."""
    rule = ["---", "---"] + ["---:"] * (len(header) - 2)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in [header, rule, *rows])


def time_row(measurements, facts, scene, tool):
    """A row of the table of times."""
    rows = of(measurements, scene, tool)
    cells = [scene, tool]
    if not rows:
        return [scene, tool, "missing", *[NOTHING] * 6]
    times = [ms for row in rows for ms in row["ms"]]
    calibrations = [row["cal_ms"] for row in rows]
    error = next((row["error"] for row in rows if row.get("error")), None)
    cells += [number(median(times)), f"{number(min(times))}–{number(max(times))}", str(len(times))]
    cells.append(number(fragment_ns(measurements, facts, scene, tool)))
    cells += [f"{error['rmse']:.1e}", f"{error['above_1_255']:.4%}"] if error else [NOTHING] * 2
    cells.append(f"{min(calibrations):.0f}–{max(calibrations):.0f}")
    return cells


def times_table(measurements, facts):
    """Every row that was asked for, measured or missing, in the order of the first repeat."""
    header = ["scene", "tool", "ms", "range", "frames", "ns per fragment", "RMSE", "pixels off by > 1/255", "cal ms"]
    names = dict.fromkeys((m["scene"], m["tool"]) for m in measurements)
    return markdown(header, [time_row(measurements, facts, *name) for name in names])


def reasons(measurements):
    """The reasons why rows are missing, each once."""
    found = dict.fromkeys(f"- {m['tool']} is missing: {m['missing']}" for m in measurements if "missing" in m)
    return "\n".join(found) or "Nothing is missing."


def ratios_table(measurements, facts):
    """Ratios per scene, and the target of each as the second row."""
    header = ["scene", "layers"] + [name for name, *_ in RATIOS] + [PER_FRAGMENT[0]]
    rows = [["target", ""] + [target for _, target, *_ in RATIOS] + [PER_FRAGMENT[1]]]
    for scene in dict.fromkeys(m["scene"] for m in measurements):
        cells = [scene, number(facts[scene]["mean_layers"])]
        cells += [number(ratio(measurements, scene, above, below)) for _, _, above, below in RATIOS]
        rows.append([*cells, number(per_fragment_growth(measurements, facts, scene))])
    return markdown(header, rows)


def report(measurements, facts, machine):
    """The whole report."""
    about = "; ".join(f"{name} {value}" for name, value in machine.items())
    versions = sorted({f"{m['version']} ({m['driver']})" for m in measurements if m.get("ms")})
    return "\n\n".join(
        [
            f"Machine: {about}.",
            "Tools: " + "; ".join(versions) + ".",
            times_table(measurements, facts),
            reasons(measurements),
            ratios_table(measurements, facts),
        ]
    )
