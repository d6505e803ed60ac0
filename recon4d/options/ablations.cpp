// The techniques as rows of data, from which the two families of ablations follow. An ablation only
// sets options that users can set as well. Source: the ablations of [Faster-GS]; `skip-invisible`
// is [Taming].
#include "recon4d/options/presets.h"

#include <fmt/format.h>

#include "recon4d/options/train_options.h"

namespace tessera {
namespace {

/// Options of the full method and of the basis, which has none of the techniques.
const OptionOverrides kFull = {{"idle_updates", "dense"}};
const OptionOverrides kBasis = {
    {"idle_updates", "dense"},     {"rectangular_bounds", false}, {"opacity_bounds", false},
    {"balanced_instances", false}, {"separate_sort", false},      {"warp_culling", false},
    {"backward", "pixel"},         {"fused_optimizer", false},    {"reorder_interval", 0}};

/// `without`: on top of full; `with`: on top of basis; empty where there is no such row.
struct Technique {
  const char* without_name;
  OptionOverrides without;
  const char* with_name;
  OptionOverrides with;
  const char* doc;
};

const std::vector<Technique>& techniques() {
  static const std::vector<Technique> rows = {
      {"no-rectangular-bounds",
       {{"rectangular_bounds", false}},
       "rectangular-bounds",
       {{"rectangular_bounds", true}},
       "boxes as wide and high as the splat, not squares"},
      {"no-opacity-bounds",
       {{"opacity_bounds", false}},
       "opacity-bounds",
       {{"opacity_bounds", true}},
       "faint splats reach less far"},
      {"no-balanced-instances",
       {{"balanced_instances", false}},
       "balanced-instances",
       {{"balanced_instances", true}},
       "large splats are written by whole warps"},
      {"no-separate-sort",
       {{"separate_sort", false}},
       "separate-sort",
       {{"separate_sort", true}},
       "depth is sorted once, then tiles"},
      {"no-warp-culling",
       {{"warp_culling", false}},
       "warp-culling",
       {{"warp_culling", true}},
       "a warp skips splats that miss its part of the tile"},
      {"pixel-backward",
       {{"backward", "pixel"}},
       "sub-tile-backward",
       {{"backward", "sub-tile"}},
       "gradients by parts of a tile that splats miss, not by pixels"},
      {"no-fused-optimizer",
       {{"fused_optimizer", false}},
       "fused-optimizer",
       {{"fused_optimizer", true}},
       "Adam inside the backward pass"},
      {"no-z-order",
       {{"reorder_interval", 0}},
       "z-order",
       {{"reorder_interval", TrainOptions{}.reorder_interval}},
       "neighbours in space are neighbours in memory"},
      {"skip-invisible",
       {{"idle_updates", "skip"}},
       "skip-invisible",
       {{"fused_optimizer", true}, {"idle_updates", "skip"}},
       "Gaussians out of sight do nothing"},
  };
  return rows;
}

/// Without one part of densification budget; other densifications stay as they are.
std::vector<Ablation> growth_ablations() {
  static const std::pair<GrowthPart, const char*> parts[] = {
      {GrowthPart::kLongAxisSplit, "Gaussians are cloned or split into samples, not halved"},
      {GrowthPart::kGrowthBudget, "Gaussians grow up to the limit at once"},
      {GrowthPart::kWeightedDraw, "where room is short the strongest gradients grow"},
      {GrowthPart::kAbsoluteGradient, "the gradients of pixels may cancel"}};
  std::vector<Ablation> rows;
  for (const auto& [part, doc] : parts)
    rows.push_back({fmt::format("no-{}", name_of(part)),
                    fmt::format("densification budget but for a part: {}", doc),
                    joined(kFull, {{"budget_without", name_of(part)}})});
  return rows;
}

}  // namespace

const std::vector<Ablation>& ablations() {
  static const std::vector<Ablation> rows = [] {
    std::vector<Ablation> made = {{"full", "every technique", kFull},
                                  {"basis", "none of the techniques", kBasis}};
    for (const Technique& t : techniques())
      made.push_back(
          {t.without_name, fmt::format("full but for: {}", t.doc), joined(kFull, t.without)});
    for (const Technique& t : techniques())
      made.push_back({fmt::format("basis+{}", t.with_name), fmt::format("basis and: {}", t.doc),
                      joined(kBasis, t.with)});
    for (Ablation& ablation : growth_ablations()) made.push_back(std::move(ablation));
    return made;
  }();
  return rows;
}

void apply_ablation(TrainOptions& options, const std::string& name) {
  apply_named(options, ablations(), "ablation", name);
}

}  // namespace tessera
