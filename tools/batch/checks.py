"""Checks of values in a file that may have been written by hand, with error messages."""
import difflib
import json
import re

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]*")


class Wrong(Exception):
    """One line that names the thing and the remedy."""


def nearest(word, words):
    near = difflib.get_close_matches(str(word), list(words), 1, 0.66)
    return f"did you mean '{near[0]}'? " if near else ""


def check_keys(entry, known, where):
    for key in entry:
        if key not in known:
            raise Wrong(f"{where}: unknown key '{key}'; {nearest(key, known)}"
                        f"There are {', '.join(known)}")


def check_name(name, where):
    if not NAME.fullmatch(name):
        raise Wrong(f"{where}: '{name}' cannot name a folder of results; give a `name` of letters, "
                    "digits and _ . + -")
    return name


def safe_name(name):
    """As in batch_config.cpp: what cannot be in the name of a folder of results becomes one _."""
    safe = re.sub(r"[^A-Za-z0-9_.+-]+", "_", name)
    return safe if NAME.fullmatch(safe) else "_" + safe


def shown(value):
    return json.dumps(value, default=str)


def list_of(given, key, kind, default, least=0, filled=False):
    """`kind`: type of the entries; None: any, of a filled list. `least`: of numbers."""
    values = given.get(key)
    values = default if values is None else values
    # a bool is an int to Python
    if kind and (not isinstance(values, list) or not all(type(v) is kind for v in values)):
        raise Wrong(f"{key}: expected a list of {'numbers' if kind is int else 'names'}, not "
                    f"{shown(values)}; write {key}: [{'1, 2' if kind is int else 'a, b'}]")
    if kind is int and any(v < least for v in values):
        raise Wrong(f"{key}: {min(values)} is too small; give numbers from {least}")
    if filled and (not isinstance(values, list) or not values):
        raise Wrong(f"{key}: expected a list with something in it, not {shown(values)}; take the "
                    f"line out for {key}: {shown(default)}")
    return values


def number(given, key, least, default):
    value = given.get(key, default)
    if type(value) is not int or value < least:
        raise Wrong(f"{key}: expected a whole number from {least}, not {shown(value)}")
    return value
