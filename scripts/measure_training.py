#!/usr/bin/env python3
"""Trains scenes with presets and seeds and measures the time of each part.

    measure_training.py [--tessera build/release/tessera] [--seeds 3] [--jobs 1] [--split val]
                        [--boxes ground_truth.json] [--out FILE.jsonl]
                        SCENE:PRESET[,PRESET...] ... [-- OPTION...]

Options after -- are passed to every training. A line of JSON per training is added to FILE.jsonl
as it ends; scripts/measure_results.py makes a results file of such lines. The table at the end has
medians over the seeds: seconds of training and of the whole command, sum of the device seconds of the stages, their ratio,
seconds of decisions and the frames that their first passes drew, loading, Gaussians, peak memory,
PSNR of all pixels of the test views, of moving and of static pixels, after the best gain and offset
of each camera, and at the lowest timestep. With --boxes, which holds for all scenes given, also that
of the worst object at its lowest timestep.

With --jobs above 1 trainings run side by side: scores are the same, seconds are not comparable.
--split scores the views of another split too, which the record has as psnr_SPLIT.
"""

import argparse
import concurrent.futures
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

COLUMNS = {  # key in a record: (heading, format)
    "seconds": ("train s", "{:.1f}"),
    "whole": ("whole command s", "{:.1f}"),
    "stages": ("Σ stages s", "{:.1f}"),
    "ratio": ("ratio", "{:.2f}"),
    "decisions": ("decisions s", "{:.2f}"),
    "sampled_frames": ("frames of a pass", "{:.0f}"),
    "load": ("load s", "{:.1f}"),
    "n": ("Gaussians", "{:,.0f}"),
    "peak_gib": ("peak GiB", "{:.2f}"),
    "psnr": ("PSNR", "{:.2f}"),
    "moving": ("moving", "{:.2f}"),
    "static": ("static", "{:.2f}"),
    "fit": ("after fit", "{:.2f}"),
    "lowest": ("lowest timestep", "{:.2f}"),
    "object": ("worst object", "{:.2f}"),
}


def output_of(command):
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {result.returncode}\n{result.stderr[-2000:]}")
    return result.stdout.strip()


def run_json(command):
    return json.loads(output_of(command))


def decisions_of(log):
    events = [json.loads(line) for line in log.read_text().splitlines()]
    return [event for event in events if event.get("event") == "decision"]


def program_of(tessera):
    """Version and commit of the program, as its records state them."""
    said = run_json([tessera, "env", "--json"])
    return {"version": said["version"], "commit": said["commit"]}


def measure(tessera, scene, preset, seed, options, split, boxes):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "run"
        command = [tessera, "train", scene, "-o", str(out), "--preset", preset, "--seed", str(seed),
                   *options]
        start = time.monotonic()
        trained = run_json([*command, "--json"])
        whole = time.monotonic() - start
        boxed = ["--boxes", boxes] if boxes else []
        scores = run_json([tessera, "evaluate", str(out), "--scene", scene, "--json", *boxed])
        decisions = decisions_of(out / "log.jsonl")
        other = {f"psnr_{split}": run_json([tessera, "evaluate", str(out), "--scene", scene,
                                            "--split", split, "--json"])["psnr"]} if split else {}
    stages = sum(trained["stage_ms"].values()) / 1000
    views = scores["held_out_views"] or {}
    lowest = scores["worst_timestep"] or {}
    objects = [thing["worst"]["psnr"] for thing in scores.get("objects") or []]
    return {
        "name": preset, "scene": pathlib.Path(scene).name, "preset": preset, "seed": seed,
        "options": options,
        "command": " ".join(["tessera", "train", pathlib.Path(scene).name, "-o", "RUN", *command[5:]]),
        "device": trained["device"].removeprefix("cuda, "),
        "seconds": trained["seconds"], "whole": whole, "stages": stages,
        "ratio": trained["seconds"] / stages if stages > 0 else None,
        "stage_ms": trained["stage_ms"], "stage_gbytes": trained["stage_gbytes"],
        "decisions": sum(event["decision_seconds"] for event in decisions),
        "sampled_frames": statistics.median([event["sampled_frames"] for event in decisions] or [0]),
        "load": trained["wall_seconds"]["load"],
        "n": trained["num_gaussians"], "dynamic": trained["num_dynamic"],
        "peak_bytes": trained["peak_device_bytes"], "peak_gib": trained["peak_device_bytes"] / 2**30,
        "psnr": scores["psnr"], "ssim": scores["ssim"], "bytes": scores["bytes"],
        "moving": views.get("psnr_dynamic"), "static": views.get("psnr_static"),
        "fit": scores["psnr_fit"], "lowest": lowest.get("psnr"),
        "object": min(objects, default=None), **other,
    }


def table(records):
    lines = ["| scene | preset | " + " | ".join(heading for heading, _ in COLUMNS.values()) + " |",
             "|---" * (2 + len(COLUMNS)) + "|"]
    groups = {}
    for record in records:
        groups.setdefault((record["scene"], record["preset"]), []).append(record)
    for (scene, preset), runs in groups.items():
        cells = [scene, preset]
        for key, (_, form) in COLUMNS.items():
            values = [run[key] for run in runs if run[key] is not None]
            cells.append(form.format(statistics.median(values)) if values else "–")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def arguments_and_options():
    """The words of the command line before -- and after it."""
    words = sys.argv[1:]
    split = words.index("--") if "--" in words else len(words)
    return words[:split], words[split + 1:]


def main():
    arguments, options = arguments_and_options()
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tessera", default="build/release/tessera")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("loads", nargs="+", metavar="SCENE:PRESET[,PRESET]")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--split")
    parser.add_argument("--boxes", help="ground_truth.json of a scene with movers")
    asked = parser.parse_args(arguments)
    program = program_of(asked.tessera)
    work = []
    for load in asked.loads:
        scene, colon, presets = load.rpartition(":")
        if not colon:
            parser.error(f"{load}: give the presets, too: {load}:balanced")
        work += [(scene, preset, seed) for preset in presets.split(",")
                 for seed in range(1, asked.seeds + 1)]
    records = []
    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        runs = [pool.submit(measure, asked.tessera, *one, options, asked.split, asked.boxes)
                for one in work]
        for run in concurrent.futures.as_completed(runs):
            record = run.result() | program
            records.append(record)
            print(f"{record['scene']} {record['preset']} seed {record['seed']}:",
                  ", ".join(f"{heading} {form.format(record[key])}"
                            for key, (heading, form) in COLUMNS.items()
                            if record[key] is not None), flush=True)
            if asked.out:
                with asked.out.open("a") as file:
                    file.write(json.dumps(record) + "\n")
    records.sort(key=lambda r: work.index(next(w for w in work if pathlib.Path(w[0]).name ==
                 r["scene"] and w[1:] == (r["preset"], r["seed"]))))
    print(table(records))


if __name__ == "__main__":
    main()
