// Which Gaussians go into which block of a Tessera 4D file, and what is counted of them.
#include "static3d/tessera4d/blocks_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "recon4d/model/element_edits.h"
#include "static3d/tessera4d/node_streams.h"
#include "static3d/tessera4d/segments.h"
#include "static3d/transform/far_gaussians.h"
#include "static3d/transform/motion_form.h"

namespace tessera {
namespace {

/// Of a canonical set what a static one has.
GaussianSet in_static_form(GaussianSet set) {
  if (set.form() == SetForm::kStatic) return set;
  GaussianSet out(SetForm::kStatic, set.coefficients());
  out.resize(set.count());
  const GaussianSpans<const float> from = std::as_const(set).values();
  const GaussianSpans<float> to = out.values();
  for (int g = 0; g < kStaticGroups; ++g)
    std::copy_n(from.group[g].data, from.group[g].size, to.group[g].data);
  return out;
}

/// The core of a window in its own time.
Interval core_of(const FileWindow& window) {
  return {std::max(window_time(window, window.drawn.low), 0.0),
          std::min(window_time(window, window.drawn.high), 1.0)};
}

/// An interval of a window's own time in that of the clip, as far as the window is drawn.
Interval drawn_part(const FileWindow& window, const Interval& own_time) {
  const auto& [low, high] = window.drawn;
  return {std::clamp(clip_time(window, own_time.low), low, high),
          std::clamp(clip_time(window, own_time.high), low, high)};
}

}  // namespace

BlocksWriter::BlocksWriter(const GaussianModel& rules, const Tessera4dOptions& options,
                           const SceneBox& box, BlockSink sink, std::vector<FileWindow> windows)
    : segment_seconds_(options.segment_seconds),
      clip_(rules.time_axis),
      box_(box),
      rules_{options.lossless, rules.drawing.sh_degree, rules.cutoff<double>(), options.gzip_level},
      sink_(std::move(sink)) {
  if (!(options.segment_seconds > 0))
    throw InputError(fmt::format("export: --segment is {} seconds, expected more than 0",
                                 options.segment_seconds));
  manifest_.generator = options.generator;
  manifest_.fps = options.fps;
  manifest_.cameras = options.cameras;
  manifest_.audio = options.audio;
  manifest_.up = up_of(options.cameras);
  manifest_.lossless = options.lossless;
  manifest_.anchor_in_clip = !options.lossless;
  manifest_.windows = std::move(windows);
}

void BlocksWriter::add_block(const GaussianSet& set, const std::string& name,
                             const BlockInfo& place, const MotionNodes& nodes) {
  Block block = encode_block(set, rules_, nodes);
  if (!manifest_.windows.empty()) block = with_head(std::move(block));
  if (place.window >= 0)
    block.info.visible = drawn_part(manifest_.windows[size_t(place.window)], block.info.visible);
  block.info.file = name;
  block.info.level = place.level;
  block.info.segment = place.segment;
  block.info.window = place.window;
  manifest_.blocks.push_back(std::move(block.info));
  sink_(name, std::move(block.bytes));
}

/// A second block has those that are so far away that the first could not hold its step.
void BlocksWriter::add_blocks(const GaussianSet& set, const std::string& name,
                              const BlockInfo& place) {
  constexpr double kMostSteps = 1 << 23;  // to each side of the middle: words have 24 bits
  const GaussianSpans<const float> values = set.values();
  const FarShells shells(values);
  const double reach = (kMostSteps - 2) * position_step(values);
  const HeldRows held = rows_within(values, shells, [&](const float* mean) {
    bool inside = true;
    for (int k = 0; k < 3; ++k)
      inside = inside && std::abs(double(mean[k]) - shells.box().centre[k]) < reach;
    return inside;
  });
  if (rules_.lossless || held.beyond.empty()) {
    add_block(set, name + ".bin", place);
    return;
  }
  add_block(select_elements(set, held.rows), name + ".bin", place);
  add_block(select_elements(set, held.beyond), name + "_far.bin", place);
}

/// Counts and bounds of what is written.
void BlocksWriter::note(const Vec3<float>& mean) {
  if (box_.is_far(mean, kFarFactor)) {
    ++manifest_.far_outliers;
    return;
  }
  if (!manifest_.bounds) manifest_.bounds = {mean, mean};
  auto& [low, high] = *manifest_.bounds;
  low = glm::min(low, mean);
  high = glm::max(high, mean);
}

void BlocksWriter::add_static(const GaussianSet& set, const MotionNodes& nodes) {
  const GaussianSpans<const float> values = set.values();
  std::vector<int64_t> elements;
  for (int64_t n = 0; n < values.count; ++n) {
    if (!is_valid_element(values, n)) {
      ++manifest_.non_finite;
    } else if (!rules_.cutoff.keeps(sigmoid(double(*values.at(kOpacityLogit, n))))) {
      ++manifest_.never_drawn;
    } else {
      elements.push_back(n);
      note(load3(values.at(kMean, n)));
    }
  }
  const auto first_static = std::stable_partition(elements.begin(), elements.end(), [&](int64_t n) {
    return set.form() == SetForm::kCanonical && is_bound(values, n);
  });
  const std::vector<int64_t> carried(elements.begin(), first_static),
      fixed(first_static, elements.end());
  if (!fixed.empty()) add_blocks(in_static_form(select_elements(set, fixed)), "static", {});
  if (!carried.empty()) add_block(select_elements(set, carried), "canonical.bin", {}, nodes);
}

void BlocksWriter::add_dynamic(const GaussianModel& model, int window) {
  const GaussianSet moving = plain_velocity_form(model);
  const GaussianSpans<const float> values = moving.values();
  manifest_.non_finite += model.dynamic_set.count() - moving.count();
  TimeAxis seconds = clip_;
  Interval core;
  if (window >= 0) {
    seconds = window_axis(manifest_.windows[size_t(window)], clip_);
    core = core_of(manifest_.windows[size_t(window)]);
  }
  const double shortest = segment_seconds_ / seconds.duration;
  std::map<TimeCell, std::vector<int64_t>> cells;
  for (int64_t n = 0; n < values.count; ++n) {
    const float time = *values.at(kMeanTime, n);
    const Interval drawn =
        drawn_in_clip(time, *values.at(kLogScaleTime, n),
                      sigmoid(double(*values.at(kOpacityLogit, n))), rules_.cutoff)
            .value_or(Interval{1, 0});
    const Interval part{std::max(drawn.low, core.low), std::min(drawn.high, core.high)};
    if (!(part.low <= part.high)) {
      ++manifest_.never_drawn;
      continue;
    }
    cells[cell_of({part.low - core.low, part.high - core.low}, shortest)].push_back(n);
    note(load3(values.at(kMean, n)) +
         load3(values.at(kVelocity, n)) * (std::clamp(time, 0.0f, 1.0f) - time));
  }
  const std::string prefix = window >= 0 ? fmt::format("w{:04}_", window) : "";
  for (const auto& [cell, elements] : cells) {
    BlockInfo place;
    place.window = window;
    place.level = cell.level;
    const double length = segment_length(cell.level, shortest);
    if (length < 1)
      place.segment = {double(cell.segment) * length,
                       std::min(1.0, double(cell.segment + 1) * length)};
    add_blocks(select_elements(moving, elements),
               fmt::format("{}level{}_{:04}", prefix, cell.level, cell.segment), place);
  }
}

Tessera4dCounts BlocksWriter::counts() const {
  return {manifest_.gaussians(false), manifest_.gaussians(true), manifest_.non_finite,
          manifest_.never_drawn, manifest_.far_outliers};
}

}  // namespace tessera
