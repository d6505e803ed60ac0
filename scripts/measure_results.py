#!/usr/bin/env python3
"""Turns records of trainings into a results file, which scripts/make_tables.py reads.

    measure_results.py RECORDS.jsonl --id quality_rigs --scenes basketball,studio
                       --presets fast,balanced,best -o results/

A line of RECORDS.jsonl is a JSON object per training: name, scene, preset, seed, options, seconds,
device, n (Gaussians), psnr, ssim, moving, static (PSNR in dB), bytes (of the exported Tessera 4D
file), version, commit, command. psnr, ssim, moving, static and bytes may be null; psnr_val (of the
split val), fit (PSNR after the best gain and offset of each camera), lowest (PSNR at the lowest
timestep), object (of the worst object at its lowest timestep), whole (seconds of the command) and
peak_bytes (of device memory) may be absent. scripts/measure_training.py writes such lines. Trainings are grouped by scene and preset;
docs/development/results.md describes the result. Where the file is there, its labels, columns, note
and source stay: a measurement that is repeated changes figures only.
"""

import argparse
import datetime
import json
import pathlib
import re
import sys

FIELDS = ("name", "scene", "preset", "seed", "options", "seconds", "device", "n", "psnr", "ssim",
          "moving", "static", "bytes", "version", "commit", "command")
KEYS = {"psnr": "psnr", "psnr_val": "psnr_val", "psnr_moving": "moving", "psnr_static": "static", "ssim": "ssim",
        "seconds": "seconds", "whole_seconds": "whole", "num_gaussians": "n", "shipped_bytes": "bytes",
        "psnr_fit": "fit", "psnr_lowest": "lowest", "psnr_object": "object", "peak_bytes": "peak_bytes"}
MAY_BE_ABSENT = {"psnr_val", "psnr_fit", "psnr_lowest", "psnr_object", "peak_bytes", "whole_seconds"}
SAID_BY_HAND = ("source", "note", "labels", "columns")


def read_records(path):
    """All records; ValueError names the line that is not one."""
    records = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip():
            continue
        try:
            record = json.loads(line)
        except json.JSONDecodeError as error:
            raise ValueError(f"{path}:{number}: {error}") from error
        missing = [field for field in FIELDS if field not in record]
        if missing:
            raise ValueError(f"{path}:{number}: has no {', '.join(missing)}")
        record["scene"] = pathlib.PurePath(record["scene"]).name
        records.append(record)
    return records


def shared(records, field):
    """The value that all records have; ValueError where they differ."""
    values = {json.dumps(record[field], sort_keys=True) for record in records}
    if len(values) != 1:
        raise ValueError(f"trainings differ in {field}: {', '.join(sorted(values))}; "
                         "choose with --scenes and --presets, or write two files")
    return records[0][field]


def command_of(records):
    """The command of all records, with what differs as words in capitals."""
    commands = []
    alone = len({record["scene"] for record in records}) == 1
    for record in records:
        command = record["command"]
        for option, word in (("--seed", "SEED"), ("--preset", "PRESET"), ("-o", "RUN")):
            command = re.sub(rf"(?<=\s){option}[ =]\S+", f"{option} {word}", command)
        scene = re.escape(record["scene"])
        name = record["scene"] if alone else "SCENE"
        command = re.sub(rf"(?<!\S)(\S*/)?{scene}/?(?!\S)", name, command)
        if command not in commands:
            commands.append(command)
    return "; ".join(commands)


def rounded(value):
    """What is measured has no more digits than that."""
    return round(value, 4) if isinstance(value, float) else value


def row_of(scene, preset, records):
    """A row of the results file, seeds ascending."""
    runs = sorted((one for one in records if one["scene"] == scene and one["preset"] == preset),
                  key=lambda one: one["seed"])
    if not runs:
        raise ValueError(f"no training of {scene} with {preset}")
    seeds = [run["seed"] for run in runs]
    if len(set(seeds)) != len(seeds):
        raise ValueError(f"{scene} {preset}: a seed occurs twice: {seeds}")
    shared(runs, "options")
    row = {"scene": scene, "preset": preset, "seeds": seeds}
    for key, field in KEYS.items():
        values = [run.get(field) for run in runs]
        if None in values and any(value is not None for value in values):
            raise ValueError(f"{scene} {preset}: {field} is null for some seeds only")
        if key in MAY_BE_ABSENT and None in values:
            continue
        row[key] = None if None in values else [rounded(value) for value in values]
    return row


def results(records, name, scenes, presets, date):
    """The results file as an object; where no presets are asked for, of those that a scene has."""
    asked = presets is not None
    scenes = scenes or list(dict.fromkeys(record["scene"] for record in records))
    presets = presets or list(dict.fromkeys(record["preset"] for record in records))
    chosen = [one for one in records if one["scene"] in scenes and one["preset"] in presets]
    for scene in scenes:
        if all(one["scene"] != scene for one in chosen):
            raise ValueError(f"no training of {scene} with {', '.join(presets)}")
    rows = [row_of(scene, preset, chosen) for scene in scenes for preset in presets
            if asked or any((one["scene"], one["preset"]) == (scene, preset) for one in chosen)]
    return {"id": name, "version": shared(chosen, "version"), "commit": shared(chosen, "commit"),
            "date": date, "device": shared(chosen, "device"), "command": command_of(chosen),
            "rows": rows}


def with_words_of(path, result):
    """The result with what a person has written into the file that it replaces."""
    if not path.exists():
        return result
    before = json.loads(path.read_text(encoding="utf-8"))
    return result | {key: before[key] for key in SAID_BY_HAND if key in before}


def text_of(result):
    """JSON with a line per row."""
    head = json.dumps({key: value for key, value in result.items() if key != "rows"},
                      ensure_ascii=False, indent=1)
    rows = ",\n  ".join(json.dumps(row, ensure_ascii=False) for row in result["rows"])
    return head[:-2] + ',\n "rows": [\n  ' + rows + "\n ]\n}\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    words = lambda text: text.split(",")
    parser.add_argument("records", type=pathlib.Path, metavar="RECORDS.jsonl")
    parser.add_argument("--id", required=True, help="name of the results file and of its table")
    parser.add_argument("--scenes", type=words, help="default: all, in the order of the records")
    parser.add_argument("--presets", type=words, help="default: all, in the order of the records")
    parser.add_argument("--date", help="of the trainings; default: when RECORDS.jsonl was written")
    parser.add_argument("-o", "--out", type=pathlib.Path, required=True, metavar="DIR")
    arguments = parser.parse_args()
    try:
        written = arguments.records.stat().st_mtime
        date = arguments.date or datetime.date.fromtimestamp(written).isoformat()
        result = results(read_records(arguments.records), arguments.id, arguments.scenes,
                         arguments.presets, date)
        path = arguments.out / f"{arguments.id}.json"
        result = with_words_of(path, result)
    except (OSError, ValueError) as error:
        sys.exit(f"measure_results.py: {error}")
    arguments.out.mkdir(parents=True, exist_ok=True)
    path.write_text(text_of(result), encoding="utf-8")
    print(path)


if __name__ == "__main__":
    main()
