// Entries are checked one by one, so that charts can rely on them.
#include "tools/bench/published.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

/// What an entry of a file of published figures must have.
void check_published(const json& entry, const std::string& where) {
  if (!entry.is_object()) throw InputError(where + " is no object of name, scene, psnr, …");
  for (const char* key : {"name", "scene", "device"})
    if (string_at(entry, key, where).empty())
      throw InputError(fmt::format("{} has no '{}'", where, key));
  for (const char* key : {"psnr", "seconds"})
    if (!finite_number(entry, key, where))
      throw InputError(fmt::format("{} has no '{}'", where, key));
  if (*finite_number(entry, "seconds", where) <= 0)
    throw InputError(where + ": seconds must be larger than 0");
  if (finite_number(entry, "bytes", where).value_or(1) <= 0)
    throw InputError(where + ": bytes must be larger than 0");
}

}  // namespace

json read_published(const std::filesystem::path& file) {
  json entries = read_json(file);
  if (entries.is_object()) entries = json(entries.value("entries", json()));
  if (!entries.is_array())
    throw InputError(fmt::format("{}: expected an array of {{name, scene, psnr, seconds, device}}",
                                 file.string()));
  for (size_t i = 0; i < entries.size(); ++i)
    check_published(entries[i], fmt::format("{}: entry {}", file.string(), i));
  return entries;
}

}  // namespace tessera
