#!/usr/bin/env bash
# Kills `tessera run` and `tessera batch` with their child processes by SIGKILL at random instants and
# runs the same command again. The model must equal that of a run without kills byte for byte, and no
# file of an older run may be taken for a result of the new one, neither right after the kill nor at
# the end.
# Usage: check_kill.sh [N]     N kills of each, default 20
# TESSERA: the program (default: that of build/release, else of build/ci)
# SEED: seed of the instants (default: a new one, printed)
# Exit code 1 where something differs; 77 without the program.
set -euo pipefail
cd "$(dirname "$0")/.."
built=build/release/tessera
[[ -x $built ]] || built=build/ci/tessera
TESSERA=$(realpath "${TESSERA:-$built}")
[[ -x $TESSERA ]] || { echo "$TESSERA: no such program; build it or set TESSERA" >&2 && exit 77; }
export TESSERA SEED=${SEED:-$RANDOM}
exec python3 - "${1:-20}" <<'PYTHON'
import filecmp
import glob
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PROGRAM = os.environ["TESSERA"]
TINY = ["--preset", "fast", "--init-points", "300", "--peak-gaussians", "600", "--deterministic",
        "true", "--threads", "1"]


def read(file):
    try:
        with open(file) as text:
            return json.load(text)
    except (OSError, ValueError):
        return {}


def start(command, log):
    """In a session of its own, by which all its processes are found."""
    return subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                            start_new_session=True)


def living(session):
    """Processes of the session, eldest first: parents are killed before they can report how a child
    of theirs has ended."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat") as text:
                state, _, _, of_session = text.read().rpartition(")")[2].split()[:4]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(of_session) == session and state != "Z":
            found.append(int(name))
    return sorted(found)


def kill(process):
    while pids := living(process.pid):
        for pid in pids:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
    process.wait()


def same_files(one, other):
    if os.path.isfile(one):
        return os.path.isfile(other) and filecmp.cmp(one, other, shallow=False)
    names = sorted(n for n in os.listdir(one) if not n.startswith("."))
    return os.path.isdir(other) and all(same_files(os.path.join(one, n), os.path.join(other, n))
                                        for n in names)


class Run:
    """`tessera run` in the place of an older run of another size and seed."""
    name = "run"
    keeps = "run/model.ply"  # of an older run, in out.1
    products = {"ingest": "scene", "train": "run/model.ply", "export": "frames", "player": "player"}

    def command(self, out, new):
        more = ["--scale", "0.5", "--seed", "2", "--overwrite"] if new else ["--seed", "1"]
        return [PROGRAM, "run", "capture", "-o", out, *TINY, "--iterations", "300",
                "--export-frames", "2",
                "--checkpoint-every", "10", *more]

    def claimed(self, out, whole):
        """The results that the folder marks as done for the new command: pairs of files there and in `whole`."""
        stages, new = read(f"{out}/stages.json"), read(f"{whole}/stages.json")
        if stages.get("asked", {}).get("inputs") != new["asked"]["inputs"]:
            return []
        return [(f"{whole}/{file}", f"{out}/{file}") for stage, file in self.products.items()
                if stages.get(stage, {}).get("done") and os.path.exists(f"{whole}/{file}")]

    def results(self, whole):
        return [file for file in self.products.values() if os.path.exists(f"{whole}/{file}")]

    def where(self, out):
        stages = read(f"{out}/stages.json")
        return next((s for s, e in stages.items() if not e["done"] and s != "asked"), "between stages")


class Batch:
    """`tessera batch` over an older batch of another seed of its trainings' options."""
    name = "batch"
    keeps = ""
    run = "runs/capture/fast/seed-1"

    def command(self, out, new):
        return [PROGRAM, "batch", "capture", "-o", out, *TINY, "--checkpoint-every", "10",
                "--exports", "tessera", "--gpus", "0", "--jobs", "1", "--iterations",
                "300" if new else "40", *(["--scale", "0.5"] if new else [])]

    def claimed(self, out, whole):
        """What records of jobs say is done as it is asked for now."""
        of_job = {"ingest/capture": "scenes/capture", "train/capture/fast/seed-1": f"{self.run}/model.ply",
                  "export/capture/fast/seed-1/tessera": "exports/capture/fast/seed-1/tessera"}
        done = [job for job in of_job
                if (record := read(f"{out}/jobs/{job}.json")).get("done")
                and record["inputs"] == read(f"{whole}/jobs/{job}.json")["inputs"]
                and all(read(f"{out}/jobs/{need}.json").get("at") == at
                        for need, at in record["needs"].items())]
        if "train/capture/fast/seed-1" not in done:  # what an older training has exported
            done = [job for job in done if job.startswith("ingest/")]
        return [(f"{whole}/{of_job[job]}", f"{out}/{of_job[job]}") for job in done]

    def results(self, whole):
        return [f"{self.run}/model.ply", "exports/capture/fast/seed-1/tessera", "scenes/capture"]

    def where(self, out):
        names = sorted(glob.glob(f"{out}/jobs/**/*.json", recursive=True))
        return next((os.path.relpath(f, f"{out}/jobs") for f in names if not read(f).get("done")),
                    "between jobs")


def whole_run(job, out, new, log):
    begin = time.monotonic()
    process = start(job.command(out, new), log)
    if process.wait() != 0:
        sys.exit(f"{job.name}: ends with {process.returncode} without a kill: {log.name}")
    return time.monotonic() - begin


def forget_kept():
    for folder in glob.glob("out.*"):
        shutil.rmtree(folder)


def kills(job, count, log):
    whole_run(job, "out", False, log)
    os.rename("out", "older")
    shutil.copytree("older", "out", symlinks=True)
    seconds = whole_run(job, "out", True, log)
    os.rename("out", "whole")
    forget_kept()
    print(f"{job.name}: {seconds:.1f} s undisturbed", flush=True)
    wrong = 0
    for i in range(count):
        shutil.copytree("older", "out", symlinks=True)
        instant = random.uniform(0, seconds)
        process = start(job.command("out", True), log)
        time.sleep(instant)
        ended = process.poll() is not None
        kill(process)
        where = "after the end" if ended else job.where("out")
        problems = [f"{there} is older" for new, there in job.claimed("out", "whole")
                    if not same_files(new, there)]
        again = start(job.command("out", True), log).wait()
        if again != 0:
            problems.append(f"the same command ends with {again}")
        problems += [f"{file} differs" for file in job.results("whole")
                     if not same_files(f"whole/{file}", f"out/{file}")]
        if job.keeps and not same_files(f"older/{job.keeps}", f"out.1/{job.keeps}"):
            problems.append("the older result is gone")
        print(f"{job.name:6} {i + 1:3} {instant:6.2f} s  {where:32} {'; '.join(problems) or 'same'}",
              flush=True)
        wrong += bool(problems)
        if problems:
            os.rename("out", f"wrong_{job.name}_{i + 1}")
        else:
            shutil.rmtree("out")
        forget_kept()
    for folder in ("older", "whole"):
        shutil.rmtree(folder)
    return wrong


def main():
    seed = int(os.environ["SEED"])
    random.seed(seed)
    folder = tempfile.mkdtemp(prefix="tessera-kill.")
    os.chdir(folder)
    print(f"seed {seed}, in {folder}")
    with open("log", "a") as log:
        subprocess.run([PROGRAM, "synth", "object", "-o", "capture", "--layout", "dnerf", "--frames",
                        "6", "--held-out-frames", "1", "--width", "48", "--height", "48",
                        "--supersampling", "1", "--points", "100"], check=True, stdout=log, stderr=log)
        jobs = [Run(), Batch()]
        wrong = sum(kills(job, int(sys.argv[1]), log) for job in jobs)
    print(f"{wrong} of {len(jobs) * int(sys.argv[1])} differ")
    if wrong == 0:
        shutil.rmtree(folder)
    sys.exit(1 if wrong else 0)


main()
PYTHON
