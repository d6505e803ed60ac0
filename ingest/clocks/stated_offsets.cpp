// What: both notations of stated offsets into one table, then one entry for each camera.
// Not: a guess: a camera that is left out is an error, for 0 would be a claim too.
#include "ingest/clocks/stated_offsets.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using Offsets = std::map<std::string, double>;

Offsets from_json(const std::filesystem::path& path) {
  Offsets offsets;
  const nlohmann::json stated = read_json(path);
  for (const auto& [name, value] : stated.items())
    offsets[name] = *finite_number(stated, name.c_str(), path.string());
  return offsets;
}

/// "name seconds" or "name,seconds"; false for a line without content.
bool read_line(std::string line, const std::string& where, Offsets& offsets) {
  constexpr const char* kBlank = " \t\r,;";
  line = line.substr(0, line.find('#'));
  const size_t begin = line.find_first_not_of(kBlank);
  if (begin == std::string::npos) return false;
  const size_t end = line.find_last_not_of(kBlank) + 1;
  const size_t gap = line.find_last_of(kBlank, end - 1);
  double seconds = 0;
  bool good = gap != std::string::npos && gap > begin;
  if (good) {
    const char* const first = line.data() + gap + 1 + (line[gap + 1] == '+' ? 1 : 0);
    const auto parsed = std::from_chars(first, line.data() + end, seconds);
    good = parsed.ec == std::errc() && parsed.ptr == line.data() + end && std::isfinite(seconds);
  }
  if (!good)
    throw InputError(
        fmt::format("{}: is '{}', expected a camera and its offset in seconds, like "
                    "cam02 0.0417; correct this line",
                    where, line.substr(begin, end - begin)));
  const std::string name = line.substr(begin, line.find_last_not_of(kBlank, gap) + 1 - begin);
  if (!offsets.emplace(name, seconds).second)
    throw InputError(fmt::format("{}: states {} a second time; leave one of the two", where, name));
  return true;
}

Offsets from_text(const std::string& text, const std::string& path) {
  Offsets offsets;
  size_t number = 1;
  for (size_t position = 0; position < text.size(); ++number) {
    const size_t end = std::min(text.find('\n', position), text.size());
    read_line(text.substr(position, end - position), fmt::format("{}: line {}", path, number),
              offsets);
    position = end + 1;
  }
  return offsets;
}

}  // namespace

std::vector<double> read_stated_offsets(const std::filesystem::path& path,
                                        const std::vector<std::string>& names) {
  const std::string text = read_text_file(path);
  const size_t first = text.find_first_not_of(" \t\r\n");
  const Offsets offsets = first != std::string::npos && text[first] == '{'
                              ? from_json(path)
                              : from_text(text, path.string());
  for (const auto& [name, seconds] : offsets)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InputError(
          fmt::format("{}: states an offset for '{}', but the cameras are {}; correct "
                      "or remove it",
                      path.string(), name, fmt::join(names, ", ")));
  std::vector<double> result;
  for (const std::string& name : names) {
    const auto found = offsets.find(name);
    if (found == offsets.end())
      throw InputError(fmt::format(
          "{}: states no offset for {}; add it, with 0 for a camera whose clock is right",
          path.string(), name));
    result.push_back(found->second);
  }
  return result;
}

}  // namespace tessera
