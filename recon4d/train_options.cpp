// What: the option table, the presets, and setting options by name.
// Not: any use of the values.
#include "recon4d/train_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "kernels/base/errors.h"
#include "recon4d/nearest_name.h"

namespace tessera {
namespace {

using O = TrainOptions;
constexpr double kMany = 1e12;

nlohmann::json value_of(const TrainOptions& options, const OptionRow& row) {
  return std::visit([&](auto member) { return nlohmann::json(options.*member); }, row.member);
}

const OptionRow& row_of(const std::string& key) {
  std::vector<std::string> keys;
  for (const OptionRow& row : train_option_rows()) {
    if (key == row.key) return row;
    keys.push_back(row.key);
  }
  throw InputError(
      fmt::format("unknown option '{}'; did you mean '{}'?", key, nearest_name(key, keys)));
}

double checked(const OptionRow& row, double value) {
  if (!(value >= row.low && value <= row.high))
    throw InputError(fmt::format("option '{}' is {}, expected {} to {}: {}", row.key, value,
                                 row.low, row.high, row.doc));
  return value;
}

struct Setter {
  TrainOptions& options;
  const OptionRow& row;
  const nlohmann::json& value;

  [[noreturn]] void refuse(const char* expected) const {
    throw InputError(fmt::format("option '{}' is {}, expected {}: {}", row.key, value.dump(),
                                 expected, row.doc));
  }
  void operator()(int64_t O::*member) const {
    const bool whole = value.is_number_integer() ||
                       (value.is_number_float() && std::abs(value.get<double>()) < 1e15 &&
                        value.get<double>() == double(int64_t(value.get<double>())));
    if (!whole) refuse("a whole number");
    checked(row, value.get<double>());  // before the conversion: an unsigned number may not fit
    options.*member = value.get<int64_t>();
  }
  void operator()(double O::*member) const {
    if (!value.is_number()) refuse("a number");
    options.*member = checked(row, value.get<double>());
  }
  void operator()(bool O::*member) const {
    if (!value.is_boolean()) refuse("true or false");
    options.*member = value.get<bool>();
  }
  void operator()(std::string O::*member) const {
    if (!value.is_string()) refuse("text");
    options.*member = value.get<std::string>();
  }
};

}  // namespace

const std::vector<OptionRow>& train_option_rows() {
  static const std::vector<OptionRow> rows = {
      {"iterations", &O::iterations, 0, 1e9, "training steps; each takes a batch of views",
       "[3DGS]"},
      {"schedule_iterations", &O::schedule_iterations, 1, 1e9,
       "length that the step counts below refer to; they are scaled by iterations / this", "ours"},
      {"batch", &O::batch, 1, 1024, "(view, time) pairs per step", "[Yang24]"},
      {"seed", &O::seed, 0, kMany, "of every random choice", "ours"},
      {"static_only", &O::static_only, 0, 1, "one static set, no dynamic Gaussians", "[3DGS]"},
      {"background", &O::background, 0, 0, "colour behind the scene: black, white or r,g,b (0-255)",
       "[Faster-GS]"},
      {"near_plane", &O::near_plane, 1e-6, 1e9, "world units; nearer Gaussians are not drawn",
       "[3DGS]"},
      {"far_plane", &O::far_plane, 1e-6, 1e12, "world units; farther Gaussians are not drawn",
       "[Faster-GS]"},
      {"init_points", &O::init_points, 0, 1e9,
       "random initial Gaussians where there is no point cloud; largest share taken of a cloud",
       "[Yang24]"},
      {"init_extent", &O::init_extent, 0, 1e9,
       "half size of the box of random points, world units; 0: from the cameras", "[Faster-GS]"},
      {"init_opacity", &O::init_opacity, 1e-6, 0.999999, "initial opacity", "[3DGS]"},
      {"init_time_scale", &O::init_time_scale, 1e-6, 1e6, "initial temporal sigma, in clip lengths",
       "[Yang24]"},
      {"static_fraction", &O::static_fraction, 0, 1,
       "share of the initial Gaussians that start in the static set", "ours"},
      {"carve", &O::carve, 0, 1, "drop random points that no training camera sees", "[Faster-GS]"},
      {"sweep", &O::sweep, 0, 1,
       "without a point cloud: find initial points by a plane sweep where cameras share moments",
       "[Collins96]"},
      {"split_by_motion", &O::split_by_motion, 0, 1,
       "swept points whose pixel never changes start in the static set", "ours"},
      {"sh_degree", &O::sh_degree, 0, 3, "highest spherical-harmonics degree", "[3DGS]"},
      {"sh_interval", &O::sh_interval, 1, 1e9, "steps between two degrees", "[3DGS]"},
      {"lambda_dssim", &O::lambda_dssim, 0, 1, "weight of 1 - SSIM; the rest is L1", "[3DGS]"},
      {"lr_mean", &O::lr_mean, 0, 1e3, "of means at the start, per scene extent", "[3DGS]"},
      {"lr_mean_final", &O::lr_mean_final, 0, 1e3, "of means at the end, per scene extent",
       "[3DGS]"},
      {"lr_mean_time", &O::lr_mean_time, 0, 1e3, "of temporal means, per scene extent", "[Yang24]"},
      {"lr_scale", &O::lr_scale, 0, 1e3, "of log scales", "[3DGS]"},
      {"lr_scale_time", &O::lr_scale_time, 0, 1e3, "of the temporal log scale", "[Yang24]"},
      {"lr_rotation", &O::lr_rotation, 0, 1e3, "of quaternions", "[3DGS]"},
      {"lr_opacity", &O::lr_opacity, 0, 1e3, "of opacity logits", "[Yang24]; [3DGS] has 0.025"},
      {"lr_sh", &O::lr_sh, 0, 1e3, "of the first SH coefficient", "[3DGS]"},
      {"lr_sh_rest", &O::lr_sh_rest, 0, 1e3, "of the other SH coefficients", "[3DGS]"},
      {"fused_optimizer", &O::fused_optimizer, 0, 1,
       "Adam inside the backward pass, without a gradient buffer", "[Faster-GS]"},
      {"densify_from", &O::densify_from, 0, 1e9, "first step of density control", "[Faster-GS]"},
      {"densify_until", &O::densify_until, 0, 1e9, "last step of density control; 0: none",
       "[Faster-GS]"},
      {"densify_interval", &O::densify_interval, 1, 1e9,
       "steps between two density controls; not scaled", "[3DGS]"},
      {"densify_threshold", &O::densify_threshold, 0, kMany,
       "mean screen-space gradient (NDC) above which a Gaussian is cloned or split", "[3DGS]"},
      {"dense_fraction", &O::dense_fraction, 0, 1e6,
       "largest scale of a clone, per scene extent; larger ones are split", "[3DGS]"},
      {"prune_opacity", &O::prune_opacity, 0, 1, "Gaussians below are removed", "[3DGS]"},
      {"prune_extent", &O::prune_extent, 0, 1e6,
       "Gaussians with a larger scale, per scene extent, are removed", "[3DGS]"},
      {"prune_large_from", &O::prune_large_from, 0, 1e9, "first step at which prune_extent holds",
       "[3DGS]"},
      {"opacity_reset_interval", &O::opacity_reset_interval, 0, 1e9,
       "steps between two opacity resets, with one more at 500 unless the background is black; 0: "
       "never, the default in 4D",
       "[Hybrid4D]"},
      {"max_gaussians", &O::max_gaussians, 0, 1e9, "upper limit of both sets together; 0: none",
       "ours"},
      {"reorder_interval", &O::reorder_interval, 0, 1e9,
       "steps between two Morton re-orderings, until density control has ended; 0: never",
       "[Faster-GS]"},
  };
  return rows;
}

void set_option(TrainOptions& options, const std::string& key, const nlohmann::json& value) {
  const OptionRow& row = row_of(key);
  std::visit(Setter{options, row, value}, row.member);
}

void set_option_from_text(TrainOptions& options, const std::string& key, const std::string& text) {
  const OptionRow& row = row_of(key);
  if (std::holds_alternative<std::string O::*>(row.member)) return set_option(options, key, text);
  nlohmann::json value = nlohmann::json::parse(text, nullptr, false);
  if (value.is_discarded()) value = text;
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);  // ".5", "+1", which are not JSON
  if (value.is_string() && !text.empty() && *end == '\0') value = number;
  set_option(options, key, value);
}

void validate(const TrainOptions& options) {
  if (options.near_plane >= options.far_plane)
    throw InputError(fmt::format("near_plane {} must be smaller than far_plane {}",
                                 options.near_plane, options.far_plane));
  parse_background(options.background);
}

nlohmann::json to_json(const TrainOptions& options) {
  nlohmann::json json = nlohmann::json::object();
  for (const OptionRow& row : train_option_rows()) json[row.key] = value_of(options, row);
  return json;
}

TrainOptions train_options_from_json(const nlohmann::json& json) {
  if (!json.is_object()) throw InputError("options must be a JSON object of key: value");
  TrainOptions options;
  for (const auto& [key, value] : json.items()) set_option(options, key, value);
  return options;
}

std::array<uint8_t, 3> parse_background(const std::string& text) {
  if (text == "black") return {0, 0, 0};
  if (text == "white") return {255, 255, 255};
  std::array<uint8_t, 3> rgb{};
  const char *at = text.data(), *const end = at + text.size();
  bool good = true;
  for (size_t c = 0; c < 3 && good; ++c) {
    const auto [rest, error] = std::from_chars(at, end, rgb[c]);
    good = error == std::errc() && (c == 2 ? rest == end : rest != end && *rest == ',');
    if (c < 2) at = rest + 1;
  }
  if (!good)
    throw InputError(
        fmt::format("background '{}': expected black, white or r,g,b with 0 to 255", text));
  return rgb;
}

}  // namespace tessera
