// The glTF 2.0 binary file with KHR_gaussian_splatting: one primitive of points in floats, with
// accessors over one buffer, in a left-up-front world. Source: formats 1.7 (Khronos, ratified),
// written from its layout.
#include "static3d/formats/splat_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

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

/// The buffer as it grows, with a view and an accessor for each column.
class GlbColumns {
 public:
  explicit GlbColumns(const GaussianSpans<const float>& set) : set_(set) {}

  /// Floats of every Gaussian as attribute `name`.
  void add_floats(const std::string& name, int width,
                  const std::function<void(int64_t, float*)>& row) {
    begin(name, width, kFloat);
    std::vector<float> values(static_cast<size_t>(width));
    for (int64_t n = 0; n < set_.count; ++n) {
      row(n, values.data());
      for (const float value : values) append(buffer_, value);
    }
    end();
  }

  /// What programs without the extension show.
  void add_colours() {
    begin("COLOR_0", 4, kByte);
    accessors_.back()["normalized"] = true;
    for (int64_t n = 0; n < set_.count; ++n) {
      for (int c = 0; c < 3; ++c)
        append(buffer_, byte_of(255 * (0.5 + kSh0 * double(set_.at(kSh, n)[c]))));
      append(buffer_, opacity_byte(*set_.at(kOpacityLogit, n)));
    }
    end();
  }

  /// glTF requires the bounds of positions.
  void bound_positions() {
    json low = json::array(), high = json::array();
    for (int k = 0; k < 3; ++k) {
      float a = INFINITY, b = -INFINITY;
      for (int64_t n = 0; n < set_.count; ++n) {
        a = std::min(a, set_.at(kMean, n)[k]);
        b = std::max(b, set_.at(kMean, n)[k]);
      }
      low.push_back(set_.count > 0 ? a : 0);
      high.push_back(set_.count > 0 ? b : 0);
    }
    json& position = accessors_[attributes_["POSITION"].get<size_t>()];
    position["min"] = low;
    position["max"] = high;
  }

  const std::string& buffer() const { return buffer_; }
  json document() const;

 private:
  void begin(const std::string& name, int width, int component) {
    static const std::array<const char*, 4> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    attributes_[name] = accessors_.size();
    accessors_.push_back({{"bufferView", views_.size()},
                          {"componentType", component},
                          {"count", set_.count},
                          {"type", kTypes[size_t(width - 1)]}});
    views_.push_back({{"buffer", 0}, {"byteOffset", buffer_.size()}});
  }
  void end() {
    json& view = views_.back();
    view["byteLength"] = buffer_.size() - view["byteOffset"].get<size_t>();
  }

  const GaussianSpans<const float>& set_;
  std::string buffer_;
  json attributes_ = json::object(), accessors_ = json::array(), views_ = json::array();
};

json GlbColumns::document() const {
  const json splatting = {{"kernel", "ellipse"},
                          {"colorSpace", "srgb_rec709_display"},
                          {"projection", "perspective"},
                          {"sortingMethod", "cameraDistance"}};
  return {{"asset", {{"version", "2.0"}, {"generator", "tessera"}}},
          {"extensionsUsed", {kGlbExtension}},
          {"scene", 0},
          {"scenes", {{{"nodes", {0}}}}},
          {"nodes", {{{"mesh", 0}}}},
          {"meshes",
           {{{"primitives",
              {{{"mode", 0},
                {"attributes", attributes_},
                {"extensions", {{kGlbExtension, splatting}}}}}}}}},
          {"accessors", accessors_},
          {"bufferViews", views_},
          {"buffers", {{{"byteLength", buffer_.size()}}}}};
}

void add_columns(GlbColumns& columns, const GaussianSpans<const float>& set, int sh_degree) {
  const auto copy = [&](Group group, int from, int count) {
    return [&set, group, from, count](int64_t n, float* to) {
      std::copy_n(set.at(group, n) + from, count, to);
    };
  };
  columns.add_floats("POSITION", 3, copy(kMean, 0, 3));
  columns.bound_positions();
  columns.add_colours();
  columns.add_floats(kGlbExtension + ":ROTATION", 4, [&](int64_t n, float* to) {
    const float* const q = set.at(kRotation, n);
    for (int k = 0; k < 4; ++k) to[k] = q[(k + 1) % 4];  // x, y, z, w
  });
  columns.add_floats(kGlbExtension + ":SCALE", 3, [&](int64_t n, float* to) {
    for (int k = 0; k < 3; ++k) to[k] = std::exp(set.at(kLogScale, n)[k]);
  });
  columns.add_floats(kGlbExtension + ":OPACITY", 1,
                     [&](int64_t n, float* to) { *to = sigmoid(*set.at(kOpacityLogit, n)); });
  for (int degree = 0, i = 0; degree <= sh_degree; ++degree)
    for (int m = 0; m <= 2 * degree; ++m, ++i)
      columns.add_floats(fmt::format("{}:SH_DEGREE_{}_COEF_{}", kGlbExtension, degree, m), 3,
                         copy(kSh, 3 * i, 3));
}

void append_chunk(std::string& bytes, std::string_view content, const char* type, char padding) {
  const size_t padded = (content.size() + 3) / 4 * 4;
  append(bytes, uint32_t(padded));
  bytes.append(type, 4).append(content).append(padded - content.size(), padding);
}

}  // namespace

void save_glb(const std::filesystem::path& path, const GaussianSet& set, int sh_degree) {
  GaussianSet flipped = set.clone_values();
  flip_axes(flipped, kLeftUpFront);
  const GaussianSpans<const float> values = std::as_const(flipped).values();
  GlbColumns columns(values);
  add_columns(columns, values, sh_degree);
  if (columns.buffer().size() > UINT32_MAX - (uint32_t{1} << 20))
    throw InputError(fmt::format("{}: {} Gaussians are more than one .glb holds; export as ply",
                                 path.string(), set.count()));
  std::string chunks;
  append_chunk(chunks, columns.document().dump(), "JSON", ' ');
  append_chunk(chunks, columns.buffer(), "BIN\0", '\0');
  std::string file = "glTF";
  append(file, uint32_t{2});
  append(file, uint32_t(12 + chunks.size()));
  write_text_file(path, file + chunks);
}

}  // namespace tessera
