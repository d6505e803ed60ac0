#!/usr/bin/env python3
"""Takes a results file, which scripts/make_tables.py reads, from the reports of batches.

    take_results.py OUT/report/report.json --id quality_rigs [--scenes basketball,studio]
                    [--presets fast,balanced] [--val SCENE,SCENE] -o results/

A row is a scene and a preset (with --steps or --budgets of the batch: the name of the variant), with a
value per seed. docs/development/results.md describes the file. Where it exists, its labels, columns,
note and source stay: a measurement that is repeated changes figures only. Runs of several reports are
joined.

PSNR of the split `val` (of the scenes of --val) and of the objects of `tessera evaluate --boxes` is
read from the file of scores that the report names, where that has it.

Errors have exit code 1 and one line: runs differ in version, commit or device, or the seeds of a row in
options; a run is not done or is not scored on test views; a seed is missing or occurs twice; trainings
ran side by side, so that their seconds are not comparable; a report is not that of a batch.
"""

import argparse
import datetime
import json
import pathlib
import re
import shlex
import sys

SCHEMA = 1  # of report.json
KEYS = {  # in a row: where it is in a run
    "psnr": "scores psnr", "psnr_val": "psnr_val", "psnr_moving": "scores psnr_dynamic",
    "psnr_static": "scores psnr_static", "ssim": "scores ssim", "lpips": "scores lpips",
    "seconds": "seconds training", "whole_seconds": "seconds command",
    "num_gaussians": "num_gaussians", "shipped_bytes": "size shipped_bytes",
    "psnr_fit": "scores psnr_fit", "psnr_lowest": "worst psnr", "psnr_object": "psnr_object",
    "peak_bytes": "size peak_bytes"}
MAY_BE_ABSENT = {"psnr_val", "lpips", "whole_seconds", "psnr_fit", "psnr_lowest", "psnr_object",
                 "peak_bytes"}
COUNTS = {"num_gaussians", "shipped_bytes", "peak_bytes"}
SAID_BY_HAND = ("source", "note", "labels", "columns")
# options of a training that its model does not depend on: of these, with and without a value
SILENT_OPTIONS = {"--backend": 1, "--threads": 1, "--checkpoint-every": 1, "--evaluate-every": 1,
                  "--time-limit": 1, "--resume": 0, "--overwrite": 0, "--json": 0}


def at(record, path):
    """The value at "key key" of nested objects; null where one of them is not there."""
    for key in path.split():
        record = record.get(key) if isinstance(record, dict) else None
    return record


def read_json(path):
    """The object; ValueError names the file that has none."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    if not isinstance(found, dict):
        raise ValueError(f"{path}: is no JSON object")
    return found


def more_scores(report_path, run):
    """Scores that a report does not have, from the file that it names: the PSNR of `val`, and that of
    the worst object at its lowest timestep."""
    named = [file["path"] for file in run["files"] if file["name"] == "Scores"]
    if not named:
        return {"psnr_val": None, "psnr_object": None}
    scores = read_json(report_path.parent / named[0])
    objects = [at(thing, "worst psnr") for thing in scores.get("objects") or []]
    return {"psnr_val": at(scores, "splits val psnr"),
            "psnr_object": min((psnr for psnr in objects if psnr is not None), default=None)}


def read_runs(path, commit, with_val):
    """The requested runs of a report; ValueError where it is not that of a batch. commit: of the
    program, for runs whose commit the report does not have. with_val: scenes."""
    report = read_json(path)
    if report.get("kind") != "batch" or report.get("schema") != SCHEMA:
        raise ValueError(f"{path}: expected the report of a batch, schema {SCHEMA}; it is of kind "
                         f"{report.get('kind')}, schema {report.get('schema')}")
    runs = report["runs"]
    for run in runs:
        run["commit"] = run.get("commit") or commit
        run["device"] = run["device"].removeprefix("cuda, ")
        run["options"] = {key: value for key, value in run["options"].items() if key != "seed"}
        run["num_gaussians"] = (at(run, "size static") or 0) + (at(run, "size dynamic") or 0)
        if run["state"] == "done":
            run.update(more_scores(path, run))
        if run["scene"] not in with_val:
            run["psnr_val"] = None
    return runs


def name_of(run):
    return f"{run['scene']} {run['variant']} seed {run['seed']}"


def check_done(run):
    """ValueError where a run has no scores of test views, or where its source is not known."""
    if run["state"] != "done" or at(run, "scores psnr") is None:
        raise ValueError(f"{name_of(run)}: is {run['state']}; repeat `tessera batch` until all is done")
    if run["split"] != "test":
        raise ValueError(f"{name_of(run)}: is scored on the split {run['split']}, not on test views")
    for field in ("version", "started", "command", "device"):
        if not run[field]:
            raise ValueError(f"{name_of(run)}: its {field} is not known")
    if not run["commit"]:
        raise ValueError(f"{name_of(run)}: its commit is not known; pass that of `tessera env` by "
                         "--commit")


def started(run):
    return datetime.datetime.strptime(run["started"], "%Y-%m-%dT%H:%M:%SZ").timestamp()


def check_alone(runs):
    """ValueError where a training began while another one ran on the same machine. Starts are known to
    a second. Trainings that were resumed are not compared: only their first start is known."""
    known = sorted((run for run in runs if run["started"] and at(run, "seconds training") and
                    at(run, "seconds command")), key=lambda run: (run["host"], started(run)))
    for run, following in zip(known, known[1:]):
        end = started(run) + run["seconds"]["training"]
        if following["host"] == run["host"] and started(following) <= end - 1:
            raise ValueError(f"{name_of(following)}: began while {name_of(run)} ran, so that their "
                             "seconds are not comparable; measure with --jobs 1")


def shared(runs, field):
    """The value that all runs have; ValueError where they differ."""
    values = {json.dumps(run[field], sort_keys=True) for run in runs}
    if len(values) != 1:
        raise ValueError(f"trainings differ in {field}: {', '.join(sorted(values))}; "
                         "choose with --scenes and --presets, or write two files")
    return runs[0][field]


def options_of(words):
    """The options of a training, without those that its model does not depend on."""
    kept = []
    index = 0
    while index < len(words):
        option, equals, value = words[index].partition("=")
        index += 1
        if option in ("-o", "--out", "--preset", "--seed") or SILENT_OPTIONS.get(option) == 1:
            index += 0 if equals else 1
        elif option == "--deterministic":
            if not equals and words[index:index + 1] in (["true"], ["false"]):
                value = words[index]
                index += 1
            kept += [] if value == "false" else [option]
        elif option not in SILENT_OPTIONS:
            kept.append(words[index - 1])
    return kept


def command_of(runs):
    """The commands of the trainings, each once, with what differs as words in capitals."""
    scenes = {run["scene"] for run in runs}
    commands = []
    for run in runs:
        options = options_of(shlex.split(run["command"])[3:])  # after `tessera train SCENE`
        command = shlex.join(["tessera", "train", run["scene"] if len(scenes) == 1 else "SCENE",
                              "-o", "RUN", "--preset", "PRESET", "--seed", "SEED", *options])
        if command not in commands:
            commands.append(command)
    return "; ".join(commands)


def rounded(key, value):
    """What is counted is whole; what is measured has no more digits than that."""
    if key in COUNTS:
        return int(value)
    return round(value, 4) if isinstance(value, float) else value


def row_of(scene, preset, runs, seeds):
    """A row of the results file, with all these seeds."""
    these = sorted((run for run in runs if run["scene"] == scene and run["variant"] == preset),
                   key=lambda run: run["seed"])
    if not these:
        raise ValueError(f"no training of {scene} with {preset}")
    found = [run["seed"] for run in these]
    if len(set(found)) != len(found):
        raise ValueError(f"{scene} {preset}: a seed occurs twice: {found}")
    if found != seeds:
        missing = sorted(set(seeds) - set(found))
        raise ValueError(f"{scene} {preset}: has no seed {', '.join(map(str, missing))}")
    shared(these, "options")
    row = {"scene": scene, "preset": preset, "seeds": seeds}
    for key, path in KEYS.items():
        values = [at(run, path) for run in these]
        if None in values and any(value is not None for value in values):
            raise ValueError(f"{scene} {preset}: {path} is null for some seeds only")
        if key in MAY_BE_ABSENT and None in values:
            continue
        row[key] = None if None in values else [rounded(key, value) for value in values]
    return row


def results(runs, name, scenes, presets):
    """The results file as an object; where no presets are asked for, of those that a scene has.
    ValueError: the docstring of this file."""
    asked = presets is not None
    scenes = scenes or list(dict.fromkeys(run["scene"] for run in runs))
    presets = presets or list(dict.fromkeys(run["variant"] for run in runs))
    chosen = [run for run in runs if run["scene"] in scenes and run["variant"] in presets]
    for scene in scenes:
        if all(run["scene"] != scene for run in chosen):
            raise ValueError(f"no training of {scene} with {', '.join(presets)}")
    for run in chosen:
        check_done(run)
    check_alone(runs)
    seeds = sorted({run["seed"] for run in chosen})
    rows = [row_of(scene, preset, chosen, seeds) for scene in scenes for preset in presets
            if asked or any((run["scene"], run["variant"]) == (scene, preset) for run in chosen)]
    return {"id": name, "version": shared(chosen, "version"), "commit": shared(chosen, "commit"),
            "date": max(run["started"] for run in chosen)[:10], "device": shared(chosen, "device"),
            "command": command_of(chosen), "rows": rows}


def with_words_of(path, result):
    """The result with what a person has written into the file that it replaces."""
    if not path.exists():
        return result
    before = read_json(path)
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
    parser.add_argument("reports", type=pathlib.Path, nargs="+", metavar="report.json")
    parser.add_argument("--id", required=True, help="name of the results file and of its table")
    parser.add_argument("--scenes", type=words, help="default: all, in the order of the reports")
    parser.add_argument("--presets", type=words, help="default: all, in the order of the reports")
    parser.add_argument("--val", type=words, default=[], help="scenes with the PSNR of `val`, too")
    parser.add_argument("--commit", help="of the program, where the reports do not have it")
    parser.add_argument("-o", "--out", type=pathlib.Path, required=True, metavar="DIR")
    arguments = parser.parse_args()
    path = arguments.out / f"{arguments.id}.json"
    try:
        runs = [run for report in arguments.reports
                for run in read_runs(report, arguments.commit, arguments.val)]
        result = with_words_of(path, results(runs, arguments.id, arguments.scenes, arguments.presets))
        arguments.out.mkdir(parents=True, exist_ok=True)
        path.write_text(text_of(result), encoding="utf-8")
    except (OSError, ValueError) as error:
        sys.exit(f"take_results.py: {error}")
    print(path)


if __name__ == "__main__":
    main()
