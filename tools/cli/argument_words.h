// Words of a command line: the switches and suffixes (10k, 2s, 50%) that are accepted besides the
// plain forms of CLI11, and the check for list entries that are given twice.
#pragma once
#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/base/errors.h"
#include "tools/cli/command.h"

namespace tessera {

/// `words` in reverse order, as CLI11 parses them, with "--carve true" joined into "--carve=true"
/// for the switches of the option table, so that commands of earlier versions still work.
/// Underscores in the names of options become dashes.
std::vector<std::string> joined_switches(const std::vector<std::string>& words);

/// "--carve is 'maybe', expected no value, true or false" of the first switch whose value cannot be
/// read; empty where there is none.
std::string switch_complaint(const std::vector<std::string>& words);

/// Lets every whole number of every command take k and M, and every other number take %, and s, m
/// and h where it is a time in seconds. Names of presets, formats and other choices ignore case.
/// Call it once all commands are there. Rows of the option table read their own suffixes.
void accept_suffixes(CLI::App& app);

/// `option`: as the message begins. Errors: InputError naming what is there twice.
template <class T>
void refuse_repeats(std::vector<T> values, std::string_view option) {
  std::sort(values.begin(), values.end());
  const auto twice = std::adjacent_find(values.begin(), values.end());
  if (twice != values.end())
    throw InputError(fmt::format("{} has {} twice; name each once", option, *twice));
}

}  // namespace tessera
