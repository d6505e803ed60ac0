// Reads glTF 2.0 binary files whose primitives have KHR_gaussian_splatting, as floats or normalised
// integers. Compressed ones are named. Source: formats 1.7 (Khronos, ratified): linear scales; the
// drafts before it had logarithms, which negative numbers tell.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"
#include "static3d/formats/splat_formats.h"
#include "static3d/transform/world_change.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr float kLeastScale = 1e-12f;

/// The chunks of a file, and lookups that name what is wrong.
class GlbFile {
 public:
  GlbFile(std::string_view file, const std::filesystem::path& path) : path_(path) {
    ByteReader bytes(file, path);
    bytes.number<uint32_t>();  // the magic number, by which the file was known
    if (bytes.number<uint32_t>() != 2) fail("it is not of glTF 2.0");
    bytes.number<uint32_t>();
    while (bytes.left() >= 8) {
      const auto length = bytes.number<uint32_t>(), type = bytes.number<uint32_t>();
      const std::string_view chunk = bytes.take(length);
      if (type == 0x4E4F534A) document_ = parse_json(std::string(chunk), path);
      if (type == 0x004E4942) buffer_ = chunk;
    }
    if (!document_.is_object()) fail("it has no JSON chunk");
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}: {}; export it again as .ply or .glb", path_.string(), what));
  }
  const json& list(const char* key) const {
    const auto found = document_.find(key);
    if (found == document_.end() || !found->is_array()) fail(fmt::format("it has no {}", key));
    return *found;
  }
  const json& entry(const char* key, const json& index) const {
    const json& entries = list(key);
    if (!index.is_number_unsigned() || index.get<size_t>() >= entries.size() ||
        !entries[index.get<size_t>()].is_object())
      fail(fmt::format("it names an entry of {} that is not there", key));
    return entries[index.get<size_t>()];
  }
  size_t number(const json& object, const char* key, size_t absent) const {
    const auto found = object.find(key);
    if (found == object.end()) return absent;
    if (!found->is_number_unsigned() || found->get<uint64_t>() > UINT32_MAX)
      fail(fmt::format("'{}' is no number", key));
    return found->get<size_t>();
  }
  const json& document() const { return document_; }
  std::string_view buffer() const { return buffer_; }

 private:
  std::filesystem::path path_;
  json document_;
  std::string_view buffer_;
};

/// A number of glTF's component types, normalised integers as fractions.
float component(const char* bytes, size_t type) {
  const auto as = [&]<class T>(T value) {
    std::memcpy(&value, bytes, sizeof value);
    return value;
  };
  switch (type) {
    case 5120:
      return std::max(float(as(int8_t{})) / 127, -1.0f);
    case 5121:
      return float(as(uint8_t{})) / 255;
    case 5122:
      return std::max(float(as(int16_t{})) / 32767, -1.0f);
    case 5123:
      return float(as(uint16_t{})) / 65535;
    default:
      return as(float{});
  }
}

/// [count, width]
std::vector<float> values_of(const GlbFile& file, const json& index, size_t width, size_t count) {
  const json& accessor = file.entry("accessors", index);
  const size_t type = file.number(accessor, "componentType", 0);
  const size_t bytes = type == 5126 ? 4 : type == 5122 || type == 5123 ? 2 : 1;
  if (type < 5120 || type > 5126 || type == 5124 || type == 5125 || accessor.contains("sparse"))
    file.fail("an accessor is neither of floats nor of normalised integers");
  static const std::array<const char*, 4> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  if (accessor.value("type", json()) != kTypes[width - 1] ||
      file.number(accessor, "count", 0) != count)
    file.fail(fmt::format("an attribute is not of {} {}", count, kTypes[width - 1]));
  const json& view = file.entry("bufferViews", accessor.value("bufferView", json()));
  const size_t begin = file.number(view, "byteOffset", 0) + file.number(accessor, "byteOffset", 0);
  const size_t stride = file.number(view, "byteStride", bytes * width);
  const size_t end = count == 0 ? begin : begin + (count - 1) * stride + bytes * width;
  if (file.number(view, "buffer", 0) != 0 || end > file.buffer().size())
    file.fail("an attribute lies beyond its BIN chunk");
  std::vector<float> values;
  for (size_t n = 0; n < count; ++n)
    for (size_t k = 0; k < width; ++k)
      values.push_back(component(file.buffer().data() + begin + n * stride + k * bytes, type));
  return values;
}

/// The primitives of splats.
std::vector<json> splats_in(const GlbFile& file) {
  std::vector<json> found;
  for (const json& mesh : file.list("meshes")) {
    if (!mesh.is_object() || !mesh.contains("primitives")) continue;
    for (const json& primitive : mesh["primitives"]) {
      const json extensions =
          primitive.is_object() ? primitive.value("extensions", json()) : json();
      if (!extensions.is_object() || !extensions.contains(kGlbExtension)) continue;
      const json inner = extensions[kGlbExtension].is_object()
                             ? extensions[kGlbExtension].value("extensions", json::object())
                             : json::object();
      if (inner.is_object() && !inner.empty())
        file.fail(
            fmt::format("its splats are compressed by {}, which is not read", inner.begin().key()));
      if (!primitive.value("attributes", json()).is_object()) file.fail("a primitive is empty");
      found.push_back(primitive["attributes"]);
    }
  }
  if (found.empty()) file.fail("no primitive of it has KHR_gaussian_splatting");
  if (found.size() > 1) file.fail("it has several primitives of splats, and one is read");
  return found;
}

bool has_moved_nodes(const GlbFile& file) {
  const json nodes = file.document().value("nodes", json::array());
  return std::any_of(nodes.begin(), nodes.end(), [](const json& node) {
    return node.contains("matrix") || node.contains("translation") || node.contains("rotation") ||
           node.contains("scale");
  });
}

float logit_of(float opacity) {
  constexpr float kEnd = 1e-6f;
  const float inside = std::clamp(opacity, kEnd, 1 - kEnd);
  return std::log(inside / (1 - inside));
}

}  // namespace

bool is_glb(std::string_view head) {
  return head.starts_with("glTF");
}

SplatFile load_glb(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  const GlbFile file(bytes, path);
  const json attributes = splats_in(file).front();
  const auto index = [&](const std::string& name) { return attributes.value(name, json()); };
  const json& positions = file.entry("accessors", index("POSITION"));
  const size_t count = file.number(positions, "count", 0);
  if (count > bytes.size()) file.fail("it has more splats than bytes");
  const auto column = [&](const std::string& name, size_t width) {
    if (!attributes.contains(name)) file.fail(fmt::format("its splats have no {}", name));
    return values_of(file, index(name), width, count);
  };
  const auto sh_name = [](int degree, int m) {
    return fmt::format("{}:SH_DEGREE_{}_COEF_{}", kGlbExtension, degree, m);
  };
  int degree = 0;
  while (degree < kMaxShDegree && attributes.contains(sh_name(degree + 1, 0))) ++degree;
  SplatFile result;
  result.set = GaussianSet(SetForm::kStatic, sh_coefficients(degree));
  result.set.resize(int64_t(count));
  const GaussianSpans<float> to = result.set.values();
  const std::vector<float> means = column("POSITION", 3),
                           scales = column(kGlbExtension + ":SCALE", 3),
                           rotations = column(kGlbExtension + ":ROTATION", 4),
                           opacities = column(kGlbExtension + ":OPACITY", 1);
  const bool logarithms = std::any_of(scales.begin(), scales.end(), [](float s) { return s < 0; });
  for (size_t n = 0; n < count; ++n) {
    const auto row = int64_t(n);
    for (size_t k = 0; k < 3; ++k) {
      const float scale = scales[3 * n + k];
      to.at(kMean, row)[k] = means[3 * n + k];
      to.at(kLogScale, row)[k] = logarithms ? scale : std::log(std::max(scale, kLeastScale));
    }
    for (size_t k = 0; k < 4; ++k) to.at(kRotation, row)[(k + 1) % 4] = rotations[4 * n + k];
    *to.at(kOpacityLogit, row) = logit_of(opacities[n]);
  }
  for (int l = 0, i = 0; l <= degree; ++l)
    for (int m = 0; m <= 2 * l; ++m, ++i) {
      const std::vector<float> values = column(sh_name(l, m), 3);
      for (size_t n = 0; n < count; ++n)
        std::copy_n(values.data() + 3 * n, 3, to.at(kSh, int64_t(n)) + 3 * i);
    }
  flip_axes(result.set, kLeftUpFront);
  if (logarithms)
    result.warnings.push_back(fmt::format(
        "{}: scales are below 0, so they are read as logarithms, as drafts of the extension had "
        "them",
        path.string()));
  if (has_moved_nodes(file))
    result.warnings.push_back(
        fmt::format("{}: the transforms of its nodes are not applied", path.string()));
  return result;
}

}  // namespace tessera
