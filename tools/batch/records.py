"""Reads and writes small JSON files; a file is written as a whole or not at all."""
import json
import os
import socket


def read(file):
    try:
        with open(file) as text:
            return json.load(text)
    except (OSError, ValueError):
        return {}


def write(file, value):
    part = f"{file}.{socket.gethostname()}.{os.getpid()}.part"
    try:
        with open(part, "w") as text:
            json.dump(value, text, indent=1)
            text.flush()
            os.fsync(text.fileno())
        os.replace(part, file)
    except OSError:  # a full disk
        if os.path.exists(part):
            os.remove(part)
        raise
