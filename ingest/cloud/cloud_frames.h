// The training frames of which a cloud is made, timestep by timestep: of a folder whose json is
// read once, or of a scene in memory, none of whose files is read again.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "ingest/prepared/scene_reader.h"
#include "ingest/scene.h"

namespace tessera {

class CloudFrames {
 public:
  virtual ~CloudFrames() = default;
  /// The whole clip, whose frames have no pixels.
  virtual const Scene& listed() const = 0;
  /// The training frames of these timesteps, by Frame::timestep, with pixels.
  virtual Scene at(const std::vector<int64_t>& timesteps) const = 0;
};

/// Of a folder that load_scene can read, or of a window of it, on black.
class FolderFrames : public CloudFrames {
 public:
  /// Errors: as load_scene.
  explicit FolderFrames(const std::filesystem::path& folder,
                        const std::optional<Window>& window = {});
  const Scene& listed() const override { return listed_; }
  Scene at(const std::vector<int64_t>& timesteps) const override;

 private:
  SceneFiles files_;
  Scene listed_;
};

/// Copies of the frames, and of nothing else, of a scene, which must outlive this and have the
/// pixels of its training frames. Frames for validation count as training frames, which they are in
/// the files.
class SceneFrames : public CloudFrames {
 public:
  explicit SceneFrames(const Scene& scene);
  const Scene& listed() const override { return listed_; }
  Scene at(const std::vector<int64_t>& timesteps) const override;

 private:
  const Scene& scene_;
  Scene listed_;
};

}  // namespace tessera
