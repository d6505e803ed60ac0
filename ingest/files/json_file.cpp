// Errors of the text name the file; errors of values name their place in it.
#include "ingest/files/json_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// visit(i) for every character outside of strings; it may change the text from there on.
template <class Text, class Visit>
void outside_strings(Text& text, Visit&& visit) {
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    if (in_string && text[i] == '\\')
      ++i;
    else if (text[i] == '"')
      in_string = !in_string;
    else if (!in_string)
      visit(i);
  }
}

/// Python's json module writes NaN, Infinity and -Infinity; as null they reach the check that knows
/// which frame they belong to.
void blank_non_finite(std::string& text) {
  outside_strings(text, [&](size_t i) {
    if (text[i] != 'N' && text[i] != 'I' && text[i] != '-') return;
    const std::string_view rest = std::string_view(text).substr(i);
    for (const std::string_view token : {"-Infinity", "Infinity", "NaN"})
      if (rest.starts_with(token)) {
        text.replace(i, token.size(), "null");
        break;  // `rest` looks at the text before the replacement
      }
  });
}

/// Levels of lists and objects; those that are open where the text ends, too.
int64_t depth_of(std::string_view text) {
  int64_t depth = 0, deepest = 0;
  outside_strings(text, [&](size_t i) {
    if (text[i] == '[' || text[i] == '{') deepest = std::max(deepest, ++depth);
    if (text[i] == ']' || text[i] == '}') --depth;
  });
  return deepest;
}

}  // namespace

nlohmann::json parse_json(std::string text, const std::filesystem::path& path) {
  constexpr int64_t kDeepest = 100;  // copying and freeing a tree takes stack for each level
  if (depth_of(text) > kDeepest)
    throw InputError(fmt::format("{}: its JSON is more than {} levels deep; export it again",
                                 path.string(), kDeepest));
  blank_non_finite(text);
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{}: is not valid JSON ({}); correct it or export it again",
                                 path.string(), error.what()));
  }
}

nlohmann::json read_json(const std::filesystem::path& path) {
  return parse_json(read_plain_text(path), path);
}

std::string json_text(const nlohmann::json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string json_text(const nlohmann::ordered_json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::optional<double> finite_number(const nlohmann::json& object, const char* key,
                                    const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return std::nullopt;
  if (!found->is_number() || !std::isfinite(found->get<double>()))
    throw InputError(fmt::format("{}: {} is {}, expected a finite number; correct it", where, key,
                                 found->is_null() ? "NaN, infinite or null" : found->type_name()));
  return found->get<double>();
}

std::string string_at(const nlohmann::json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  if (!found->is_string())
    throw InputError(
        fmt::format("{}: {} is a {}, expected text; correct it", where, key, found->type_name()));
  return found->get<std::string>();
}

}  // namespace tessera
