// The rows of the tables that the workflow carries: each can be trained.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "recon4d/options/presets.h"
#include "tools/batch/engine.h"

namespace tessera {
namespace {

using nlohmann::json;

// Bug put back: "idle_update" for idle_updates in the optimizer table; seen to fail.
TEST(BatchRows, OptionsAreKnown) {
  EXPECT_TRUE(workflow_tables().contains("optimizer"));
  for (const auto& [name, text] : workflow_tables()) {
    const json table = json::parse(text);
    EXPECT_EQ(table["name"], name);
    for (const json& row : table["rows"]) {
      TrainOptions options;
      const auto apply = [&] {
        apply_preset(options, row["preset"]);
        for (const auto& [key, value] : row["options"].items())
          if (key == "ablation")
            apply_ablation(options, value);
          else
            set_option_from_text(options, key,
                                 value.is_string() ? value.get<std::string>() : value.dump());
        validate(options);
      };
      EXPECT_NO_THROW(apply()) << name << ": " << row["name"];
    }
  }
}

}  // namespace
}  // namespace tessera
