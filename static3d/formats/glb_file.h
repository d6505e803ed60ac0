// A glTF 2.0 binary file as it grows: accessors over one buffer, meshes of Gaussians with
// KHR_gaussian_splatting, nodes and animations. Source: formats 1.7 (Khronos, ratified), written
// from its layout.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"

namespace tessera {

class GlbFile {
 public:
  /// [count, width] floats as an accessor, whose index is returned. `bounds`: with the least and
  /// the largest value of each column, which glTF requires of positions and of keyframe times.
  size_t add_floats(const std::vector<float>& values, int width, bool bounds);
  /// A mesh of one primitive: the Gaussians of a static set, turned into the left-up-front world.
  /// Returns its index.
  size_t add_mesh(const GaussianSet& set, int sh_degree);
  /// Returns its index; node 0 is the root of the scene.
  size_t add_node(nlohmann::json node);
  nlohmann::json& node(size_t index) { return nodes_[index]; }
  /// `channels` and `samplers`, as glTF has them.
  void set_animation(nlohmann::json animation) { animation_ = std::move(animation); }

  /// Returns the bytes written. Errors: InputError: more bytes than 32 bits count.
  int64_t save(const std::filesystem::path& path) const;

 private:
  size_t add_accessor(int width, int component, int64_t count);
  void end_accessor();
  size_t add_colours(const GaussianSpans<const float>& set);
  nlohmann::json document() const;

  std::string buffer_;
  nlohmann::json accessors_ = nlohmann::json::array(), views_ = nlohmann::json::array(),
                 meshes_ = nlohmann::json::array(), nodes_ = nlohmann::json::array(), animation_;
  int64_t gaussians_ = 0;
};

}  // namespace tessera
