// What: 64-bit FNV-1a of files, so a prepared scene says which bytes it was made of.
// Not: cryptographic; it notices change, not malice.
#pragma once
#include <filesystem>
#include <string>

namespace tessera {

/// 16 hexadecimal digits. Errors: InputError when the file cannot be read.
std::string source_hash(const std::filesystem::path& file);

}  // namespace tessera
