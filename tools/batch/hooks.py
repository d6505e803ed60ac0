"""Start and end of a batch: one driver a folder, its settings kept, stale records of jobs
removed, the report."""
import fcntl
import glob
import os
import subprocess
import time

import locks
import records
import settings
from checks import Wrong

LEFT, INTERRUPTED = 75, 130  # exit codes
held = []
begun = time.time()


def begin(batch, alone):
    """Drivers of parts of one batch work side by side, one of the whole works alone. Errors: Wrong,
    where another driver is at work."""
    os.makedirs("logs", exist_ok=True)
    lock = open("logs/driver.lock", "a+")
    held.append(lock)  # released when this process ends, however that is
    now = settings.snapshot_of(batch)
    if locks.take(lock, fcntl.LOCK_EX):
        records.write(settings.SNAPSHOT, now)
        if not alone:
            locks.take(lock, fcntl.LOCK_SH)
    elif alone or not locks.take(lock, fcntl.LOCK_SH, seconds=10):
        raise Wrong(f"{batch.out}: another batch is at work here; wait for it or stop it")
    elif records.read(settings.SNAPSHOT) != now:
        raise Wrong(f"{batch.out}: another part of it is at work with other settings; wait for it "
                    "or stop it")
    # a target that is there needs nothing, whatever else is missing: only without it are jobs that
    # fail now to be done next time
    if os.path.exists("logs/report.txt"):
        os.remove("logs/report.txt")
    for file in glob.glob("failures/*.json"):
        record = records.read(file)
        known = (record.get("scene") in (None, *batch.scenes) and
                 record.get("preset") in (None, *batch.variants) and
                 record.get("seed") in (None, *batch.seeds) and
                 record.get("format") in (None, *batch.formats))
        if not known:
            os.remove(file)


def stopped():
    """Whether jobs of this driver were told to stop: whoever did that waits for no report."""
    return any(records.read(file).get("exit_code") in (LEFT, INTERRUPTED)
               for file in glob.glob("failures/*.json") if os.path.getmtime(file) >= begun)


def report(batch):
    """What failed is in it, too."""
    if not stopped():
        subprocess.run([batch.program, "report", batch.out])
