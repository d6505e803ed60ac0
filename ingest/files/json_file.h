// Reads a JSON file as a tree, and single values with checks of their types. The NaN and Infinity
// of Python, which JSON lacks, are read as null.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace tessera {

/// JSON text of a file. Errors: InputError naming file and position: malformed, nested deeper than
/// 100 levels.
nlohmann::json parse_json(std::string text, const std::filesystem::path& path);
/// The same of a whole file. Errors: as above, and missing, unreadable.
nlohmann::json read_json(const std::filesystem::path& path);

/// Text of a file or of what a program prints: bytes of names that are no UTF-8 become U+FFFD.
/// `indent`: −1: one line.
std::string json_text(const nlohmann::json& value, int indent = -1);
std::string json_text(const nlohmann::ordered_json& value, int indent = -1);

/// The number at `key`, nothing where there is no such key. Errors: InputError that starts with
/// `where` when the value is not a finite number.
std::optional<double> finite_number(const nlohmann::json& object, const char* key,
                                    const std::string& where);
/// The string at `key`, or "" where there is none. Errors: InputError when it is no string.
std::string string_at(const nlohmann::json& object, const char* key, const std::string& where);

}  // namespace tessera
