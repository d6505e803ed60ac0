"""Runs one job of a batch: calls the program, appends to its log, and writes failures/JOB.json
unless it succeeds. The Snakefile and one_by_one.py call it.

usage: job.py RULE [SCENE [PRESET SEED [FORMAT or NUMBER]]] --threads N --attempt N --mem-mb N
                [--refused MESSAGE]   records only that the cluster did not take the job
"""
import argparse
import fcntl
import glob
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import captures
import forecast
import locks
import records
import settings
import training

RULES = ("ingest", "doctor", "train", "windows", "evaluate", "export", "report")
FAILED, BAD_INPUT, INTERRUPTED, KILLED = 1, 2, 130, 137  # exit codes
KERNEL_COUNTERS = os.environ.get("TESSERA_KERNEL_COUNTERS", "/proc/vmstat")  # another one in tests
UNFINISHED = ("ended without a word: out of memory or time, or its machine was lost "
              "(or it still runs)")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("rule", choices=RULES)
    for name in ("scene", "preset", "seed", "format"):
        parser.add_argument(name, nargs="?")
    for name in ("--threads", "--attempt", "--mem-mb"):
        parser.add_argument(name, type=int, default=1)
    parser.add_argument("--refused")
    return parser.parse_args()


class Job:
    def __init__(self, given, batch):
        self.given, self.batch = given, batch
        self.where = [w for w in (given.scene, given.preset, given.seed and f"seed-{given.seed}",
                                  given.format) if w]
        self.name = ".".join([given.rule, *self.where])
        self.failure = f"failures/{self.name}.json"
        self.log = os.path.join("logs", given.rule, ".".join(self.where or ["report"]) + ".log")
        self.scene = f"scenes/{given.scene}"
        self.run = os.path.join("runs", *self.where[:3])
        self.doctor = f"doctor/{given.scene}.json"
        self.threads = ["--threads", str(given.threads)]
        self.backend = ["--backend", "cuda" if batch.gpus else "cpu", *self.threads]

    def forget(self):
        """What is made of this job's output goes, so that no failure leaves old results behind."""
        if self.given.rule not in ("ingest", "train"):
            return  # that of "windows" makes nothing that another job needs
        below = os.path.join(self.given.scene, *(self.where[1:] or ["*", "*"]))
        made = [self.doctor] if self.given.rule == "ingest" else []
        made += [f"runs/{below}/train.json", f"runs/{below}/metrics.json", f"exports/{below}/*.json"]
        for pattern in made:
            for file in glob.glob(pattern):
                os.remove(file)

    # Each stage: the program's words, and where its standard output goes.

    def ingest(self, _):
        scene = self.batch.scenes[self.given.scene]
        stamp_file = captures.stamp_file(scene)
        os.makedirs(os.path.dirname(stamp_file), exist_ok=True)
        records.write(stamp_file, captures.stamp_record(scene, self.batch.out))
        frames = []
        if self.batch.windows != "none" and "--frames-as" not in scene.ingest:
            frames = ["--frames-as", "auto"]
        return (["ingest", scene.path, "-o", self.scene, "--overwrite", *scene.ingest, *frames,
                 *self.threads, "--json"], self.scene + ".json")

    def doctor_(self, _):
        return ["doctor", self.scene, "--windows", self.batch.windows, *self.threads,
                "--json"], self.doctor

    def train(self, before):
        variant = self.batch.variants[self.given.preset]
        in_windows = bool(forecast.windows(self.doctor))
        words = training.command(
            self.run, self.scene, variant, int(self.given.seed), self.batch,
            forecast.row(self.doctor, variant.preset),
            not in_windows and died_of_memory(before), in_windows)
        return (["train", self.scene, "-o", self.run, *words, *self.backend, "--json"],
                self.run + "/train.json")

    def windows(self, before):
        """Trains windows of a clip beside its train job; of other clips nothing."""
        output = f"{self.run}/windows-{self.given.format}.json"
        words = self.train(before)[0] if forecast.windows(self.doctor) else []
        return words, output

    def evaluate(self, _):
        split = self.batch.scenes[self.given.scene].split
        with open(self.doctor) as text:
            if not split and not json.load(text)["tables"]["leakage"]["held_out_frames"]:
                split = "train"
        words = ["--split", split] if split else []
        return ["evaluate", self.run, *words, *self.backend, "--json"], self.run + "/metrics.json"

    def export(self, _):
        folder = os.path.join("exports", *self.where)
        return (["export", self.run, "-o", folder, "--format", self.given.format, *self.threads,
                 "--json"], folder + ".json")

    def report(self, _):
        return ["report", self.batch.out], "logs/report.txt"

    def words(self, before):
        stage = self.given.rule
        return getattr(self, stage + "_" if stage == "doctor" else stage)(before)

    def record(self, exit_code, message, out_of_memory=False):
        given = self.given
        records.write(self.failure, {
            "job": self.name, "rule": given.rule, "scene": given.scene, "preset": given.preset,
            "seed": given.seed and int(given.seed), "format": given.format,
            "exit_code": exit_code, "message": message, "out_of_memory": out_of_memory,
            "attempt": given.attempt,
            "mem_mb": given.mem_mb, "log": self.log, "slurm_job": os.environ.get("SLURM_JOB_ID"),
            "time": time.strftime("%Y-%m-%dT%H:%M:%S%z")})


def slurm_state(job):
    """"" where there is no such job, or no Slurm."""
    if not job or not shutil.which("scontrol"):
        return ""
    shown = subprocess.run(["scontrol", "-o", "show", "job", job], capture_output=True, text=True)
    states = [w.partition("=")[2] for w in shown.stdout.split() if w.startswith("JobState=")]
    return states[0] if states else ""


def died_of_memory(failure):
    """`failure`: record of the attempt before."""
    return (failure.get("out_of_memory", False) or
            slurm_state(failure.get("slurm_job")) == "OUT_OF_MEMORY")


def free_gpu(count):
    """The environment with one of this machine's GPUs, where nobody has chosen one yet; held open
    as long as the process lives."""
    environment = dict(os.environ)
    if count < 2 or "CUDA_VISIBLE_DEVICES" in environment:
        return environment, None
    while True:
        for gpu in range(count):
            lock = open(f"logs/gpu-{gpu}.lock", "a+")
            if locks.take(lock, fcntl.LOCK_EX):
                return {**environment, "CUDA_VISIBLE_DEVICES": str(gpu)}, lock
            lock.close()
        time.sleep(1)


def last_line(log, begin):
    """What the program said last: its `tessera: …` line where there is one."""
    with open(log, errors="replace") as text:
        text.seek(begin)
        lines = [line.strip() for line in text.read().replace("\r", "\n").split("\n")]
    lines = [line for line in lines if line]
    own = [line for line in lines if line.startswith("tessera: ")]
    return (own or lines or ["said nothing"])[-1]


def kills_for_memory():
    """Programs that the kernel has killed for memory until now; 0 where it does not count them."""
    try:
        with open(KERNEL_COUNTERS) as counters:
            return sum(int(line.split()[1]) for line in counters if line.startswith("oom_kill "))
    except OSError:
        return 0


def failure_of(code, was_kernel, log, begin):
    """What the record of a failure says. `was_kernel`: it has killed a program for memory meanwhile.
    SIGKILL alone does not tell: whoever stops a machine or a queue sends it, too."""
    if code == KILLED:
        message = "was killed (SIGKILL)" + (": out of memory" if was_kernel else "")
    elif code == INTERRUPTED:
        message = "was interrupted; repeat the command to go on"
    else:
        message = last_line(log, begin)
    return code, message, "out of memory" in message.lower()


def accepted(job, code, output):
    """Findings of doctor are no failure of the job: they are in its file and in the report."""
    if code != 0 and not (job.given.rule == "doctor" and code == 1):
        return False
    return job.given.rule == "report" or records.read(output) != {}


def run(job, words, output, log):
    """Exit code of the program. Without words there is nothing to do."""
    if not words:
        records.write(output, {"windows": 1})
        return 0
    on_gpu = job.given.rule in ("train", "windows", "evaluate")
    environment, gpu = free_gpu(job.batch.gpus if on_gpu else 0)
    command = [job.batch.program, *words]
    print(time.strftime("%F %T"), "attempt", job.given.attempt, *command, file=log, flush=True)
    with open(output, "w") as standard:
        # the program holds the log, and by it the lock, also if this process is killed
        code = subprocess.run(command, stdout=standard, stderr=log, env=environment,
                              pass_fds=[gpu.fileno()] if gpu else []).returncode
    return 128 - code if code < 0 else code


def perform(job, log):
    """Exit code and message of the job, and whether it ran out of memory."""
    before = records.read(job.failure)
    if job.given.attempt > 1 and before.get("exit_code") == BAD_INPUT:
        return BAD_INPUT, before["message"], False  # more memory does not change the input
    job.record(None, UNFINISHED)
    job.forget()
    words, output = job.words(before)
    part = job.log.removesuffix(".log") + ".part"  # the program may rename its folder
    state = os.path.join(job.run, "batch.json")
    asked = records.read(state)
    begin = os.fstat(log.fileno()).st_size
    started, kills = time.monotonic(), kills_for_memory()
    code = run(job, words, part, log)
    os.makedirs(os.path.dirname(output), exist_ok=True)
    if asked and not os.path.exists(state):
        records.write(state, asked)
    if not accepted(job, code, part):
        os.remove(part)
        return failure_of(code or FAILED, kills_for_memory() > kills, job.log, begin)
    if job.given.rule != "report":  # the report adds them up
        more = {"job_seconds": round(time.monotonic() - started, 3)}
        if job.given.rule == "evaluate":
            more["asked_split"] = job.batch.scenes[job.given.scene].split
        if job.given.rule == "doctor":
            more["asked_windows"] = job.batch.windows
        records.write(part, {**records.read(part), **more})
    os.replace(part, output)
    return 0, "", False


def main():
    given = arguments()
    job = Job(given, settings.from_snapshot(records.read(settings.SNAPSHOT), os.getcwd()))
    for folder in ("failures", os.path.dirname(job.log)):
        os.makedirs(folder, exist_ok=True)
    if given.refused:
        job.record(FAILED, given.refused)
        return FAILED
    with open(job.log, "a+") as log:
        locks.take(log, fcntl.LOCK_EX, seconds=None)  # an earlier start may still be at work
        # Slurm and terminals signal all processes of a job: the program stops, this one tells how
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1):
            signal.signal(number, lambda *_: None)
        try:
            failure = perform(job, log)
        except Exception as error:  # a full disk, a file that is not what it was
            failure = FAILED, f"{type(error).__name__}: {error}", False
        code, message, _ = failure
        if code == 0:
            os.remove(job.failure)
        else:
            print(f"{job.name}: {message}", file=sys.stderr)
            job.record(*failure)
            print(time.strftime("%F %T"), "exit", code, message, file=log, flush=True)
    return code


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OSError as problem:  # a full disk: not even a record of it could be written
        sys.exit(f"job.py: {problem}")
