#!/usr/bin/env python3
"""Lists uses of standard names whose header no included file of the project brings in.

Such a file compiles with one standard library and not with the next. Usage: check_includes.py
[ROOT]; exit 1 where there are some. Comments and strings are not read.
"""
import re
import subprocess
import sys

HEADERS = {
    "algorithm": "clamp min max minmax min_element max_element minmax_element sort stable_sort"
                 " partial_sort nth_element is_sorted find find_if find_if_not find_first_of search"
                 " any_of all_of none_of count count_if copy copy_if copy_n copy_backward transform"
                 " fill fill_n generate for_each lower_bound upper_bound equal_range binary_search"
                 " unique unique_copy remove_if remove_copy_if reverse rotate shuffle equal mismatch"
                 " lexicographical_compare replace partition stable_partition set_difference"
                 " set_intersection includes adjacent_find push_heap pop_heap make_heap",
    "array": "array",
    "atomic": "atomic atomic_flag",
    "bit": "bit_cast popcount bit_width has_single_bit endian",
    "charconv": "from_chars to_chars",
    "chrono": "chrono",
    "cmath": "abs sqrt exp log pow floor ceil round lround llround isfinite isnan hypot sin cos atan2",
    "condition_variable": "condition_variable",
    "cstdlib": "getenv strtod",
    "cstring": "memcpy memset memcmp memmove strlen strerror",
    "deque": "deque",
    "exception": "exception_ptr current_exception rethrow_exception",
    "filesystem": "filesystem",
    "fstream": "ifstream ofstream",
    "functional": "function greater hash ref",
    "future": "future async promise",
    "iterator": "back_inserter inserter istreambuf_iterator",
    "limits": "numeric_limits",
    "map": "map multimap",
    "memory": "unique_ptr make_unique shared_ptr make_shared weak_ptr addressof",
    "mutex": "mutex lock_guard unique_lock scoped_lock once_flag call_once",
    "numeric": "accumulate iota reduce inner_product partial_sum exclusive_scan gcd lcm midpoint",
    "optional": "optional nullopt",
    "random": "mt19937 mt19937_64 uniform_real_distribution normal_distribution",
    "regex": "regex smatch regex_match regex_search",
    "set": "set multiset",
    "span": "span",
    "sstream": "ostringstream istringstream stringstream",
    "stdexcept": "runtime_error logic_error invalid_argument out_of_range",
    "string_view": "string_view",
    "system_error": "error_code",
    "thread": "thread this_thread",
    "tuple": "tuple tie make_tuple",
    "typeinfo": "type_info",
    "unordered_map": "unordered_map",
    "unordered_set": "unordered_set",
    "variant": "variant visit holds_alternative get_if",
    "vector": "vector",
}
WITH_FILESYSTEM = {"system_error"}  # its functions take std::error_code
CODE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"', re.S)


def source_files(root):
    listed = subprocess.check_output(["git", "-C", root, "ls-files"], text=True).split("\n")
    return [name for name in listed if name.endswith((".cpp", ".h", ".cu", ".cuh"))]


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else "."
    text = {}
    for name in source_files(root):
        with open(f"{root}/{name}", errors="replace") as file:
            text[name] = file.read()
    standard = {name: set(re.findall(r"#include <(\w+)>", t)) for name, t in text.items()}
    project = {name: re.findall(r'#include "([^"]+)"', t) for name, t in text.items()}

    def brought_in(name, seen):
        if name in seen or name not in text:
            return set()
        seen.add(name)
        headers = set(standard[name])
        for inner in project[name]:
            headers |= brought_in(inner, seen)
        return headers | WITH_FILESYSTEM if "filesystem" in headers else headers

    missing = 0
    for name, content in text.items():
        used = set(re.findall(r"\bstd::(?:ranges::)?(\w+)\b", CODE.sub(" ", content)))
        have = brought_in(name, set())
        for header, names in HEADERS.items():
            found = sorted(used & set(names.split()))
            if found and header not in have:
                print(f"{name}: std::{', std::'.join(found)} without <{header}>")
                missing += 1
    return 1 if missing else 0


sys.exit(main())
