// Values of an object that may have been written by hand, with errors that name key and remedy.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera {

/// Errors: InputError naming the first key that is not known.
void check_keys(const nlohmann::json& given, const std::vector<std::string>& known,
                const std::string& where);
/// Errors: InputError: not one of `known`.
void check_known(const std::string& name, const std::vector<std::string>& known,
                 const std::string& what);
/// Results are named by it. Errors: InputError.
std::string checked_name(const std::string& name, const std::string& where);

/// A list with something in it, or the default where the key is not there. Errors: InputError.
nlohmann::json list_at(const nlohmann::json& given, const char* key, nlohmann::json otherwise);
/// Without repeats. Errors: InputError.
std::vector<int64_t> numbers_at(const nlohmann::json& given, const char* key, int64_t least,
                                nlohmann::json otherwise);
std::vector<std::string> names_at(const nlohmann::json& given, const char* key,
                                  nlohmann::json otherwise);
int64_t number_of(const nlohmann::json& given, const char* key, int64_t least, int64_t otherwise);
/// A text, number or truth value as it is typed.
std::string text_of_value(const nlohmann::json& value);

}  // namespace tessera
