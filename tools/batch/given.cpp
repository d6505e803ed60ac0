// Types and ranges.
#include "tools/batch/given.h"

#include <fmt/format.h>

#include <algorithm>

#include "kernels/base/errors.h"
#include "recon4d/options/nearest_name.h"
#include "tools/batch/captures.h"
#include "tools/cli/argument_words.h"

namespace tessera {

using nlohmann::json;

void check_known(const std::string& name, const std::vector<std::string>& known,
                 const std::string& what) {
  if (std::find(known.begin(), known.end(), name) == known.end())
    throw InputError(fmt::format("{} '{}'{}", what, name, known_names(name, known)));
}

void check_keys(const json& given, const std::vector<std::string>& known,
                const std::string& where) {
  for (const auto& [key, value] : given.items()) check_known(key, known, where + ": unknown key");
}

std::string checked_name(const std::string& name, const std::string& where) {
  if (safe_name(name) != name)
    throw InputError(
        fmt::format("{}: '{}' cannot name a folder of results; give a `name` of letters, digits "
                    "and _ . + -",
                    where, name));
  return name;
}

namespace {

int64_t whole_number(const json& value, const char* key, int64_t least) {
  if (!value.is_number_integer() || value.get<int64_t>() < least)
    throw InputError(fmt::format("{}: {} is no whole number from {}", key, value.dump(), least));
  return value.get<int64_t>();
}

}  // namespace

json list_at(const json& given, const char* key, json otherwise) {
  const json values = given.value(key, json());
  if (values.is_null()) return otherwise;
  if (!values.is_array() || values.empty())
    throw InputError(
        fmt::format("{}: expected a list with something in it, not {}; write {}: [a, b]", key,
                    values.dump(), key));
  return values;
}

std::vector<int64_t> numbers_at(const json& given, const char* key, int64_t least, json otherwise) {
  std::vector<int64_t> numbers;
  for (const json& value : list_at(given, key, std::move(otherwise)))
    numbers.push_back(whole_number(value, key, least));
  refuse_repeats(numbers, key);
  return numbers;
}

std::vector<std::string> names_at(const json& given, const char* key, json otherwise) {
  std::vector<std::string> names;
  for (const json& value : list_at(given, key, std::move(otherwise))) {
    if (!value.is_string())
      throw InputError(fmt::format("{}: {} is no name; write {}: [a, b]", key, value.dump(), key));
    names.push_back(value.get<std::string>());
  }
  refuse_repeats(names, key);
  return names;
}

int64_t number_of(const json& given, const char* key, int64_t least, int64_t otherwise) {
  return whole_number(given.value(key, json(otherwise)), key, least);
}

std::string text_of_value(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace tessera
