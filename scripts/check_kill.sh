#!/usr/bin/env bash
# Kills `tessera run` and `tessera batch` with their child processes by SIGKILL at random instants and
# runs the same command again. The model must equal that of a run without kills byte for byte, and no
# file of an older run may be taken for a result of the new one, neither right after the kill nor at
# the end.
# Usage: check_kill.sh [N]     N kills of each, default 20
# TESSERA: the program (default: that of build/release, else of build/ci)
# SEED: seed of the instants (default: a new one, printed)
# Exit code 1 where something differs; 77 without the program. Batches are skipped without snakemake.
set -euo pipefail
cd "$(dirname "$0")/.."
built=build/release/tessera
[[ -x $built ]] || built=build/ci/tessera
TESSERA=$(realpath "${TESSERA:-$built}")
[[ -x $TESSERA ]] || { echo "$TESSERA: no such program; build it or set TESSERA" >&2 && exit 77; }
export TESSERA SEED=${SEED:-$RANDOM}
exec python3 - "${1:-20}" <<'PYTHON'
import filecmp
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, "tools/batch")
import records  # noqa: E402

PROGRAM = os.environ["TESSERA"]
TINY = ["--preset", "fast", "--init-points", "300", "--peak-gaussians", "600", "--deterministic",
        "true", "--threads", "1"]


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
    """`tessera run` over an older run of another size and seed."""
    name = "run"
    products = {"ingest": "scene", "train": "run/model.ply", "export": "frames", "player": "player"}

    def command(self, out, new):
        more = ["--scale", "0.5", "--seed", "2"] if new else ["--seed", "1"]
        return [PROGRAM, "run", "capture", "-o", out, *TINY, "--iterations", "300",
                "--export-frames", "2",
                "--checkpoint-every", "10", *more]

    def claimed(self, out, whole):
        """The results that the folder marks as done for the new command: pairs of files there and in `whole`."""
        stages, new = records.read(f"{out}/stages.json"), records.read(f"{whole}/stages.json")
        return [(f"{whole}/{file}", f"{out}/{file}") for stage, file in self.products.items()
                if stage in new and stages.get(stage, {}).get("done") and
                stages[stage]["key"] == new[stage]["key"]]

    def results(self, whole):
        return [file for file in self.products.values() if os.path.exists(f"{whole}/{file}")]

    def where(self, out):
        stages = records.read(f"{out}/stages.json")
        return next((s for s, e in stages.items() if not e["done"]), "between stages")


class Batch:
    """`tessera batch` over an older batch of another seed of its trainings' options."""
    name = "batch"
    run = "runs/capture/fast/seed-1"

    def command(self, out, new):
        return [PROGRAM, "batch", "capture", "-o", out, *TINY, "--checkpoint-every", "10",
                "--exports", "tessera", "--gpus", "0", "--jobs", "1", "--iterations",
                "300" if new else "40", *(["--scale", "0.5"] if new else [])]

    def claimed(self, out, whole):
        """What the report would show: runs with scores, and exports."""
        pairs = []
        if os.path.exists(f"{out}/{self.run}/metrics.json") and self.is_new(out):
            pairs.append((f"{whole}/{self.run}/model.ply", f"{out}/{self.run}/model.ply"))
        if os.path.exists(f"{out}/exports/capture/fast/seed-1/tessera.json") and self.is_new(out):
            pairs.append((f"{whole}/exports/capture/fast/seed-1/tessera",
                          f"{out}/exports/capture/fast/seed-1/tessera"))
        return pairs

    def is_new(self, out):
        return records.read(f"{out}/{self.run}/config.json").get("options", {}).get("iterations") == 300

    def results(self, whole):
        return [f"{self.run}/model.ply", "exports/capture/fast/seed-1/tessera", "scenes/capture"]

    def where(self, out):
        return next((f[:-5] for f in sorted(os.listdir(f"{out}/failures"))), "between jobs") \
            if os.path.isdir(f"{out}/failures") else "before jobs"


def whole_run(job, out, new, log):
    begin = time.monotonic()
    process = start(job.command(out, new), log)
    if process.wait() != 0:
        sys.exit(f"{job.name}: ends with {process.returncode} without a kill: {log.name}")
    return time.monotonic() - begin


def kills(job, count, log):
    whole_run(job, "out", False, log)
    os.rename("out", "older")
    shutil.copytree("older", "out", symlinks=True)
    seconds = whole_run(job, "out", True, log)
    os.rename("out", "whole")
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
        print(f"{job.name:6} {i + 1:3} {instant:6.2f} s  {where:32} {'; '.join(problems) or 'same'}",
              flush=True)
        wrong += bool(problems)
        if problems:
            os.rename("out", f"wrong_{job.name}_{i + 1}")
        else:
            shutil.rmtree("out")
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
        jobs = [Run()] + ([Batch()] if shutil.which("snakemake") else [])
        wrong = sum(kills(job, int(sys.argv[1]), log) for job in jobs)
    print(f"{wrong} of {len(jobs) * int(sys.argv[1])} differ")
    if wrong == 0:
        shutil.rmtree(folder)
    sys.exit(1 if wrong else 0)


main()
PYTHON
