#!/usr/bin/env python3
"""Fills the tables of the documentation from results/*.json, and checks the figures in its text.

    make_tables.py           writes the blocks <!-- table: ID --> ... <!-- end table -->
    make_tables.py --check   writes nothing; exit code 1, with one line per stale block and per
                             figure that no stored value supports

docs/development/results.md describes the files, the blocks and the comments that name a source.
"""

import argparse
import json
import pathlib
import re
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FIELDS = ("id", "version", "commit", "date", "device", "command", "rows")
COLUMNS = {  # key in a row: (heading, digits after the point, divisor)
    "psnr": ("PSNR, dB", 2, 1),
    "psnr_val": ("PSNR of `val`, dB", 2, 1),
    "psnr_fit": ("PSNR after a fit of colour, dB", 2, 1),
    "psnr_lowest": ("PSNR at the lowest timestep, dB", 2, 1),
    "psnr_object": ("PSNR of the worst object, dB", 2, 1),
    "psnr_moving": ("PSNR of moving pixels, dB", 2, 1),
    "psnr_static": ("PSNR of static pixels, dB", 2, 1),
    "ssim": ("SSIM", 4, 1),
    "lpips": ("LPIPS", 4, 1),
    "seconds": ("training, s", 1, 1),
    "whole_seconds": ("whole command, s", 1, 1),
    "num_gaussians": ("Gaussians", 0, 1),
    "shipped_bytes": ("4D file, MiB", 1, 2**20),
    "peak_bytes": ("device memory, GiB", 2, 2**30),
}
MOST_COLUMNS = 5  # of a table, so that a page shows it whole
LAST_COLUMNS = ("seconds", "shipped_bytes")
UNITS = {  # unit in the text: (beginnings of the keys that have it, size of the unit in theirs)
    "dB": (("psnr",), 1),
    "s": (("seconds", "whole_seconds"), 1),
    "min": (("seconds", "whole_seconds"), 60),
    "MB": (("shipped_bytes", "peak_bytes"), 1e6),
    "MiB": (("shipped_bytes", "peak_bytes"), 2**20),
    "GiB": (("shipped_bytes", "peak_bytes"), 2**30),
    "Gaussians": (("num_gaussians",), 1),
}
BLOCK = re.compile(r"^<!-- table: (\S+) -->\n(.*?)^<!-- end table -->$", re.M | re.S)
BEGIN = re.compile(r"^<!-- table: (\S+) -->$", re.M)
FENCE = re.compile(r"^[ ]*(```|~~~).*?^[ ]*\1[ ]*$", re.M | re.S)
INLINE_CODE = re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)")
FIGURE = re.compile(r"(?<![\w.,/])(\d[\d,]*(?:\.\d+)?)(?:\s(million|thousand))?\s?"
                    r"(dB|s|min|MB|MiB|GiB|Gaussians|times (?:as \w+|\w+er)|×(?!\s?\d))(?!\w)")
SOURCE = re.compile(r"<!-- (?:from: (.*?)|(setting)) -->")


def blanked(text, pattern):
    """The text with every match replaced by blanks, so that places and lines stay."""
    return pattern.sub(lambda match: re.sub(r"[^\n]", " ", match.group(0)), text)


def load_results(folder):
    """Results files by id; ValueError names the file that is not of the form."""
    results = {}
    for path in sorted(folder.glob("*.json")):
        try:
            result = json.loads(path.read_text(encoding="utf-8"))
        except json.JSONDecodeError as error:
            raise ValueError(f"{path}: {error}") from error
        missing = [field for field in FIELDS if not result.get(field)]
        if missing:
            raise ValueError(f"{path}: has no {', '.join(missing)}")
        if result["id"] != path.stem:
            raise ValueError(f"{path}: id is {result['id']}; expected {path.stem}")
        results[path.stem] = result
    return results


def numbers(row, key):
    """The values of a row by that key: one a seed, or none."""
    value = row.get(key)
    values = value if isinstance(value, list) else [value]
    return [one for one in values if isinstance(one, (int, float)) and not isinstance(one, bool)]


def columns_of(result):
    """[(key, heading, digits, divisor)]: those the file names, else all that have values."""
    found = []
    keys = [key for key in COLUMNS if any(numbers(row, key) for row in result["rows"])]
    for column in result.get("columns", keys):
        if isinstance(column, str):
            found.append((column, *COLUMNS[column]))
        else:
            found.append((column["key"], column["heading"], column.get("digits", 2),
                          column.get("divisor", 1)))
    return found


def median_text(values, digits, divisor):
    """The median, or a dash where there is no value."""
    return f"{statistics.median(values) / divisor:,.{digits}f}" if values else "–"


def range_text(values, digits, divisor):
    """The median, and the range where there are three values or more."""
    text = median_text(values, digits, divisor)
    low, high = (f"{end(values, default=0) / divisor:,.{digits}f}" for end in (min, max))
    return f"{text} ({low}–{high})" if len(values) > 2 and low != high else text


def short_columns(columns, num_labels):
    """At most MOST_COLUMNS with the labels: the first measures, then seconds and size."""
    if num_labels + len(columns) <= MOST_COLUMNS:
        return columns
    last = [column for column in columns if column[0] in LAST_COLUMNS]
    others = [column for column in columns if column[0] not in LAST_COLUMNS]
    return others[:MOST_COLUMNS - num_labels - len(last)] + last


def label_cells(row, labels):
    return [f"`{row[label]}`" if row.get(label) else "–" for label in labels]


def lines_of(headings, num_labels, rows):
    """A table in Markdown; the columns behind the labels are aligned to the right."""
    return ["| " + " | ".join(headings) + " |",
            "|" + "---|" * num_labels + "---:|" * (len(headings) - num_labels),
            *("| " + " | ".join(row) + " |" for row in rows)]


def fold_out(result, labels, columns):
    """All columns with their ranges, closed at first: one line a measure, one column a row."""
    lines = ["", '<details markdown="1">', "<summary>Range over seeds, all measures</summary>"]
    for first in range(0, len(result["rows"]), MOST_COLUMNS - 1):
        rows = result["rows"][first:first + MOST_COLUMNS - 1]
        headings = ["measure"] + [" ".join(label_cells(row, labels)) for row in rows]
        lines += ["", *lines_of(headings, 1, (
            [heading] + [range_text(numbers(row, key), digits, divisor) for row in rows]
            for key, heading, digits, divisor in columns))]
    return lines + ["", "</details>"]


def seeds_of(result):
    """"seeds 1, 2, 3", or nothing where rows differ or have none."""
    seeds = {tuple(row.get("seeds", ())) for row in result["rows"]}
    one = seeds.pop() if len(seeds) == 1 else ()
    if not one:
        return ""
    return f", seed{'s' if len(one) > 1 else ''} {', '.join(str(seed) for seed in one)}"


def table(result):
    """The block's text: the table and the line with the source of its figures."""
    labels = [label for label in result.get("labels", ("scene", "preset"))
              if any(row.get(label) for row in result["rows"])]
    columns = columns_of(result)
    short = short_columns(columns, len(labels))
    show = range_text if short == columns else median_text
    lines = lines_of(labels + [heading for _, heading, _, _ in short], len(labels), (
        label_cells(row, labels) + [show(numbers(row, key), digits, divisor)
                                    for key, _, digits, divisor in short]
        for row in result["rows"]))
    if short != columns:
        lines += fold_out(result, labels, columns)
    note = f" {result['note']}" if result.get("note") else ""
    lines += ["", f"Version {result['version']} (commit {result['commit']}), {result['device']}, "
                  f"{result['date']}{seeds_of(result)}: `{result['command']}`.{note}"]
    return "\n".join(lines) + "\n"


def filled(text, results, place):
    """(the text with its blocks filled, complaints)."""
    complaints = []
    visible = blanked(text, FENCE)
    whole = {match.start() for match in BLOCK.finditer(visible)}
    for begin in BEGIN.finditer(visible):
        if begin.start() not in whole:
            complaints.append(f"{place}: table {begin.group(1)} has no <!-- end table -->")
    parts, end = [], 0
    for match in BLOCK.finditer(visible):
        name = match.group(1)
        if name not in results:
            complaints.append(f"{place}: table {name}: results/{name}.json does not exist")
            continue
        parts.append(text[end:match.start()])
        parts.append(f"<!-- table: {name} -->\n{table(results[name])}<!-- end table -->")
        end = match.end()
        if parts[-1] != text[match.start():end]:
            complaints.append(f"{place}: table {name} is stale; run scripts/make_tables.py")
    return "".join(parts) + text[end:], complaints


def agrees(printed, scale, value):
    """Whether the value, in units of `scale`, rounds to what is printed."""
    digits = printed.replace(",", "")
    step = 10.0 ** -len(digits.partition(".")[2])
    if "." not in digits:  # 47,000 is rounded to thousands; two figures count at least
        zeros = len(digits) - len(digits.rstrip("0"))
        step = 10.0 ** max(0, min(zeros, len(digits) - 2))
    return abs(value / scale - float(digits)) <= step / 2 * (1 + 1e-9)


def named_value(words, results):
    """The value that "ID SCENE PRESET KEY [min|max]" names; ValueError where there is none."""
    if len(words) not in (4, 5):
        raise ValueError("expected: ID SCENE PRESET KEY [min|max]")
    name, scene, preset, key = words[:4]
    for row in results.get(name, {}).get("rows", ()):
        if row.get("scene") == scene and row.get("preset") == preset and numbers(row, key):
            pick = {"": statistics.median, "min": min, "max": max}
            return pick[words[4] if len(words) == 5 else ""](numbers(row, key))
    raise ValueError(f"results/ has no {' '.join(words)}")


def source_value(source, results):
    """A named value, or the ratio or difference of two: "A / B", "A - B"."""
    for sign, compute in ((" / ", lambda a, b: a / b), (" - ", lambda a, b: a - b)):
        if sign in source:
            left, right = source.split(sign, 1)
            return compute(named_value(left.split(), results), named_value(right.split(), results))
    return named_value(source.split(), results)


def scenes_with(keys, agrees_with, results, scenes):
    """The scenes, of those given or of all, whose medians by these keys agree."""
    found = set()
    for result in results.values():
        for row in result["rows"]:
            values = [numbers(row, key) for key in row if key.startswith(keys)]
            if (not scenes or row.get("scene") in scenes) and any(
                    agrees_with(statistics.median(one)) for one in values if one):
                found.add(row.get("scene"))
    return found


def figure_complaint(match, source, results, around):
    """Why a figure is not supported, or nothing; around: the paragraph or table row it is in."""
    number, thousands, unit = match.groups()
    scale = {"million": 1e6, "thousand": 1e3}.get(thousands, 1)
    is_ratio = unit == "×" or unit.startswith("times")
    if source is None and is_ratio:
        return "a ratio names its source: <!-- from: ID SCENE PRESET KEY / ID SCENE PRESET KEY -->"
    keys, size = ((), 1) if is_ratio else UNITS[unit]
    if source is not None:
        try:
            value = source_value(source, results)
        except (ValueError, KeyError, ZeroDivisionError) as error:
            return str(error)
        if not is_ratio and not any(word.startswith(keys) for word in source.split()):
            return f"{source} is not in {unit}"
        return "" if agrees(number, scale * size, value) else f"{source} is {value / size:.6g}"
    named = {row.get("scene") for result in results.values() for row in result["rows"]}
    named = {scene for scene in named if scene and re.search(rf"(?<!\w){scene}(?!\w)", around)}
    found = scenes_with(keys, lambda value: agrees(number, scale * size, value), results, named)
    if len(found) > 1:
        return f"{', '.join(sorted(found))} have it; name one: <!-- from: ID SCENE PRESET KEY -->"
    return "" if found else "no median in results/ " + (f"of {', '.join(sorted(named))} "
                                                        if named else "") + "is that"


def surroundings(text, place):
    """The paragraph around a place, or the line where it is a row of a table."""
    line = text[text.rfind("\n", 0, place) + 1:(text + "\n").find("\n", place)]
    if line.startswith("|"):
        return line
    return text[text.rfind("\n\n", 0, place) + 1:(text + "\n\n").find("\n\n", place)]


def figure_complaints(text, results, place):
    """One line per figure in the text, outside of blocks and code, that is not supported."""
    prose = blanked(blanked(blanked(text, FENCE), BLOCK), INLINE_CODE)
    sources = list(SOURCE.finditer(prose))
    figures = list(FIGURE.finditer(blanked(prose, re.compile(r"<!--.*?-->", re.S))))
    complaints = []
    for index, match in enumerate(figures):
        end = figures[index + 1].start() if index + 1 < len(figures) else len(prose)
        end = min(end, (prose + "\n\n").find("\n\n", match.end()))
        named = next((one for one in sources if match.end() <= one.start() < end), None)
        if named is not None and named.group(2):
            continue  # a setting, not a measurement
        around = surroundings(text, match.start())
        reason = figure_complaint(match, named and named.group(1), results, around)
        if reason:
            line = prose.count("\n", 0, match.start()) + 1
            complaints.append(f"{place}:{line}: {' '.join(match.group(0).split())}: {reason}")
    return complaints


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing, report what is wrong")
    parser.add_argument("--root", type=pathlib.Path, default=ROOT, help="folder of the sources")
    arguments = parser.parse_args()
    root = arguments.root
    try:
        results = load_results(root / "results")
    except ValueError as error:
        sys.exit(f"make_tables.py: {error}")
    complaints = []
    for path in [root / "README.md", *sorted((root / "docs").rglob("*.md"))]:
        place = str(path.relative_to(root))
        text = path.read_text(encoding="utf-8")
        new, wrong = filled(text, results, place)
        if not arguments.check:
            wrong = [line for line in wrong if " is stale; " not in line]
            if new != text:
                path.write_text(new, encoding="utf-8")
                print(f"{place}: written")
        elif place in ("README.md", "docs/results.md"):
            wrong += figure_complaints(text, results, place)
        complaints += wrong
    for line in complaints:
        print(line, file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
