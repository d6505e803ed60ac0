// Reads what cv::FileStorage has written (YAML or XML) as a JSON tree.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace tessera {

/// Maps become objects, sequences lists, and matrices objects with rows, cols and data. Errors:
/// InputError naming the file: missing, larger than 16 MiB, not of this form, nested deeper than 20
/// levels.
nlohmann::json read_opencv_tree(const std::filesystem::path& file);

}  // namespace tessera
