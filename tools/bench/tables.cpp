// The rows and the published figures. A row only sets options that any user could set. Source:
// method F.1 to F.3; published_numbers 5a, 5c, 5g.
#include "tools/bench/tables.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"
#include "recon4d/options/nearest_name.h"
#include "recon4d/options/presets.h"

namespace tessera {
namespace {

using Figures = std::map<std::string, double>;

constexpr double kGiB = 1 << 30;

const char* const kNine = "Faster-GS paper, mean of nine Mip-NeRF 360 scenes, RTX 4090";
const char* const kOutdoor = "Faster-GS paper, mean of its outdoor scenes, RTX 4090";
const char* const kDnerf = "Faster-GS paper, mean of eight D-NeRF scenes, RTX 4090";
const char* const kN3dv = "Faster-GS paper, mean of coffee, spinach and flame steak, RTX 4090";
const char* const kOfficial = "Faster-GS code, 30,000 steps, re-run on one H200";

const std::vector<std::string> kColumns = {"psnr",          "ssim",  "seconds",
                                           "num_gaussians", "bytes", "peak_device_bytes"};

/// The static code's figures on scenes of ours.
std::vector<Published> official_static(std::vector<Published> more = {}) {
  more.push_back({kOfficial,
                  "mic",
                  {{"psnr", 36.92},
                   {"ssim", 0.9926},
                   {"seconds", 61.3},
                   {"num_gaussians", 175e3},
                   {"peak_device_bytes", 1.39 * kGiB}}});
  more.push_back({kOfficial,
                  "bonsai",
                  {{"psnr", 31.02},
                   {"ssim", 0.931},
                   {"seconds", 85.4},
                   {"num_gaussians", 1095e3},
                   {"peak_device_bytes", 2.44 * kGiB}}});
  return more;
}

std::vector<Published> ablation_figures(const std::string& name) {
  if (name == "full")  // ours has the optimizer inside the backward pass
    return {{kOutdoor,
             "",
             {{"psnr", 24.73},
              {"seconds", 304},
              {"num_gaussians", 3.89e6},
              {"peak_device_bytes", 5.6 * kGiB}}}};
  if (name == "no-fused-optimizer")
    return {{kOutdoor,
             "",
             {{"psnr", 24.72},
              {"seconds", 331},
              {"num_gaussians", 3.87e6},
              {"peak_device_bytes", 6.0 * kGiB}}}};
  if (name == "skip-invisible")
    return {{kOutdoor,
             "",
             {{"psnr", 24.59},
              {"seconds", 183},
              {"num_gaussians", 3.34e6},
              {"peak_device_bytes", 5.1 * kGiB}}}};
  if (name == "no-z-order") return {{kOutdoor, "", {{"seconds", 352}}}};
  if (name == "basis") return {{kNine, "", {{"seconds", 957}}}};
  return {};
}

BenchTable ablation_table() {
  BenchTable table{"ablations",
                   "each technique taken out of the full method or added to none",
                   SceneKind::kAny,
                   kColumns,
                   {},
                   {}};
  for (const Ablation& ablation : ablations())
    table.rows.push_back({ablation.name,
                          "",
                          ablation.name,
                          {},
                          SceneKind::kAny,
                          "",
                          ablation_figures(ablation.name)});
  table.rows.push_back({"colour without direction",
                        "",
                        "full",
                        {{"sh_degree", 0}},
                        SceneKind::kAny,
                        "",
                        {{kOutdoor,
                          "",
                          {{"psnr", 24.38},
                           {"seconds", 144},
                           {"num_gaussians", 3.85e6},
                           {"peak_device_bytes", 3.2 * kGiB}}}}});
  return table;
}

BenchTable optimizer_table() {
  const auto row = [](const char* name, bool fused, const char* idle, const char* like) {
    return BenchRow{name,
                    "",
                    "",
                    {{"fused_optimizer", fused}, {"idle_updates", idle}},
                    SceneKind::kAny,
                    "",
                    ablation_figures(like)};
  };
  return {"optimizer",
          "Adam inside the backward pass or apart; Gaussians out of sight",
          SceneKind::kAny,
          kColumns,
          {},
          {row("full", true, "dense", "full"),
           row("separate optimizer", false, "dense", "no-fused-optimizer"),
           row("skip idle", true, "skip", "skip-invisible")}};
}

const OptionOverrides kFullFilters = {{"filter_2d", true}, {"filter_3d", "clamp"}};

BenchTable antialiasing_table() {
  const auto row = [](const char* name, OptionOverrides overrides, Figures figures) {
    return BenchRow{
        name, "", "", std::move(overrides), SceneKind::kAny, "", {{kNine, "", std::move(figures)}}};
  };
  BenchTable table{
      "antialiasing",
      "3D and 2D filters, at the resolution of training",
      SceneKind::kAny,
      kColumns,
      {},
      {row("none", {},
           {{"psnr", 27.56},
            {"ssim", 0.816},
            {"seconds", 271},
            {"num_gaussians", 2.73e6},
            {"peak_device_bytes", 6.1 * kGiB}}),
       row("3D filter (mip)", {{"filter_3d", "mip"}}, {{"psnr", 27.53}, {"seconds", 358}}),
       row("3D filter (clamp)", {{"filter_3d", "clamp"}}, {{"psnr", 27.55}, {"seconds", 272}}),
       row("2D filter", {{"filter_2d", true}}, {{"psnr", 27.54}, {"num_gaussians", 2.78e6}}),
       row("full (2D and clamp)", kFullFilters,
           {{"psnr", 27.54}, {"seconds", 271}, {"num_gaussians", 2.70e6}})}};
  table.rows.front().published = official_static(table.rows.front().published);
  return table;
}

BenchTable multiscale_table() {
  const auto row = [](const char* name, OptionOverrides overrides, Figures figures) {
    overrides.insert(overrides.begin(), {"train_scale", 0.5});
    return BenchRow{
        name, "", "", std::move(overrides), SceneKind::kAny, "", {{kNine, "", std::move(figures)}}};
  };
  return {"multiscale",
          "trained at half the scene's resolution, scored at 0.5, 1 and 2 times that",
          SceneKind::kAny,
          {"psnr_1x", "psnr_0.5x", "psnr_2x", "ssim_1x", "ssim_0.5x", "ssim_2x", "seconds",
           "num_gaussians"},
          {0.5, 1, 2},
          {row("none", {}, {{"psnr_1x", 27.56}, {"psnr_0.5x", 25.11}, {"psnr_2x", 25.73}}),
           row("full (2D and clamp)", kFullFilters,
               {{"psnr_1x", 27.54}, {"psnr_0.5x", 28.39}, {"psnr_2x", 26.87}})}};
}

BenchTable mcmc_table() {
  return {"mcmc",
          "density control by sampling, with as many Gaussians as 3dgs ends with",
          SceneKind::kStill,
          kColumns,
          {},
          {{"3dgs",
            "3dgs",
            "",
            {},
            SceneKind::kStill,
            "",
            official_static({{kNine,
                              "",
                              {{"psnr", 27.56},
                               {"ssim", 0.816},
                               {"seconds", 271},
                               {"num_gaussians", 2.73e6},
                               {"peak_device_bytes", 6.1 * kGiB}}}})},
           {"mcmc, same count",
            "mcmc",
            "",
            {},
            SceneKind::kStill,
            "3dgs",
            {{kNine, "", {{"psnr", 28.00}, {"seconds", 377}, {"peak_device_bytes", 7.2 * kGiB}}},
             {"3DGS-MCMC, as in the Faster-GS paper, nine Mip-NeRF 360 scenes, RTX 4090",
              "",
              {{"psnr", 27.83}, {"seconds", 1642}}}}}}};
}

BenchTable truncation_table() {
  BenchTable table{"truncation",
                   "where splats end: by alpha, or by falloff alone; both filters on",
                   SceneKind::kAny,
                   kColumns,
                   {},
                   {}};
  const auto add = [&](double sigma, bool by_falloff, Figures figures) {
    OptionOverrides overrides = kFullFilters;
    const bool is_default = sigma == 3.33;  // √(2 ln 255), the options' own
    if (!is_default) overrides.push_back({"truncation_sigma", sigma});
    if (by_falloff) overrides.push_back({"truncation_by_falloff", true});
    BenchRow row{fmt::format("{} sigma{}", sigma, by_falloff ? ", by falloff" : ""), "", "",
                 std::move(overrides)};
    if (!figures.empty()) row.published = {{kNine, "", std::move(figures)}};
    table.rows.push_back(std::move(row));
  };
  add(3.33, false, {{"psnr", 27.54}});
  add(4, false, {{"psnr", 27.54}});
  add(3.33, true, {{"psnr", 27.57}});
  add(4, true, {{"psnr", 27.65}});
  add(3, true, {{"psnr", 27.62}});
  add(2, true, {{"psnr", 27.23}, {"num_gaussians", 2.22e6}});
  add(1, true, {{"psnr", 25.86}, {"num_gaussians", 1.39e6}});  // its code has √2 sigma here
  return table;
}

std::vector<Published> by_scene(std::vector<Published> first, const char* source,
                                const std::map<std::string, double>& psnr) {
  for (const auto& [scene, value] : psnr) first.push_back({source, scene, {{"psnr", value}}});
  return first;
}

BenchRow preset_row(const char* preset, SceneKind kind, std::vector<Published> published = {}) {
  return {preset, preset, "", {}, kind, "", std::move(published)};
}

BenchTable dnerf_table() {
  return {
      "dnerf",
      "moving objects, one camera",
      SceneKind::kMoving,
      kColumns,
      {},
      {preset_row("faster-gs", SceneKind::kMoving,
                  {{kDnerf,
                    "",
                    {{"psnr", 31.79},
                     {"ssim", 0.960},
                     {"seconds", 382},
                     {"num_gaussians", 0.79e6},
                     {"peak_device_bytes", 1.2 * kGiB}}},
                   {kOfficial,
                    "dnerf_lego",
                    {{"psnr", 23.71},
                     {"ssim", 0.882},
                     {"seconds", 256.4},
                     {"num_gaussians", 1.004e6},
                     {"peak_device_bytes", 2.03 * kGiB}}}}),
       preset_row(
           "yang4d", SceneKind::kMoving,
           by_scene({{"Yang's 4DGS, in the Faster-GS paper, mean of eight D-NeRF scenes, RTX 4090",
                      "",
                      {{"psnr", 31.52},
                       {"ssim", 0.960},
                       {"seconds", 1089},
                       {"num_gaussians", 0.83e6},
                       {"peak_device_bytes", 1.9 * kGiB}}}},
                    "Yang's 4DGS retrained by 4DGS-1K, 400 x 400",
                    {{"bouncingballs", 33.35},
                     {"hellwarrior", 34.73},
                     {"hook", 31.94},
                     {"jumpingjacks", 30.82},
                     {"lego", 25.33},
                     {"mutant", 38.93},
                     {"standup", 39.04},
                     {"trex", 29.85}})),
       preset_row("balanced", SceneKind::kMoving)}};
}

BenchTable n3dv_table() {
  return {
      "n3dv",
      "rooms, many cameras",
      SceneKind::kMoving,
      kColumns,
      {},
      {preset_row(
           "faster-gs", SceneKind::kMoving,
           {{kN3dv, "", {{"psnr", 30.54}, {"seconds", 1137}, {"peak_device_bytes", 3.7 * kGiB}}}}),
       preset_row(
           "yang4d", SceneKind::kMoving,
           by_scene({{"Yang's 4DGS, in the Faster-GS paper, mean of coffee, spinach and flame "
                      "steak, RTX 4090",
                      "",
                      {{"psnr", 30.13}, {"seconds", 5803}, {"peak_device_bytes", 8.7 * kGiB}}}},
                    "Yang's 4DGS, its own figures, best of the run",
                    {{"coffee_martini", 28.33},
                     {"cook_spinach", 32.93},
                     {"cut_roasted_beef", 33.85},
                     {"flame_salmon", 29.38},
                     {"flame_steak", 34.03},
                     {"sear_steak", 33.51}})),
       preset_row("balanced", SceneKind::kMoving)}};
}

BenchTable inference_table() {
  return {
      "inference",
      "frames per second at the scored cameras, one after the other",
      SceneKind::kAny,
      {"fps", "num_gaussians", "bytes", "psnr", "ssim"},
      {},
      {preset_row(
           "3dgs", SceneKind::kStill,
           {{"Faster-GS paper, mean of its scenes, RTX 4090", "", {{"fps", 903}}},
            {"3DGS, in the Faster-GS paper, mean of its scenes, RTX 4090", "", {{"fps", 290}}}}),
       preset_row("mcmc", SceneKind::kStill), preset_row("faster-gs", SceneKind::kMoving),
       preset_row("yang4d", SceneKind::kMoving,
                  {{"Yang's 4DGS on N3DV, as in Hybrid 3D-4DGS, RTX 4090",
                    "",
                    {{"fps", 114}, {"psnr", 32.01}}}}),
       preset_row("balanced", SceneKind::kAny)}};
}

}  // namespace

bool is_of_scene(const Published& published, const std::string& folder) {
  return published.scene.empty() || folder == published.scene ||
         folder.ends_with("_" + published.scene);
}

const std::vector<BenchTable>& bench_tables() {
  static const std::vector<BenchTable> tables = {
      ablation_table(),   optimizer_table(), antialiasing_table(), multiscale_table(), mcmc_table(),
      truncation_table(), dnerf_table(),     n3dv_table(),         inference_table()};
  return tables;
}

const BenchTable& bench_table(const std::string& name) {
  std::vector<std::string> names;
  for (const BenchTable& table : bench_tables()) {
    if (table.name == name) return table;
    names.push_back(table.name);
  }
  throw InputError(fmt::format("unknown table '{}'{}", name, known_names(name, names)));
}

std::string row_preset(const BenchRow& row, bool still_scene) {
  if (!row.preset.empty()) return row.preset;
  return still_scene ? "3dgs" : "faster-gs";
}

std::string row_label(const BenchRow& row, bool still_scene) {
  std::string label = row_preset(row, still_scene);
  if (!row.ablation.empty()) label += "+" + row.ablation;
  for (const auto& [key, value] : row.overrides)
    label += fmt::format("+{}={}", key, plain_text(value));
  if (!row.count_of.empty()) label += "+as-many-as-" + row.count_of;
  return label;
}

}  // namespace tessera
