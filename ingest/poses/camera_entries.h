// Finds the cameras in a JSON tree: a list or an object of cameras, one camera alone, or keys with
// the name of a camera behind them, as in intri.yml and extri.yml of EasyMocap.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tessera {

struct CameraEntry {
  std::string name;
  std::string where;  // "cameras.json, camera 2 (cam02)", for messages
  nlohmann::json values;
};

struct CameraEntries {
  std::vector<CameraEntry> entries;  // in the order of the file
  nlohmann::json shared;             // what the file states of all of them
};

/// The cameras of `file`:
/// - those of its list or object `cameras` or `frames`, or of a list that the file is, called
///   `name` (in an object: its key), else by the camera of a prepared scene, else by `file_path`
///   without extension; what stands beside them, and in an object `intrinsics`, holds for all;
/// - K_NAME, Rot_NAME or R_NAME, T_NAME and others that end with the same NAME;
/// - one camera, called `name`, else as the file without extension;
/// - the members of an object of cameras, called by their keys.
/// `path` is for messages and the name. Errors: InputError naming the file: none of these, an entry
/// that is no object.
CameraEntries camera_entries(const nlohmann::json& file, const std::filesystem::path& path);

}  // namespace tessera
