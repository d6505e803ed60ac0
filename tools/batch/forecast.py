"""The resources of a job, from the forecast of `tessera doctor --json` for its preset."""
import json
import math

PROGRAM_MB = 300  # of the program itself and of pictures on their way
MEMORY_SPARE = 1.5
TIME_SPARE = 3  # the forecast's own factor
LEAST_MINUTES = 10
FIXED_MB = {"ingest": 2000, "doctor": 1000, "report": 500}  # of jobs without a forecast


def table(doctor_file, *names):
    """{} where there is none: an older program wrote the file, or nobody did."""
    try:
        with open(doctor_file) as text:
            found = json.load(text)["tables"]
        for name in names:
            found = found[name]
        return found or {}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def row(doctor_file, preset):
    return table(doctor_file, "forecast", preset)


def windows(doctor_file):
    """Those that a clip is cut into; {} where it is trained as a whole."""
    found = table(doctor_file, "windows")
    return found if found.get("windows", 1) > 1 else {}


def memory_mb(doctor_file, variant, attempt):
    """More at each attempt."""
    forecast = row(doctor_file, variant.preset)
    if not forecast:
        return PROGRAM_MB * attempt
    window = windows(doctor_file)
    if window:
        return math.ceil((PROGRAM_MB + MEMORY_SPARE * window["host_bytes"] / 2**20) * attempt)
    gaussians = max(variant.number(k) for k in ("peak_gaussians", "max_gaussians"))
    wider = max(1, gaussians / forecast["gaussians"])
    model = forecast["total_bytes"] - forecast["frame_bytes"]
    total = forecast["frame_bytes"] + wider * model
    return math.ceil((PROGRAM_MB + MEMORY_SPARE * total / 2**20) * attempt)


def minutes(doctor_file, variant, gpus, attempt, jobs=1):
    """`jobs`: those that share the windows of a clip."""
    forecast = row(doctor_file, variant.preset)
    if not forecast:
        return LEAST_MINUTES * attempt
    seconds = forecast["gpu_seconds" if gpus else "cpu_seconds"]
    window = windows(doctor_file)
    if window:
        seconds = max(seconds, window["window_seconds"]) * math.ceil(window["windows"] / jobs)
    longer = (variant.number("iterations") or forecast["iterations"]) / forecast["iterations"]
    return max(LEAST_MINUTES, math.ceil(TIME_SPARE * longer * seconds / 60)) * attempt
