// The rows of the ablation table: each is known and changes an option, and a technique removed from
// full or added to basis changes the options of its name.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "kernels/base/errors.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"

namespace tessera {
namespace {

using nlohmann::json;

json options_of(const std::string& name, const std::string& preset = "balanced") {
  TrainOptions options;
  apply_preset(options, preset);
  if (!name.empty()) apply_ablation(options, name);
  EXPECT_NO_THROW(validate(options)) << name;
  return to_json(options);
}

/// Keys in which two sets of options differ.
std::set<std::string> difference(const json& a, const json& b) {
  std::set<std::string> keys;
  for (const auto& [key, value] : a.items())
    if (value != b.at(key)) keys.insert(key);
  return keys;
}

// Bug put back: a row with the value of full ("no-warp-culling" with true); seen to fail.
TEST(Ablations, EachRowIsKnownAndChangesAnOption) {
  std::set<std::string> names;
  for (const Ablation& row : ablations()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_FALSE(row.doc.empty()) << row.name;
    const bool added = row.name.starts_with("basis+");
    const char* base = row.name == "full" || row.name == "basis" ? "" : added ? "basis" : "full";
    for (const Preset& preset : presets()) {
      // these presets are the full method already
      if (row.name == "full" && options_of("", preset.name).at("idle_updates") == "dense") continue;
      EXPECT_FALSE(
          difference(options_of(row.name, preset.name), options_of(base, preset.name)).empty())
          << row.name << " of " << preset.name;
    }
  }
  for (const char* name :
       {"full", "basis", "no-rectangular-bounds", "no-opacity-bounds", "no-balanced-instances",
        "no-separate-sort", "no-warp-culling", "pixel-backward", "no-fused-optimizer", "no-z-order",
        "skip-invisible", "basis+rectangular-bounds", "basis+fused-optimizer", "basis+z-order"})
    EXPECT_TRUE(names.count(name)) << name;
}

TEST(Ablations, FullAndBasisAreOppositeEnds) {
  using Keys = std::set<std::string>;
  EXPECT_EQ(difference(options_of("full", "3dgs"), options_of("", "3dgs")), Keys{"idle_updates"});
  EXPECT_EQ(difference(options_of("full"), options_of("basis")),
            (Keys{"rectangular_bounds", "opacity_bounds", "balanced_instances", "separate_sort",
                  "warp_culling", "backward", "fused_optimizer", "reorder_interval"}));
  EXPECT_EQ(difference(options_of("no-warp-culling"), options_of("full")), Keys{"warp_culling"});
  EXPECT_EQ(difference(options_of("no-fused-optimizer"), options_of("full")),
            Keys{"fused_optimizer"});
  EXPECT_EQ(difference(options_of("basis+skip-invisible"), options_of("basis")),
            (Keys{"fused_optimizer", "idle_updates"}));
}

TEST(Ablations, UnknownNamesSuggestTheNearest) {
  TrainOptions options;
  try {
    apply_ablation(options, "no-warp-cullling");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    for (const char* part : {"'no-warp-cullling'", "did you mean 'no-warp-culling'", "basis+"})
      EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  EXPECT_EQ(to_json(options), to_json(TrainOptions{}));
}

}  // namespace
}  // namespace tessera
