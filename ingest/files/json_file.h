// What: a JSON file as a tree; Python's NaN and Infinity, which JSON lacks, are read as null.
// Not: a schema; readers look at each value through `finite_number` and friends.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace tessera {

/// Errors: InputError naming file and position: missing, unreadable, malformed.
nlohmann::json read_json(const std::filesystem::path& path);

/// The number at `key`, nothing where there is no such key. Errors: InputError that starts with
/// `where` when the value is not a finite number.
std::optional<double> finite_number(const nlohmann::json& object, const char* key,
                                    const std::string& where);
/// The string at `key`, or "" where there is none. Errors: InputError when it is no string.
std::string string_at(const nlohmann::json& object, const char* key, const std::string& where);

}  // namespace tessera
