// A Tessera 4D file as it lies on the disk, folder or single file: its manifest, and the bytes of a
// block when they are asked for. Source: docs/reference/tessera4d.md, section 2.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/manifest.h"

namespace tessera {

class Tessera4dContainer {
 public:
  /// Reads and checks the manifest. Errors: InputError naming the file, what is wrong, the remedy.
  explicit Tessera4dContainer(const std::filesystem::path& path);

  const nlohmann::json& json() const { return json_; }
  const Tessera4dManifest& manifest() const { return manifest_; }
  /// Of no Gaussians: how they are drawn, their SH degree and the clock of the clip.
  const GaussianModel& rules() const { return rules_; }
  /// What errors name: the manifest of a folder, or the single file.
  const std::filesystem::path& path() const { return path_; }
  /// Of manifest and blocks.
  int64_t bytes() const;

  /// The file that has the block, and its bytes, which are not checked yet. Errors: InputError
  /// naming the file.
  std::filesystem::path file_of(const BlockInfo& block) const;
  std::string block(const BlockInfo& block) const;

 private:
  void open_folder(const std::filesystem::path& folder);
  void open_single();

  std::filesystem::path path_;
  bool is_folder_;
  uint64_t first_ = 0;  // bytes in front of the blocks: of a folder, of the manifest
  nlohmann::json json_;
  Tessera4dManifest manifest_;
  GaussianModel rules_;
};

}  // namespace tessera
