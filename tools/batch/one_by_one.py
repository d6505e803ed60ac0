"""Runs the jobs of a batch one after the other on this machine, where Snakemake is not installed. The
jobs, their sizes and what makes one stale are those of the Snakefile.

usage: one_by_one.py [--directory OUT] [--file NAME] [--dry-run]
    --dry-run prints the jobs that would run: "train room quick 1"
Exit codes: 0; 1 something failed; 2 bad input; 75 and 130 stopped.
"""
import argparse
import dataclasses
import os
import re
import signal
import subprocess
import sys

import captures
import forecast
import hooks
import records
import settings
import training
from checks import Wrong

HERE = os.path.dirname(os.path.abspath(__file__))
FAILED, BAD_INPUT = 1, 2  # exit codes


@dataclasses.dataclass(frozen=True)
class Job:
    words: tuple  # of job.py: rule, scene, preset, seed, format
    inputs: tuple
    output: str


def jobs_of(batch):
    """In an order in which each finds its inputs."""
    results = []
    for scene in batch.scenes:
        prepared, doctor = f"scenes/{scene}.json", f"doctor/{scene}.json"
        yield Job(("ingest", scene), (), prepared)
        yield Job(("doctor", scene), (prepared,), doctor)
        for preset, seed in ((p, str(s)) for p in batch.variants for s in batch.seeds):
            place = f"{scene}/{preset}/seed-{seed}"
            trained = f"runs/{place}/train.json"
            yield Job(("train", scene, preset, seed), (doctor,), trained)
            made = [Job(("evaluate", scene, preset, seed), (trained, doctor),
                        f"runs/{place}/metrics.json")]
            made += [Job(("export", scene, preset, seed, name), (trained, doctor),
                         f"exports/{place}/{name}.json") for name in batch.formats]
            results += [job.output for job in made]
            yield from made
    yield Job(("report",), tuple(results), "logs/report.txt")


def names_in(snapshot):
    return {key: [entry["name"] if isinstance(entry, dict) else entry
                  for entry in snapshot.get(key, [])]
            for key in ("scenes", "variants", "seeds", "exports")}


def changed(job, batch):
    """Whether the output was made of other settings, or another capture, than there are now. Without
    a record of them it counts as made of these."""
    then = now = {}
    if job.words[0] == "ingest":
        scene = batch.scenes[job.words[1]]
        then, now = records.read(captures.stamp_file(scene)), captures.stamp_record(scene, batch.out)
    elif job.words[0] == "train":
        now = training.request(batch.variants[job.words[2]], int(job.words[3]), batch)
        state = records.read(os.path.join(os.path.dirname(job.output), "batch.json"))
        then = {key: value for key, value in state.get("asked", {}).items() if key in now}
    elif job.words[0] == "doctor":
        asked = records.read(job.output).get("asked_windows")
        then, now = {} if asked is None else {asked}, {batch.windows}
    elif job.words[0] == "evaluate":
        asked = records.read(job.output).get("asked_split")
        then, now = {} if asked is None else {asked}, {batch.scenes[job.words[1]].split}
    elif job.words[0] == "report":
        then, now = names_in(records.read(settings.SNAPSHOT)), names_in(settings.snapshot_of(batch))
    return bool(then) and then != now


def newer(file, output):
    return os.stat(file).st_mtime_ns > os.stat(output).st_mtime_ns


def stale_jobs(batch):
    made, stale = set(), []
    for job in jobs_of(batch):
        if (not os.path.exists(job.output) or changed(job, batch) or
                any(file in made or newer(file, job.output) for file in job.inputs)):
            made.add(job.output)
            stale.append(job)
    return stale


class Stop:
    """Signals that end the batch; the job at work has a process group of its own and gets each of
    them once, whether the terminal, a scheduler or a person sent it."""
    def __init__(self):
        self.first, self.waiting = None, []
        signal.signal(signal.SIGINT, self.note)
        signal.signal(signal.SIGTERM, self.note)
        if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # else nohup
            signal.signal(signal.SIGHUP, self.note)
        signal.signal(signal.SIGUSR1, lambda *_: None)  # of a scheduler, for the trainings

    def note(self, number, _):
        number = signal.SIGINT if number == signal.SIGINT else signal.SIGTERM
        self.first = self.first or number
        self.waiting.append(number)

    def wait(self, child):
        """Exit code of a job that runs."""
        while True:
            try:
                return child.wait(timeout=0.1)
            except subprocess.TimeoutExpired:
                while self.waiting:
                    os.killpg(child.pid, self.waiting.pop(0))


def memory_mb(job, batch, attempt):
    if job.words[0] in forecast.FIXED_MB:
        return forecast.FIXED_MB[job.words[0]] * attempt
    return forecast.memory_mb(f"doctor/{job.words[1]}.json", batch.variants[job.words[2]], attempt)


def attempts():
    with open(os.path.join(HERE, "profiles", "local", "config.yaml")) as text:
        return 1 + int(re.search(r"^retries: (\d+)", text.read(), re.M)[1])


def succeeds(job, batch, stop):
    if os.path.exists(job.output):
        os.remove(job.output)  # as Snakemake does: no failure leaves an old one behind
    threads = 1 if job.words[0] == "report" else min(batch.threads, os.cpu_count() or 1)
    for attempt in range(1, attempts() + 1):
        sizes = {"--threads": threads, "--attempt": attempt,
                 "--mem-mb": memory_mb(job, batch, attempt)}
        code = stop.wait(subprocess.Popen(
            [sys.executable, os.path.join(HERE, "job.py"), *job.words,
             *(str(word) for pair in sizes.items() for word in pair)], preexec_fn=os.setpgrp))
        if code in (0, BAD_INPUT) or stop.first:
            break
    return code == 0


def run(stale, batch, stop):
    lost = set()
    for number, job in enumerate(stale, 1):
        if stop.first:
            break
        if lost.intersection(job.inputs):
            lost.add(job.output)
            continue
        print(f"{number} of {len(stale)}:", *job.words, file=sys.stderr, flush=True)
        if not succeeds(job, batch, stop):
            lost.add(job.output)
    if stop.first:
        return hooks.INTERRUPTED if stop.first == signal.SIGINT else hooks.LEFT
    if lost:
        hooks.report(batch)
    return FAILED if lost else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--directory", default=".")
    parser.add_argument("--file", default="batch.yaml")
    parser.add_argument("--dry-run", action="store_true")
    given = parser.parse_args()
    stop = Stop()
    try:
        os.chdir(given.directory)
        batch = settings.load(given.file)
        settings.check_with_program(batch)
        stale = stale_jobs(batch)
        if stale and not given.dry_run:
            hooks.begin(batch, alone=True)
    except Wrong as error:
        print(f"tessera: {error}", file=sys.stderr)
        return BAD_INPUT
    if not stale:
        print("nothing is to do", file=sys.stderr)
    if given.dry_run:
        for job in stale:
            print(*job.words)
        return 0
    return run(stale, batch, stop)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OSError as problem:  # a full disk, a folder that is not there
        sys.exit(f"tessera: {problem}")
