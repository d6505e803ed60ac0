"""What: what a job asks of a machine, from the forecast of `tessera doctor --json` for its preset.
Not: the forecast."""
import json
import math

PROGRAM_MB = 300  # of the program itself and of pictures on their way
MEMORY_SPARE = 1.5
TIME_SPARE = 3  # the forecast's own factor
LEAST_MINUTES = 10


def row(doctor_file, variant):
    with open(doctor_file) as text:
        return json.load(text)["tables"]["forecast"][variant.preset]


def memory_mb(doctor_file, variant, attempt):
    """More at each attempt."""
    forecast = row(doctor_file, variant)
    options = dict(variant.options)
    gaussians = max(int(float(options.get(k, 0))) for k in ("peak_gaussians", "max_gaussians"))
    wider = max(1, gaussians / forecast["gaussians"])
    model = forecast["total_bytes"] - forecast["frame_bytes"]
    total = forecast["frame_bytes"] + wider * model
    return math.ceil((PROGRAM_MB + MEMORY_SPARE * total / 2**20) * attempt)


def minutes(doctor_file, variant, gpus, attempt):
    forecast = row(doctor_file, variant)
    seconds = forecast["gpu_seconds" if gpus else "cpu_seconds"]
    usual = forecast.get("iterations", 0)
    longer = float(dict(variant.options).get("iterations", usual)) / usual if usual else 1
    return max(LEAST_MINUTES, math.ceil(TIME_SPARE * longer * seconds / 60)) * attempt
