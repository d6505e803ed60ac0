"""flock, with a substitute where the file system has no locks."""
import errno
import fcntl
import sys
import time

NONE_HERE = (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP)


def take(file, kind, seconds=0):
    """Whether it was got; `seconds`: how long to try, None: as long as it takes."""
    end = None if seconds is None else time.monotonic() + seconds
    while True:
        try:
            fcntl.flock(file, kind | (0 if end is None else fcntl.LOCK_NB))
            return True
        except BlockingIOError:
            if time.monotonic() >= end:
                return False
            time.sleep(0.1)
        except OSError as error:
            if error.errno not in NONE_HERE:
                raise
            print(f"{file.name}: this file system has no locks; start nothing twice", file=sys.stderr)
            return True
