// What: the check that a path given as a folder is one.
// Not: what is in it.
#pragma once
#include <filesystem>

namespace tessera {

/// Errors: InputError: nothing is at `path`, or a file.
void require_folder(const std::filesystem::path& path);

}  // namespace tessera
