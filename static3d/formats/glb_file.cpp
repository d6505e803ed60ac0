// Columns of Gaussians as accessors, and the two chunks of the file.
#include "static3d/formats/glb_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"
#include "kernels/math/splat.h"
#include "static3d/transform/splat_quanta.h"
#include "static3d/transform/world_change.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kByte = 5121;  // component types of glTF
const std::string kExtension = "KHR_gaussian_splatting";

json bounds_of(const std::vector<float>& values, size_t width, bool largest) {
  json bounds = json::array();
  for (size_t k = 0; k < width; ++k) {
    float bound = values.empty() ? 0 : values[k];
    for (size_t i = k; i < values.size(); i += width)
      bound = largest ? std::max(bound, values[i]) : std::min(bound, values[i]);
    bounds.push_back(bound);
  }
  return bounds;
}

void append_chunk(std::string& bytes, std::string_view content, const char* type, char padding) {
  const size_t padded = (content.size() + 3) / 4 * 4;
  append(bytes, uint32_t(padded));
  bytes.append(type, 4).append(content).append(padded - content.size(), padding);
}

}  // namespace

size_t GlbFile::add_accessor(int width, int component, int64_t count) {
  static const std::array<const char*, 4> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  accessors_.push_back({{"bufferView", views_.size()},
                        {"componentType", component},
                        {"count", count},
                        {"type", kTypes[size_t(width - 1)]}});
  views_.push_back({{"buffer", 0}, {"byteOffset", buffer_.size()}});
  return accessors_.size() - 1;
}

void GlbFile::end_accessor() {
  json& view = views_.back();
  view["byteLength"] = buffer_.size() - view["byteOffset"].get<size_t>();
}

size_t GlbFile::add_floats(const std::vector<float>& values, int width, bool bounds) {
  const size_t index = add_accessor(width, kFloat, int64_t(values.size()) / width);
  for (const float value : values) append(buffer_, value);
  end_accessor();
  if (bounds) {
    accessors_[index]["min"] = bounds_of(values, size_t(width), false);
    accessors_[index]["max"] = bounds_of(values, size_t(width), true);
  }
  return index;
}

/// What programs without the extension show.
size_t GlbFile::add_colours(const GaussianSpans<const float>& set) {
  const size_t index = add_accessor(4, kByte, set.count);
  accessors_[index]["normalized"] = true;
  for (int64_t n = 0; n < set.count; ++n) {
    for (int c = 0; c < 3; ++c)
      append(buffer_, byte_of(255 * (0.5 + kSh0 * double(set.at(kSh, n)[c]))));
    append(buffer_, opacity_byte(*set.at(kOpacityLogit, n)));
  }
  end_accessor();
  return index;
}

size_t GlbFile::add_mesh(const GaussianSet& source, int sh_degree) {
  GaussianSet flipped = source.clone_values();
  flip_axes(flipped, kLeftUpFront);
  const GaussianSpans<const float> set = std::as_const(flipped).values();
  json attributes = json::object();
  const auto add = [&](const std::string& name, int width,
                       const std::function<void(int64_t, float*)>& row) {
    std::vector<float> values(size_t(set.count * width));
    for (int64_t n = 0; n < set.count; ++n) row(n, values.data() + n * width);
    attributes[name] = add_floats(values, width, name == "POSITION");
  };
  const auto copy = [&](Group group, int from, int count) {
    return [&set, group, from, count](int64_t n, float* to) {
      std::copy_n(set.at(group, n) + from, count, to);
    };
  };
  add("POSITION", 3, copy(kMean, 0, 3));
  attributes["COLOR_0"] = add_colours(set);
  add(kExtension + ":ROTATION", 4, [&](int64_t n, float* to) {
    const float* const q = set.at(kRotation, n);
    for (int k = 0; k < 4; ++k) to[k] = q[(k + 1) % 4];  // x, y, z, w
  });
  add(kExtension + ":SCALE", 3, [&](int64_t n, float* to) {
    for (int k = 0; k < 3; ++k) to[k] = std::exp(set.at(kLogScale, n)[k]);
  });
  add(kExtension + ":OPACITY", 1,
      [&](int64_t n, float* to) { *to = sigmoid(*set.at(kOpacityLogit, n)); });
  for (int degree = 0, i = 0; degree <= sh_degree; ++degree)
    for (int m = 0; m <= 2 * degree; ++m, ++i)
      add(fmt::format("{}:SH_DEGREE_{}_COEF_{}", kExtension, degree, m), 3, copy(kSh, 3 * i, 3));
  gaussians_ += set.count;
  const json splatting = {{"kernel", "ellipse"},
                          {"colorSpace", "srgb_rec709_display"},
                          {"projection", "perspective"},
                          {"sortingMethod", "cameraDistance"}};
  meshes_.push_back(
      {{"primitives",
        {{{"mode", 0}, {"attributes", attributes}, {"extensions", {{kExtension, splatting}}}}}}});
  return meshes_.size() - 1;
}

size_t GlbFile::add_node(nlohmann::json node) {
  nodes_.push_back(std::move(node));
  return nodes_.size() - 1;
}

json GlbFile::document() const {
  json document = {{"asset", {{"version", "2.0"}, {"generator", "tessera"}}},
                   {"scene", 0},
                   {"scenes", {{{"nodes", {0}}}}},
                   {"nodes", nodes_}};
  if (meshes_.empty()) return document;
  document["extensionsUsed"] = {kExtension};
  document["meshes"] = meshes_;
  document["accessors"] = accessors_;
  document["bufferViews"] = views_;
  document["buffers"] = {{{"byteLength", buffer_.size()}}};
  if (!animation_.is_null()) document["animations"] = json::array({animation_});
  return document;
}

int64_t GlbFile::save(const std::filesystem::path& path) const {
  if (buffer_.size() > UINT32_MAX - (uint32_t{1} << 24))
    throw InputError(fmt::format("{}: {} Gaussians are more than one .glb holds; export as ply",
                                 path.string(), gaussians_));
  std::string chunks;
  append_chunk(chunks, document().dump(), "JSON", ' ');
  if (!meshes_.empty()) append_chunk(chunks, buffer_, "BIN\0", '\0');
  std::string file = "glTF";
  append(file, uint32_t{2});
  append(file, uint32_t(12 + chunks.size()));
  file += chunks;
  write_text_file(path, file);
  return int64_t(file.size());
}

}  // namespace tessera
