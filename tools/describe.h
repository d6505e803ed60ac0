// What: what a file or folder is and what it holds, as JSON: the facts of `tessera info`.
// Not: text for people (cmd_info.cpp).
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>

namespace tessera {

/// `kind` and `path`, then what belongs to that kind. Errors: InputError: missing, damaged, or
/// nothing that is known.
nlohmann::json describe(const std::filesystem::path& path);

/// Of a folder with transforms files, or with videos.
nlohmann::json describe_transforms(const std::filesystem::path& folder);
nlohmann::json describe_videos(const std::filesystem::path& folder);

}  // namespace tessera
