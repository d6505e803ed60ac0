"""What a training is asked for: with fewer Gaussians after it ran out of memory. Whether it starts
or goes on, `tessera train` decides."""
import hashlib
import os

import records
from settings import dashed

LEAST_GAUSSIANS = 5000
LEAST_SHARE = 0.2  # of all memory in Gaussians; below, fewer of them do not help


def digest(scene):
    """Of what is in a prepared scene, by the hashes that it holds of its sources: another one may
    need less memory."""
    value = hashlib.sha256()
    for name in ("transforms.json", "points.ply"):
        if name == "transforms.json" or os.path.exists(os.path.join(scene, name)):
            with open(os.path.join(scene, name), "rb") as file:
                value.update(file.read())
    return value.hexdigest()


def smaller(run, forecast):
    """Options that halve the Gaussians of the run that died; {} where that would not help."""
    options = records.read(os.path.join(run, "config.json")).get("options", {})
    share = forecast.get("parameter_bytes", 0) + forecast.get("step_bytes", 0)
    if not options or share < LEAST_SHARE * forecast.get("total_bytes", 1):
        return {}
    peak, most = int(options["peak_gaussians"]), int(options["max_gaussians"])
    half = (max(peak, most) or forecast["gaussians"]) // 2
    if half < LEAST_GAUSSIANS:
        return {}
    # a set that is thinned out later is smaller while it grows; any other in the end
    result = {"peak_gaussians": str(half)} if peak else {}
    if not peak or most > half:
        result["max_gaussians"] = str(half)
    return result


def request(variant, seed, batch):
    return {"preset": variant.preset, "options": variant.given(), "seed": seed,
            "deterministic": batch.deterministic, "windows": batch.windows}


def command(run, scene, variant, seed, batch, forecast, out_of_memory, in_windows):
    """The words after `tessera train SCENE -o RUN`; batch.json says what it was reduced by.
    `in_windows`: the clip is long enough, and a rig."""
    state_file = os.path.join(run, "batch.json")
    asked = {**request(variant, seed, batch), "scene": digest(scene)}
    state = records.read(state_file)
    reduced = state.get("reduced", {}) if state.get("asked") == asked else {}
    if out_of_memory and state.get("asked") == asked:
        reduced = smaller(run, forecast) or reduced
    os.makedirs(run, exist_ok=True)
    records.write(state_file, {"asked": asked, "reduced": reduced})
    session = {"evaluate_every": "never", **variant.session()}  # a job of its own scores the model
    options = {**variant.given(), **reduced, "seed": str(seed),
               "deterministic": "true" if batch.deterministic else "false"}
    words = [word for key, value in [*options.items(), *session.items()]
             for word in (dashed(key), value)]
    windows = ["--windows", batch.windows] if in_windows else []
    return ["--overwrite", *windows, "--preset", variant.preset, *words]
