// Writes a model as a Tessera 4D file: Gaussians are grouped by the time in which they are drawn,
// and the groups become blocks in files.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/element_edits.h"
#include "static3d/tessera4d/block.h"
#include "static3d/tessera4d/node_streams.h"
#include "static3d/tessera4d/segments.h"
#include "static3d/tessera4d/tessera4d.h"
#include "static3d/transform/far_gaussians.h"
#include "static3d/transform/motion_form.h"
#include "static3d/transform/scene_box.h"

namespace tessera {
namespace {

/// Velocity form; the temporal filter in σ_t; colours of each Gaussian's own timestep: Δ = 0.
GaussianSet plain_dynamic(const GaussianModel& model) {
  const GaussianSet moving = in_form(model.dynamic_set, SetForm::kVelocity);
  GaussianSet plain(SetForm::kVelocity, moving.coefficients());
  plain.resize(moving.count());
  const GaussianSpans<const float> from = moving.values();
  const GaussianSpans<float> to = plain.values();
  for (int g = 0; g < kGroupCount; ++g)
    if (g != kShTime) std::copy_n(from.group[g].data, from.group[g].size, to.group[g].data);
  const ColourRules<float> colours =
      make_colour_rules<float>(render_options(model), from.coefficients, from.time_levels);
  for (int64_t n = 0; n < from.count; ++n) {
    add_levels(colours, 0.0f, from.at(kShTime, n), to.at(kSh, n));
    if (!(model.drawing.time_filter > 0)) continue;
    const double variance =
        std::exp(2 * double(*from.at(kLogScaleTime, n))) + model.drawing.time_filter;
    *to.at(kLogScaleTime, n) = float(0.5 * std::log(variance));
  }
  return plain;
}

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

class Writer {
 public:
  Writer(const GaussianModel& model, const Tessera4dOptions& options)
      : model_(model), options_(options), box_(scene_box(model)) {
    if (!(options.segment_seconds > 0))
      throw InputError(fmt::format("export: --segment is {} seconds, expected more than 0",
                                   options.segment_seconds));
    rules_ = {options.lossless, model.drawing.sh_degree, model.cutoff<double>(),
              options.gzip_level};
    manifest_.generator = options.generator;
    manifest_.fps = options.fps;
    manifest_.cameras = options.cameras;
    manifest_.audio = options.audio;
    manifest_.up = up_of(options.cameras);
    manifest_.lossless = options.lossless;
    manifest_.anchor_in_clip = !options.lossless;
  }

  Tessera4dFile write() {
    add_static();
    add_dynamic();
    file_.manifest = to_json(manifest_, model_).dump(1) + "\n";
    file_.static_count = manifest_.gaussians(false);
    file_.dynamic_count = manifest_.gaussians(true);
    file_.non_finite = manifest_.non_finite;
    file_.never_drawn = manifest_.never_drawn;
    file_.far_outliers = manifest_.far_outliers;
    return std::move(file_);
  }

 private:
  void add_block(const GaussianSet& set, const std::string& name, BlockInfo place) {
    Block block = set.form() == SetForm::kCanonical ? encode_block(set, rules_, model_.nodes)
                                                    : encode_block(set, rules_);
    block.info.file = name;
    block.info.level = place.level;
    block.info.segment = place.segment;
    manifest_.blocks.push_back(std::move(block.info));
    file_.blocks.emplace_back(name, std::move(block.bytes));
  }
  /// A second block has those that are so far away that the first could not hold its step.
  void add_blocks(const GaussianSet& set, const std::string& name, BlockInfo place) {
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
  void note(const Vec3<float>& mean) {
    if (box_.is_far(mean, kFarFactor)) {
      ++manifest_.far_outliers;
      return;
    }
    if (!manifest_.bounds) manifest_.bounds = {mean, mean};
    auto& [low, high] = *manifest_.bounds;
    low = glm::min(low, mean);
    high = glm::max(high, mean);
  }

  void add_static() {
    const GaussianSpans<const float> values = model_.static_set.values();
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
    const auto first_static =
        std::stable_partition(elements.begin(), elements.end(), [&](int64_t n) {
          return model_.static_set.form() == SetForm::kCanonical && is_bound(values, n);
        });
    const std::vector<int64_t> carried(elements.begin(), first_static),
        fixed(first_static, elements.end());
    if (!fixed.empty())
      add_blocks(in_static_form(select_elements(model_.static_set, fixed)), "static", {});
    if (!carried.empty())
      add_block(select_elements(model_.static_set, carried), "canonical.bin", {});
  }

  void add_dynamic() {
    const GaussianSet moving = plain_dynamic(model_);
    const GaussianSpans<const float> values = moving.values();
    manifest_.non_finite += model_.dynamic_set.count() - moving.count();
    const double shortest = options_.segment_seconds / model_.time_axis.duration;
    std::map<TimeCell, std::vector<int64_t>> cells;
    for (int64_t n = 0; n < values.count; ++n) {
      const float time = *values.at(kMeanTime, n);
      const auto drawn =
          drawn_in_clip(time, *values.at(kLogScaleTime, n),
                        sigmoid(double(*values.at(kOpacityLogit, n))), rules_.cutoff);
      if (!drawn) {
        ++manifest_.never_drawn;
        continue;
      }
      cells[cell_of(*drawn, shortest)].push_back(n);
      note(load3(values.at(kMean, n)) +
           load3(values.at(kVelocity, n)) * (std::clamp(time, 0.0f, 1.0f) - time));
    }
    for (const auto& [cell, elements] : cells) {
      BlockInfo place;
      place.level = cell.level;
      const double length = segment_length(cell.level, shortest);
      if (length < 1)
        place.segment = {double(cell.segment) * length,
                         std::min(1.0, double(cell.segment + 1) * length)};
      add_blocks(select_elements(moving, elements),
                 fmt::format("level{}_{:04}", cell.level, cell.segment), place);
    }
  }

  const GaussianModel& model_;
  const Tessera4dOptions& options_;
  SceneBox box_;
  BlockRules rules_;
  Tessera4dManifest manifest_;
  Tessera4dFile file_;
};

}  // namespace

int64_t Tessera4dFile::bytes() const {
  int64_t sum = int64_t(manifest.size());
  for (const auto& [name, block] : blocks) sum += int64_t(block.size());
  return sum;
}

Tessera4dFile encode_tessera4d(const GaussianModel& model, const Tessera4dOptions& options) {
  return Writer(model, options).write();
}

void write_tessera4d_folder(const std::filesystem::path& folder, const Tessera4dFile& file) {
  make_folder(folder);
  for (const auto& [name, bytes] : file.blocks) write_text_file(folder / name, bytes);
  write_text_file(folder / kTessera4dManifest, file.manifest);
}

std::string single_tessera4d(const Tessera4dFile& file) {
  nlohmann::json manifest = nlohmann::json::parse(file.manifest);
  uint64_t offset = 0;
  for (nlohmann::json& block : manifest["blocks"]) {
    block.erase("file");
    block["offset"] = offset;
    offset += block["bytes"].get<uint64_t>();
  }
  const std::string text = manifest.dump();
  std::string out(kTessera4dMagic);
  append(out, manifest["version"].get<uint32_t>());
  append(out, uint32_t(text.size()));
  out += text;
  for (const auto& [name, bytes] : file.blocks) out += bytes;
  return out;
}

}  // namespace tessera
