// Decoding of the streams of a block to Gaussians; every value is checked before it is used.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "ingest/files/gzip.h"
#include "kernels/base/errors.h"
#include "static3d/tessera4d/block.h"
#include "static3d/tessera4d/node_streams.h"
#include "static3d/tessera4d/stream.h"
#include "static3d/transform/splat_quanta.h"

namespace tessera {
namespace {

class Decoder {
 public:
  Decoder(std::string_view bytes, const BlockInfo& info, const std::filesystem::path& path)
      : bytes_(bytes), info_(info), path_(path) {}

  GaussianSet decode(int sh_degree, bool anchor_in_clip) const {
    const StreamWords position = needed("position", 3);  // no room for what is not there
    const SetForm form = info_.moving      ? SetForm::kVelocity
                         : info_.nodes > 0 ? SetForm::kCanonical
                                           : SetForm::kStatic;
    GaussianSet set(form, sh_coefficients(sh_degree));
    set.resize(info_.count);
    const GaussianSpans<float> to = set.values();
    fill(position, to, kMean);
    fill(needed("log_scale", 3), to, kLogScale);
    fill_rotation(to);
    fill_opacity(to);
    std::fill_n(to.group[kSh].data, to.group[kSh].size, 0.0f);
    fill(needed(kShNames[0], 3), to, kSh);
    for (int degree = 1; degree <= sh_degree; ++degree)
      if (find(kShNames[degree]) != nullptr)
        fill(read(kShNames[degree], band_width(degree)), to, kSh, band_begin(degree));
    if (info_.moving) fill_motion(to, anchor_in_clip);
    if (info_.nodes > 0) fill_bindings(to);
    return set;
  }
  MotionNodes decode_nodes() const {
    NodeStreams streams{read("node_position", 3), read("node_translation", 3),
                        read("node_rotation", 4)};
    std::optional<StreamWords> log_radius;
    if (find("node_log_radius") != nullptr) log_radius = read("node_log_radius", 1);
    streams.log_radius = log_radius ? &*log_radius : nullptr;
    return nodes_from(streams, info_.nodes, info_.knots, path_);
  }

 private:
  const StreamInfo* find(const char* name) const {
    for (const StreamInfo& stream : info_.streams)
      if (stream.name == name) return &stream;
    return nullptr;
  }
  StreamWords read(const char* name, int components) const {
    const StreamInfo* const stream = find(name);
    if (stream == nullptr || stream->components != components)
      throw InputError(fmt::format("{}: has no stream '{}' of {} components; export it again",
                                   path_.string(), name, components));
    if (const int64_t rows = node_rows(name, info_.nodes, info_.knots); rows > 0)
      check_rows(*stream, rows);
    return read_stream(bytes_, *stream, path_);
  }
  void check_rows(const StreamInfo& stream, int64_t rows) const {
    if (stream.count != rows)
      throw InputError(fmt::format("{}: stream '{}' has {} rows in place of {}; export it again",
                                   path_.string(), stream.name, stream.count, rows));
  }
  /// One number of every Gaussian.
  StreamWords needed(const char* name, int components) const {
    StreamWords stream = read(name, components);
    check_rows(stream.info, info_.count);
    return stream;
  }
  static void fill(const StreamWords& stream, const GaussianSpans<float>& to, Group group,
                   int first = 0) {
    for (int c = 0; c < stream.info.components; ++c)
      for (int64_t n = 0; n < stream.info.count; ++n)
        to.at(group, n)[first + c] = value_at(stream, c, n);
  }
  void fill_rotation(const GaussianSpans<float>& to) const {
    const StreamInfo* const info = find("rotation");
    if (info != nullptr && info->components == 4) return fill(needed("rotation", 4), to, kRotation);
    const StreamWords smaller = needed("rotation", 3), largest = needed("rotation_largest", 1);
    for (int64_t n = 0; n < info_.count; ++n) {
      const int top = std::clamp(int(value_at(largest, 0, n)), 0, 3);
      std::array<double, 4> q{};
      int c = 0;
      for (int k = 0; k < 4; ++k)
        if (k != top) q[size_t(k)] = double(value_at(smaller, c++, n));
      q[size_t(top)] = left_out(q, top);
      for (size_t k = 0; k < 4; ++k) to.at(kRotation, n)[k] = float(q[k]);
    }
  }
  void fill_opacity(const GaussianSpans<float>& to) const {
    if (find("opacity_logit") != nullptr)
      return fill(needed("opacity_logit", 1), to, kOpacityLogit);
    const StreamWords stream = needed("opacity", 1);
    for (int64_t n = 0; n < info_.count; ++n)
      *to.at(kOpacityLogit, n) = logit_of_byte(255 * double(value_at(stream, 0, n)));
  }
  void fill_bindings(const GaussianSpans<float>& to) const {
    const bool has_logits = find("node_logit") != nullptr;
    read_bindings(
        needed("node", kBindings),
        has_logits ? needed("node_logit", kBindings) : needed("node_weight", kBindings - 1),
        info_.nodes, to, path_);
  }
  void fill_motion(const GaussianSpans<float>& to, bool anchor_in_clip) const {
    fill(needed("velocity", 3), to, kVelocity);
    fill(needed("time_mean", 1), to, kMeanTime);
    fill(needed("log_time_scale", 1), to, kLogScaleTime);
    if (!anchor_in_clip) return;
    for (int64_t n = 0; n < info_.count; ++n) {
      const float time = *to.at(kMeanTime, n), anchor = std::clamp(time, 0.0f, 1.0f);
      for (int k = 0; k < 3; ++k) to.at(kMean, n)[k] += to.at(kVelocity, n)[k] * (time - anchor);
    }
  }

  std::string_view bytes_;
  const BlockInfo& info_;
  const std::filesystem::path& path_;
};

}  // namespace

void check_block(std::string_view bytes, const BlockInfo& info, const std::filesystem::path& path) {
  if (bytes.size() != info.bytes)
    throw InputError(fmt::format("{}: has {} bytes, its manifest says {}; fetch or export it again",
                                 path.string(), bytes.size(), info.bytes));
  if (crc32_of(bytes) != info.crc32)
    throw InputError(
        fmt::format("{}: its checksum differs from the manifest's: it is damaged or of another "
                    "export; fetch or export it again",
                    path.string()));
}

GaussianSet decode_block(std::string_view bytes, const BlockInfo& info, int sh_degree,
                         bool anchor_in_clip, const std::filesystem::path& path,
                         MotionNodes* nodes) {
  check_block(bytes, info, path);
  BlockInfo known = info;
  if (info.head > 0) known.streams = streams_of_head(bytes, info, path);
  const Decoder decoder(bytes.substr(info.head), known, path);
  if (nodes != nullptr && info.nodes > 0) *nodes = decoder.decode_nodes();
  return decoder.decode(sh_degree, anchor_in_clip);
}

}  // namespace tessera
