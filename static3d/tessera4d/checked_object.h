// An object of a manifest whose values are checked as they are read: errors name the file, the
// object, what is wrong and the remedy.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "kernels/base/errors.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {

/// One object of the manifest, read with errors that name it.
class CheckedObject {
 public:
  CheckedObject(const nlohmann::json& object, const std::filesystem::path& path, std::string what)
      : object_(object), path_(path), what_(std::move(what)) {
    if (!object.is_object()) fail("is no object");
  }

  [[noreturn]] void fail(const std::string& wrong) const {
    throw InputError(
        fmt::format("{}: {} {}; fetch or export it again", path_.string(), what_, wrong));
  }
  const nlohmann::json& at(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) fail(fmt::format("has no '{}'", key));
    return *found;
  }
  bool has(const char* key) const { return object_.contains(key) && !object_[key].is_null(); }
  double number(const char* key) const { return number_of(at(key), key); }
  double number_or(const char* key, double otherwise) const {
    return has(key) ? number(key) : otherwise;
  }
  uint64_t whole(const char* key, uint64_t most) const {
    const nlohmann::json& value = at(key);
    if (!value.is_number_unsigned() || value.get<uint64_t>() > most)
      fail(fmt::format("has '{}' {}, expected a whole number up to {}", key, shown(value), most));
    return value.get<uint64_t>();
  }
  std::string text(const char* key) const {
    const nlohmann::json& value = at(key);
    if (!value.is_string()) fail(fmt::format("has a '{}' that is no text", key));
    return value.get<std::string>();
  }
  bool flag_or(const char* key, bool otherwise) const {
    if (!has(key)) return otherwise;
    if (!at(key).is_boolean()) fail(fmt::format("has a '{}' that is neither true nor false", key));
    return at(key).get<bool>();
  }
  std::vector<double> numbers(const char* key, size_t count) const {
    const nlohmann::json& list = at(key);
    if (!list.is_array() || list.size() != count)
      fail(fmt::format("has '{}' {}, expected {} numbers", key, shown(list), count));
    std::vector<double> values;
    for (const nlohmann::json& value : list) values.push_back(number_of(value, key));
    return values;
  }
  Interval interval(const char* key) const {
    const std::vector<double> ends = numbers(key, 2);
    return {ends[0], ends[1]};
  }
  const nlohmann::json& list(const char* key) const {
    if (!at(key).is_array()) fail(fmt::format("has a '{}' that is no list", key));
    return at(key);
  }
  const std::filesystem::path& path() const { return path_; }
  /// The beginning of a value, for a message.
  static std::string shown(const nlohmann::json& value) { return value.dump().substr(0, 40); }

 private:
  double number_of(const nlohmann::json& value, const char* key) const {
    if (!value.is_number() || !std::isfinite(value.get<double>()))
      fail(fmt::format("has '{}' {}, expected a finite number", key, shown(value)));
    return value.get<double>();
  }

  const nlohmann::json& object_;
  const std::filesystem::path& path_;
  std::string what_;
};

}  // namespace tessera
