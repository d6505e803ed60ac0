"""Reads and checks batch.yaml: scenes, presets or a table, seeds, formats."""
import dataclasses
import json
import os
import re
import shutil
import subprocess

try:
    import yaml
except ImportError:  # `tessera batch` writes JSON, which is YAML
    yaml = None

from captures import Scene, read_scenes
from checks import Wrong, check_keys, check_name, list_of, nearest, number, shown

KEYS = ("scenes", "captures", "presets", "table", "options", "seeds", "budgets", "steps", "exports",
        "out", "tessera", "threads", "gpus", "deterministic", "windows", "window_jobs")
TABLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "tables")
# of a variant with each of its values: key, option, end of the name, words of the label
AXES = (("budgets", "max_gaussians", "", " Gaussians"), ("steps", "iterations", "-steps", " steps"))
SNAPSHOT = "asked.json"
SESSION_OPTIONS = ("checkpoint_every", "evaluate_every", "time_limit")  # say nothing of the model
OWN_OPTIONS = {"seed": "seeds", "deterministic": "deterministic", "threads": "threads",
               "backend": "gpus", "preset": "preset", "config": "options", "out": "out",
               "json": "exports", "resume": "options", "overwrite": "options",
               "stop_after": "iterations", "help": "options", "windows": "windows",
               "gpus": "gpus"}


@dataclasses.dataclass(frozen=True)
class Variant:
    """A preset with its options: what a column of the report is."""
    name: str
    preset: str
    options: tuple  # of (key, text), sorted
    label: str = ""  # of a row of a table, as the report shows it
    published: tuple = dataclasses.field(default=(), compare=False)  # figures of others

    def given(self):
        return {k: v for k, v in self.options if k not in SESSION_OPTIONS}

    def session(self):
        return {k: v for k, v in self.options if k in SESSION_OPTIONS}

    def number(self, key):
        """Of a checked option; 0 where it is not given."""
        return float(dict(self.options).get(key, 0))

    def arguments(self):
        return [word for k, v in self.options for word in (dashed(k), v)]


@dataclasses.dataclass(frozen=True)
class Batch:
    out: str
    program: str
    scenes: dict
    variants: dict
    seeds: tuple
    formats: tuple
    threads: int
    gpus: int
    deterministic: bool
    windows: str = "auto"  # of `tessera train`
    window_jobs: int = 1  # programs that train the windows of one clip


def dashed(key):
    return "--" + key.replace("_", "-")


def program_reference(program):
    """The options of the program as `tessera reference json` gives them. Errors: Wrong."""
    try:
        text = subprocess.run([program, "reference", "json"], capture_output=True, text=True,
                              check=True).stdout
        return json.loads(text)
    except (OSError, subprocess.CalledProcessError, ValueError) as error:
        raise Wrong(f"tessera: {program} reference json does not run ({error}); give `tessera: "
                    "/path/to/program`") from None


def command_of(reference, name):
    return next(command for command in reference["commands"] if command["name"] == name)


def choices_of(reference, command, option):
    entry = next(entry for entry in command_of(reference, command)["options"]
                 if option in entry["names"])
    return entry["choices"]


def option_keys(reference, command):
    """Names of a command's options, with underscores and without dashes in front."""
    names = [name for entry in command_of(reference, command)["options"]
             for name in entry["names"] if name.startswith("--")]
    keys = [name[2:].replace("-", "_") for name in names]
    return keys + [row["key"] for row in reference["train_options"]]


def text_of(value):
    return json.dumps(value) if isinstance(value, (bool, int, float)) else str(value)


def read_options(options, where):
    """As key → text. Errors: Wrong."""
    if not isinstance(options, dict):
        raise Wrong(f"{where}: expected {{iterations: 500}}, not {shown(options)}")
    return {str(k).replace("-", "_"): text_of(v) for k, v in options.items()}


def read_variant(entry):
    entry = {"preset": entry} if isinstance(entry, str) else entry
    if not isinstance(entry, dict) or not isinstance(entry.get("preset"), str):
        raise Wrong(f"presets: {shown(entry)} has no `preset`; write a preset's name or {{name: "
                    "a, preset: balanced, options: {iterations: 500}}")
    check_keys(entry, ("name", "preset", "options"), f"presets: {entry['preset']}")
    options = read_options(entry.get("options") or {}, f"presets: {entry['preset']}: options")
    name = check_name(str(entry.get("name") or entry["preset"]), "presets")
    return Variant(name, entry["preset"], tuple(sorted(options.items())))


def read_table(given):
    """A variant for each row of a table of the workflow; its options go over those of the file.
    Errors: Wrong."""
    if "presets" in given:
        raise Wrong("table: its rows have their presets; take out `presets` or `table`")
    names = sorted(name.removesuffix(".json") for name in os.listdir(TABLES))
    if given["table"] not in names:
        raise Wrong(f"table: unknown table '{given['table']}'; {nearest(given['table'], names)}"
                    f"There are {', '.join(names)}")
    with open(os.path.join(TABLES, given["table"] + ".json")) as text:
        rows = json.load(text)["rows"]
    above = read_options(given.get("options") or {}, "options")
    return [Variant(row["name"], row["preset"],
                    tuple(sorted({**above, **read_options(row["options"], row["name"])}.items())),
                    row["label"], tuple(row["published"])) for row in rows]


def multiplied(plain, given):
    """The variant with each of the budgets and each of the steps. Errors: Wrong."""
    variants = [plain]
    for key, option, end, words in AXES:
        values = list_of(given, key, int, [], least=1)
        if values and option in dict(plain.options):
            raise Wrong(f"{key}: {plain.name} has {option} of its own; take one of them out")
        if values:
            variants = [dataclasses.replace(
                v, name=f"{v.name}-{n}{end}", label=v.label and f"{v.label}, {n}{words}",
                options=tuple(sorted({**dict(v.options), option: str(n)}.items())))
                for v in variants for n in values]
    return variants


def read_variants(given):
    if given.get("table") is not None:
        plain = read_table(given)
    elif given.get("options"):
        raise Wrong("options: go with `table`; each of `presets` has options of its own")
    else:
        plain = [read_variant(entry)
                 for entry in list_of(given, "presets", None, ["balanced"], filled=True)]
    variants = {}
    for variant in (wide for entry in plain for wide in multiplied(entry, given)):
        if variant.name in variants:
            raise Wrong(f"presets: two are named '{variant.name}'; give one of them another "
                        "`name`")
        variants[variant.name] = variant
    return variants


def check_values(batch, variant):
    """Options are read before the scene: a training of no scene complains of that one alone."""
    words = variant.arguments()
    said = subprocess.run([batch.program, "train", "no scene", "-o", "no run", "--preset",
                           variant.preset, *words], capture_output=True, text=True, cwd="/").stderr
    if "no scene: no such folder" not in said:
        line = (said.strip().splitlines() or ["train says nothing of its options"])[-1]
        raise Wrong(f"presets: {variant.name}: {line.removeprefix('tessera: ')}")


def check_windows(batch):
    """A length is read before the scene."""
    said = subprocess.run([batch.program, "doctor", "no scene", "--windows", batch.windows],
                          capture_output=True, text=True, cwd="/").stderr
    if "--windows" in said:
        raise Wrong("windows: " + said.strip().splitlines()[-1].removeprefix("tessera: "))


def check_with_program(batch):
    """Names that only the program knows."""
    reference = program_reference(batch.program)
    check_windows(batch)
    presets = choices_of(reference, "train", "--preset")
    known = option_keys(reference, "train")
    for variant in batch.variants.values():
        if variant.preset not in presets:
            raise Wrong(f"presets: unknown preset '{variant.preset}'; "
                        f"{nearest(variant.preset, presets)}There are {', '.join(presets)}")
        for key, _ in variant.options:
            if key in OWN_OPTIONS:
                raise Wrong(f"presets: {variant.name}: '{key}' is no option of a preset; use "
                            f"`{OWN_OPTIONS[key]}` of batch.yaml")
            if key not in known:
                raise Wrong(f"presets: {variant.name}: unknown option '{key}'; {nearest(key, known)}"
                            "`tessera train --help` lists them")
        check_values(batch, variant)
    formats = choices_of(reference, "export", "--format")
    for name in batch.formats:
        if name not in formats:
            raise Wrong(f"exports: unknown format '{name}'; {nearest(name, formats)}There are "
                        f"{', '.join(formats)}")


def scenes_of(batch, part):
    """Names of all scenes; of every Nth from the Ith where `part` is "I/N". Errors: Wrong."""
    names = list(batch.scenes)
    if not part:
        return names
    numbers = re.fullmatch(r"(\d+)/(\d+)", str(part))
    first, step = map(int, numbers.groups()) if numbers else (0, 0)
    if first >= step:
        raise Wrong(f"part: expected I/N with I below N, not {part}; write part=0/4")
    return names[first::step]


def snapshot_of(batch):
    """What batch.yaml comes to, for jobs and the report."""
    return {"tessera": batch.program,
            "scenes": [{"name": s.name, "path": s.path, "ingest": list(s.ingest), "split": s.split}
                       for s in batch.scenes.values()],
            "variants": [{"name": v.name, "preset": v.preset, "options": dict(v.options),
                          "label": v.label, "published": list(v.published)}
                         for v in batch.variants.values()],
            "seeds": list(batch.seeds), "exports": list(batch.formats), "threads": batch.threads,
            "gpus": batch.gpus, "deterministic": batch.deterministic, "windows": batch.windows,
            "window_jobs": batch.window_jobs}


def from_snapshot(given, out):
    """A running batch is what it was when it began, whatever becomes of batch.yaml."""
    return Batch(out=out, program=given["tessera"],
                 scenes={s["name"]: Scene(s["name"], s["path"], tuple(s["ingest"]), s.get("split", ""))
                         for s in given["scenes"]},
                 variants={v["name"]: Variant(v["name"], v["preset"],
                                              tuple(sorted(v["options"].items())),
                                              v.get("label", ""), tuple(v.get("published", ())))
                           for v in given["variants"]},
                 seeds=tuple(given["seeds"]), formats=tuple(given["exports"]),
                 threads=given["threads"], gpus=given["gpus"],
                 deterministic=given["deterministic"], windows=given.get("windows", "none"),
                 window_jobs=given.get("window_jobs", 1))


def parse(file, text):
    """Errors: Wrong."""
    if yaml is None:
        try:
            return json.loads(text)
        except ValueError:
            raise Wrong(f"{file}: is not JSON, and the Python module that reads YAML is missing; "
                        "install it (apt-get install python3-yaml)") from None
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise Wrong(f"{file}: {' '.join(str(error).split())}") from None


def load(file):
    """Errors: Wrong."""
    base = os.path.dirname(os.path.abspath(file))
    try:
        with open(file) as text:
            given = parse(file, text.read()) or {}
    except OSError as error:
        raise Wrong(f"{file}: {error.strerror}; `tessera batch` writes it, --directory names its "
                    "folder") from None
    except UnicodeDecodeError as error:
        raise Wrong(f"{file}: {' '.join(str(error).split())}") from None
    if not isinstance(given, dict):
        raise Wrong(f"{file}: expected `key: value` lines; there are {', '.join(KEYS)}")
    check_keys(given, KEYS, file)
    out = os.path.join(base, str(given.get("out") or base))
    if os.path.realpath(out) != os.path.realpath(base):
        raise Wrong(f"out: is {out}, but {file} lies in {base}; put batch.yaml into the folder of "
                    "its results")
    if not isinstance(given.get("deterministic", False), bool):
        raise Wrong("deterministic: expected true or false")
    gpus = number(given, "gpus", 0, 0)
    program = str(given.get("tessera") or "tessera")
    program = os.path.join(base, program) if "/" in program else shutil.which(program) or program
    return Batch(out=base, program=program, scenes=read_scenes(given, base),
                 variants=read_variants(given),
                 seeds=tuple(list_of(given, "seeds", int, [1], filled=True)),
                 formats=tuple(list_of(given, "exports", str, ["tessera", "html"])),
                 threads=number(given, "threads", 1, os.cpu_count()),
                 gpus=gpus, deterministic=given.get("deterministic", False),
                 windows=str(given.get("windows") or "auto"),
                 window_jobs=number(given, "window_jobs", 1, max(1, gpus)))
