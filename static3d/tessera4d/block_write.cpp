// Encoding of a block: the order of the Gaussians, the step of each stream, and its columns.
#include "static3d/tessera4d/block.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ingest/files/gzip.h"
#include "kernels/base/errors.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "recon4d/model/element_edits.h"
#include "static3d/tessera4d/node_streams.h"
#include "static3d/tessera4d/segments.h"
#include "static3d/tessera4d/stream.h"
#include "static3d/transform/scene_box.h"
#include "static3d/transform/splat_quanta.h"

namespace tessera {
namespace {

// Steps of docs/reference/tessera4d.md, section 5.
constexpr double kRotationStep = 1.0 / 2048, kScaleStep = 1.0 / 32, kColourStep = 1.0 / 128,
                 kTimeScaleStep = 1.0 / 64;
constexpr double kShStep[kMaxShDegree + 1] = {kColourStep, 1.0 / 64, 1.0 / 32, 1.0 / 32};
constexpr double kPositionShare = 1.0 / 20, kTimeShare = 1.0 / 50, kQuantile = 0.1;

/// The highest degree that is not all zeros once rounded.
int needed_degree(const float* sh, const BlockRules& rules) {
  for (int degree = rules.sh_degree; degree > 0; --degree)
    for (int i = 0; i < band_width(degree); ++i) {
      const double value = double(sh[band_begin(degree) + i]);
      if (rules.lossless ? value != 0 : std::round(value / kShStep[degree]) != 0) return degree;
    }
  return 0;
}

class Encoder {
 public:
  Encoder(const GaussianSet& set, const BlockRules& rules, const MotionNodes& nodes)
      : rules_(rules), nodes_(nodes) {
    const GaussianSpans<const float> values = set.values();
    std::vector<int64_t> order = morton_order(values);
    rules_.sh_degree = std::min(rules.sh_degree, degree_of(set));
    std::vector<int> degrees;
    for (int64_t n = 0; n < set.count(); ++n) {
      degrees.push_back(needed_degree(values.at(kSh, n), rules_));
      for (int degree = 1; degree <= degrees.back(); ++degree) ++sh_elements_[size_t(degree)];
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](int64_t a, int64_t b) { return degrees[size_t(a)] > degrees[size_t(b)]; });
    sorted_ = select_elements(set, order);
    position_step_ = position_step(std::as_const(sorted_).values());
    opacity_ = opacities();
    block_.info.moving = is_dynamic(set.form());
    block_.info.count = set.count();
    if (set.form() != SetForm::kCanonical) return;
    block_.info.nodes = nodes.count;
    block_.info.knots = nodes.knots;
  }

  Block encode() {
    if (block_.info.moving)
      add_moving();
    else
      add_position(column(kMean, 0, 3));
    add_shape();
    add_colour();
    if (block_.info.nodes > 0)
      for (StreamWords& stream : node_streams(sorted_, nodes_, position_step_, rules_.lossless))
        add(std::move(stream));
    pack();
    block_.info.bytes = block_.bytes.size();
    block_.info.crc32 = crc32_of(block_.bytes);
    return std::move(block_);
  }

 private:
  static int degree_of(const GaussianSet& set) {
    int degree = kMaxShDegree;
    while (sh_coefficients(degree) > set.coefficients()) --degree;
    return degree;
  }
  int64_t count() const { return sorted_.count(); }
  GaussianSpans<const float> values() const { return sorted_.values(); }

  /// [width, elements] of the first elements.
  std::vector<float> column(Group group, int first, int width, int64_t elements = -1) const {
    const GaussianSpans<const float> values = this->values();
    if (elements < 0) elements = count();
    std::vector<float> out;
    out.reserve(size_t(elements * width));
    for (int c = 0; c < width; ++c)
      for (int64_t n = 0; n < elements; ++n) out.push_back(values.at(group, n)[first + c]);
    return out;
  }
  void add(StreamWords stream) { streams_.push_back(std::move(stream)); }
  /// Compression takes most of the time, so all streams are compressed at once.
  void pack() {
    std::vector<std::string> packed(streams_.size());
    parallel_for(int64_t(streams_.size()), 1, [&](int64_t i, int64_t) {
      packed[size_t(i)] = packed_stream(streams_[size_t(i)], rules_.gzip_level);
    });
    for (size_t i = 0; i < packed.size(); ++i) {
      StreamInfo info = streams_[i].info;
      info.offset = block_.bytes.size();
      info.bytes = packed[i].size();
      block_.info.streams.push_back(std::move(info));
      block_.bytes += packed[i];
    }
  }
  StreamWords rounded(const char* name, int components, const std::vector<float>& values,
                      double step, bool delta = false) const {
    return rules_.lossless ? as_floats(name, components, values)
                           : quantised(name, components, values, step, delta);
  }

  void add_position(const std::vector<float>& positions) {
    add(rounded("position", 3, positions, position_step_, true));
  }

  /// Each stream is rounded with those before it as a reader has them: positions are where the
  /// rounded anchors need them, velocities as exact as their reach requires.
  void add_moving() {
    std::vector<double> lengths;
    const std::vector<float> log_length = column(kLogScaleTime, 0, 1);
    for (float value : log_length) lengths.push_back(std::exp(double(value)));
    const StreamWords time = rounded("time_mean", 1, column(kMeanTime, 0, 1),
                                     kTimeShare * quantile(std::move(lengths), kQuantile));
    const StreamWords length = rounded("log_time_scale", 1, log_length, kTimeScaleStep);
    std::vector<float> anchors(static_cast<size_t>(count()));
    double reach = 0;
    Interval visible{1, 0};
    for (int64_t n = 0; n < count(); ++n) {
      const float mean = value_at(time, 0, n);
      anchors[size_t(n)] = rules_.lossless ? mean : std::clamp(mean, 0.0f, 1.0f);
      const auto drawn = drawn_in_clip(mean, value_at(length, 0, n), opacity_at(n), rules_.cutoff);
      if (!drawn) continue;
      visible.low = std::min(visible.low, drawn->low);
      visible.high = std::max(visible.high, drawn->high);
      reach = std::max({reach, drawn->high - double(anchors[size_t(n)]),
                        double(anchors[size_t(n)]) - drawn->low});
    }
    block_.info.visible = visible;
    constexpr double kLeastReach = 1e-6;
    add_position(at_anchors(anchors));
    add(rounded("velocity", 3, column(kVelocity, 0, 3),
                position_step_ / std::max(reach, kLeastReach)));
    add(time);
    add(length);
  }

  /// mean + velocity · (anchor − time_mean), of unrounded values: on the path of each.
  std::vector<float> at_anchors(const std::vector<float>& anchors) const {
    std::vector<float> positions = column(kMean, 0, 3);
    if (rules_.lossless) return positions;
    const GaussianSpans<const float> values = this->values();
    for (int64_t n = 0; n < count(); ++n)
      for (int k = 0; k < 3; ++k)
        positions[size_t(k * count() + n)] +=
            values.at(kVelocity, n)[k] * (anchors[size_t(n)] - *values.at(kMeanTime, n));
    return positions;
  }

  StreamWords opacities() const {
    std::vector<float> logits = column(kOpacityLogit, 0, 1);
    if (rules_.lossless) return as_floats("opacity_logit", 1, logits);
    for (float& value : logits) value = sigmoid(value);
    return bytes_of_unit("opacity", logits);
  }
  double opacity_at(int64_t n) const {
    const float stored = value_at(opacity_, 0, n);
    return double(rules_.lossless ? sigmoid(stored) : stored);
  }

  void add_shape() {
    rules_.lossless ? add(as_floats("rotation", 4, column(kRotation, 0, 4))) : add_rotations();
    add(rounded("log_scale", 3, column(kLogScale, 0, 3), kScaleStep));
    add(std::move(opacity_));
  }

  /// The three smaller parts of each unit quaternion, and which is the largest, made positive.
  void add_rotations() {
    std::vector<float> smaller(static_cast<size_t>(3 * count())), largest;
    for (int64_t n = 0; n < count(); ++n) {
      const Vec4<float> q = glm::normalize(load4(values().at(kRotation, n)));
      const int top = largest_of({q[0], q[1], q[2], q[3]});
      int64_t moved = n;
      for (int k = 0; k < 4; ++k)
        if (k != top) {
          smaller[size_t(moved)] = q[top] < 0 ? -q[k] : q[k];
          moved += count();
        }
      largest.push_back(float(top));
    }
    add(quantised("rotation", 3, smaller, kRotationStep));
    add(quantised("rotation_largest", 1, largest, 1));
  }

  void add_colour() {
    add(rounded(kShNames[0], 3, column(kSh, 0, 3), kColourStep));
    for (int degree = 1; degree <= rules_.sh_degree; ++degree) {
      const int64_t elements = sh_elements_[size_t(degree)];
      if (elements == 0) break;
      add(rounded(kShNames[degree], band_width(degree),
                  column(kSh, band_begin(degree), band_width(degree), elements), kShStep[degree]));
    }
  }

  BlockRules rules_;
  const MotionNodes& nodes_;
  std::array<int64_t, kMaxShDegree + 1>
      sh_elements_{};  // Gaussians that need a degree: the first ones
  GaussianSet sorted_{SetForm::kStatic, 1};
  double position_step_ = 0;  // world units
  StreamWords opacity_;       // until it is added
  std::vector<StreamWords> streams_;
  Block block_;
};

}  // namespace

double position_step(const GaussianSpans<const float>& set) {
  std::vector<double> sizes;
  for (int64_t n = 0; n < set.count; ++n) {
    const float* s = set.at(kLogScale, n);
    sizes.push_back(std::max(std::min(s[0], s[1]), std::min(std::max(s[0], s[1]), s[2])));
  }
  return kPositionShare * std::exp(quantile(std::move(sizes), kQuantile));
}

Block encode_block(const GaussianSet& set, const BlockRules& rules, const MotionNodes& nodes) {
  check(set.form() != SetForm::kPair && set.time_levels() == 0, "encode_block: not of pairs");
  check((set.form() == SetForm::kCanonical) == !nodes.empty(), "encode_block: nodes and bindings");
  check(set.count() > 0, "encode_block: a block of no Gaussians");
  return Encoder(set, rules, nodes).encode();
}

Block with_head(Block block) {
  const std::string head = head_of(block.info);
  block.bytes.insert(0, head);
  block.info.streams.clear();
  block.info.head = head.size();
  block.info.bytes = block.bytes.size();
  block.info.crc32 = crc32_of(block.bytes);
  return block;
}

}  // namespace tessera
