"""What: before and after a batch: one driver a folder, no records of jobs that are no more, the
report. Not: jobs."""
import fcntl
import glob
import os
import subprocess

import records
import settings
from checks import Wrong

held = []


def begin(batch, alone):
    """Drivers of parts of the batch work side by side, one of the whole works alone. Errors: Wrong,
    where another driver is at work."""
    os.makedirs("logs", exist_ok=True)
    lock = open("logs/driver.lock", "a")
    try:
        fcntl.flock(lock, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
    except BlockingIOError:
        raise Wrong(f"{batch.out}: another batch is at work here; wait for it or stop it") from None
    held.append(lock)  # released when this process ends, however that is
    settings.write_asked(batch)
    for file in glob.glob("failures/*.json"):
        record = records.read(file)
        known = (record.get("scene") in (None, *batch.scenes) and
                 record.get("preset") in (None, *batch.variants) and
                 record.get("seed") in (None, *batch.seeds) and
                 record.get("format") in (None, *batch.formats))
        if not known:
            os.remove(file)


def report(batch):
    """What failed is in it, too."""
    subprocess.run([batch.program, "report", batch.out])
