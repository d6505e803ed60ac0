// Files of a capture that seem to be a calibration and are not used.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

/// Adds one line that names the files directly in `capture` that seem to state cameras and are none
/// of `known`: JSON, YAML and XML by their names, tables and XML of RealityScan and Metashape by
/// what they begin with. It says which `--poses` would read, and how to have the others read. No
/// line where there are none. transforms*.json is not looked at. Errors: none.
void note_unused_calibration(const std::filesystem::path& capture,
                             const std::vector<std::filesystem::path>& known,
                             std::vector<std::string>& warnings);

}  // namespace tessera
