// The option table: setting by JSON and by text, messages, round trip, presets.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "kernels/base/errors.h"
#include "recon4d/options/nearest_name.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options_json.h"

namespace tessera {
namespace {

using nlohmann::json;

/// The message of a refused call; empty when the call succeeds.
template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}
std::string refusal_of(const std::string& key, const json& value) {
  TrainOptions options;
  return refusal([&] { set_option_from_json(options, key, value); });
}
void expect_says(const std::string& message, std::initializer_list<std::string> parts) {
  for (const std::string& part : parts)
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' in: " << message;
}

/// A value inside the range of the option that is not the default.
json another_value(const TrainOption& option) {
  const json usual = to_json(TrainOptions{})[option.key];
  if (usual.is_boolean()) return !usual.get<bool>();
  if (usual.is_string() && !option.choices().empty())
    return usual == option.choices()[0] ? option.choices()[1] : option.choices()[0];
  if (usual.is_string()) return "10,20,30";
  if (const int64_t least = std::max<int64_t>(2, int64_t(option.low)); usual.is_number_integer())
    return usual.get<int64_t>() == least ? least + 1 : least;
  const double value = usual.get<double>();
  return value > option.low ? (option.low + value) / 2 : (option.high + value) / 2;
}

TEST(TrainOptions, EveryRowIsSetByJsonAndByText) {
  for (const TrainOption& option : train_option_table()) {
    const json value = another_value(option);
    TrainOptions by_json, by_text;
    set_option_from_json(by_json, option.key, value);
    set_option_from_text(by_text, option.key,
                         value.is_string() ? value.get<std::string>() : value.dump());
    json expected = to_json(TrainOptions{});
    ASSERT_NE(expected[option.key], value) << option.key;
    expected[option.key] = value;
    EXPECT_EQ(to_json(by_json), expected) << option.key;
    EXPECT_EQ(to_json(by_text), expected) << option.key;
  }
}

TEST(TrainOptions, RowsAreDocumentedAndDistinct) {
  std::set<std::string> keys;
  for (const TrainOption& option : train_option_table()) {
    EXPECT_TRUE(keys.insert(option.key).second) << option.key;
    EXPECT_NE(std::string(option.doc), "") << option.key;
    EXPECT_NE(std::string(option.source), "") << option.key;
    EXPECT_EQ(std::string(option.key).find_first_not_of("abcdefghijklmnopqrstuvwxyz_23"),
              std::string::npos);
    TrainOptions options;
    EXPECT_NO_THROW(set_option_from_json(options, option.key, to_json(options)[option.key]))
        << option.key << ": the default is outside its own range";
  }
}

TEST(TrainOptions, RangesAreInclusiveAndNamed) {
  for (const TrainOption& option : train_option_table()) {
    const json usual = to_json(TrainOptions{})[option.key];
    if (!usual.is_number()) continue;
    EXPECT_EQ(refusal_of(option.key, option.low), "") << option.key;
    EXPECT_EQ(refusal_of(option.key, option.high), "") << option.key;
    const double step = usual.is_number_integer() ? 1 : option.high * 1e-6;
    expect_says(refusal_of(option.key, option.low - step), {option.key, "expected", option.doc});
    expect_says(refusal_of(option.key, option.high + step), {option.key, "expected", option.doc});
  }
  expect_says(refusal_of("batch", 0), {"'batch' is 0", "1 to 1024"});
  // Bug put back: unsigned JSON numbers read as signed; seen to fail with "'seed' is -1".
  expect_says(refusal_of("seed", UINT64_MAX), {"'seed'", "1.8446744073709552e+19"});
}

TEST(TrainOptions, WrongTypesAreRefused) {
  expect_says(refusal_of("batch", 2.5), {"'batch'", "2.5", "a whole number"});
  expect_says(refusal_of("batch", "4"), {"\"4\"", "a whole number"});
  expect_says(refusal_of("batch", 1e300), {"a whole number"});
  expect_says(refusal_of("batch", true), {"true", "a whole number"});
  expect_says(refusal_of("lr_mean", "small"), {"\"small\"", "a number"});
  expect_says(refusal_of("lr_mean", nullptr), {"null", "a number"});
  expect_says(refusal_of("carve", 1), {"'carve' is 1", "true or false"});
  expect_says(refusal_of("background", 255), {"255", "text"});
  EXPECT_EQ(refusal_of("iterations", 3e4), "") << "3e4 is a whole number";
  for (const char* text : {"", "4 4", "1e400", "nan", "-", "[4]"}) {
    TrainOptions options;
    EXPECT_NE(refusal([&] { set_option_from_text(options, "lr_mean", text); }), "") << text;
  }
}

// Bug put back: any text is taken; seen to fail.
TEST(TrainOptions, TextsOfASetAreChecked) {
  for (const TrainOption& option : train_option_table())
    for (const char* choice : option.choices())
      EXPECT_EQ(refusal_of(option.key, choice), "") << choice;
  expect_says(refusal_of("idle_updates", "densed"),
              {"'idle_updates' is 'densed'", "did you mean 'dense'", "dense, skip"});
  expect_says(refusal_of("backward", "sub-tle"), {"did you mean 'sub-tile'"});
  expect_says(refusal_of("idle_updates", true), {"true", "text"});
}

TEST(TrainOptions, UnknownKeysSuggestTheNearest) {
  expect_says(refusal_of("itterations", 5), {"'itterations'", "did you mean 'iterations'"});
  expect_says(refusal_of("lr-mean", 5), {"did you mean 'lr_mean'"});
  TrainOptions options;
  expect_says(refusal([&] { set_option_from_text(options, "max_gausians", "5"); }),
              {"did you mean 'max_gaussians'"});
  expect_says(refusal([&] { train_options_from_json({{"sed", 5}}); }), {"did you mean 'seed'"});
  EXPECT_NE(refusal([&] { train_options_from_json(json::array({1})); }), "");
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(nearest_name("x", {}), "");
}

// Bugs put back, each seen to fail: any distance is near; neighbours that changed places are two
// mistakes; prefixes are ignored.
TEST(TrainOptions, OnlyWhatIsNearIsSuggested) {
  const std::vector<std::string> presets{"fast", "balanced", "faster-gs"};
  EXPECT_EQ(did_you_mean("fats", presets), "; did you mean 'fast'?");
  EXPECT_EQ(did_you_mean("bal", presets), "; did you mean 'balanced'?");
  EXPECT_EQ(did_you_mean("fas", presets), "; did you mean one of fast, faster-gs?");
  EXPECT_EQ(did_you_mean("f", presets), "") << "begins too many names";
  EXPECT_EQ(did_you_mean("mcmc", presets), "");
  EXPECT_EQ(did_you_mean("--lr", {"--help", "--out"}), "") << "dashes are no letters";
  EXPECT_EQ(known_names("x", presets), "; there are fast, balanced, faster-gs");
  EXPECT_EQ(known_names("bal", presets),
            "; did you mean 'balanced'? There are fast, balanced, faster-gs");
  EXPECT_EQ(refusal_of("zzzzz", 5), "unknown option 'zzzzz'");
}

TEST(TrainOptions, JsonRoundTripsEveryBit) {
  TrainOptions options;
  for (const TrainOption& option : train_option_table())
    set_option_from_json(options, option.key, another_value(option));
  options.lr_mean = 0.1 + 0.2;  // needs 17 digits
  const json once = to_json(options);
  EXPECT_EQ(once.size(), train_option_table().size());
  const TrainOptions back = train_options_from_json(json::parse(once.dump()));
  EXPECT_EQ(to_json(back), once);
  EXPECT_EQ(back.lr_mean, options.lr_mean);
}

// Bug put back: values of a static scene set before those of the preset; seen to fail.
TEST(TrainOptions, PresetsApplyAndAreValid) {
  for (const Preset& preset : presets())
    for (const bool still : {false, true}) {
      TrainOptions options;
      apply_preset(options, preset.name, {.still = still});
      EXPECT_NO_THROW(validate(options)) << preset.name;
      json expected = to_json(TrainOptions{});
      for (const auto& [key, value] : preset.overrides) expected[key] = to_json(value);
      if (still)
        for (const auto& [key, value] : preset.still_overrides) expected[key] = to_json(value);
      EXPECT_EQ(to_json(options), expected) << preset.name;
      EXPECT_FALSE(std::string(preset.doc).empty());
    }
  TrainOptions options;
  expect_says(refusal([&] { apply_preset(options, "balancd"); }),
              {"'balancd'", "did you mean 'balanced'", "3dgs"});
}

// Bug put back: a limit of more than the preset's is taken; seen to fail.
TEST(TrainOptions, FewPixelsLowerTheLimitOfAPreset) {
  const auto limit = [](const char* preset, int64_t pixels) {
    TrainOptions options;
    apply_preset(options, preset, {.camera_pixels = pixels});
    EXPECT_EQ(options.max_gaussians, 0) << "no preset of these says how many may be shipped";
    return options.peak_gaussians;
  };
  EXPECT_EQ(limit("balanced", 0), 400000);
  EXPECT_EQ(limit("balanced", 2000000), 125000);
  EXPECT_EQ(limit("balanced", 100000000), 400000);
  EXPECT_EQ(limit("balanced", 2048), 10000);
  EXPECT_EQ(limit("fast", 2048), 40000);
  EXPECT_EQ(limit("faster-gs", 2048), 0);
}

TEST(TrainOptions, ValidateLooksAtPairs) {
  TrainOptions options;
  options.near_plane = 200;
  expect_says(refusal([&] { validate(options); }), {"near_plane 200", "far_plane 100"});
  // Bug put back: any far plane; seen to fail.
  options = {};
  options.near_plane = 1e-6;
  options.far_plane = 1e4;
  expect_says(refusal([&] { validate(options); }),
              {"far_plane 10000", "2^32 times near_plane 1e-06", "--near-plane"});
  options.far_plane = 4000;
  validate(options);
  options = {};
  options.background = "purple";
  expect_says(refusal([&] { validate(options); }), {"'purple'", "black, white or r,g,b"});
  // Bug put back: ignored; seen to fail.
  options = {};
  options.truncation_sigma = 2;  // 0.135
  expect_says(refusal([&] { validate(options); }),
              {"truncation_sigma 2", "0.1353", "start with 0.1", "--truncation-by-falloff true"});
  options.truncation_sigma = 3;  // 0.011
  EXPECT_EQ(refusal([&] { validate(options); }), "");
  options.opacity_reset_interval = 3000;
  expect_says(refusal([&] { validate(options); }), {"are reset to 0.01"});
  options.truncation_by_falloff = true;
  options.truncation_sigma = 1;
  EXPECT_EQ(refusal([&] { validate(options); }), "");
  options = {};
  options.densification = Densification::kMcmc;
  expect_says(refusal([&] { validate(options); }), {"--peak-gaussians N", "--max-gaussians N"});
  options.peak_gaussians = 100;
  EXPECT_EQ(refusal([&] { validate(options); }), "");
  options = {};
  options.idle_updates = IdleUpdate::kSkip;
  EXPECT_EQ(refusal([&] { validate(options); }), "");
  options.fused_optimizer = false;
  expect_says(refusal([&] { validate(options); }), {"skip", "needs the fused optimizer"});
}

// Bug put back: within_db not counted; seen to fail.
TEST(TrainOptions, OneContractOfSizeAtATime) {
  const auto says = [](int64_t gaussians, int64_t bytes, double decibels) {
    TrainOptions options;
    options.max_gaussians = gaussians;
    options.max_bytes = bytes;
    options.within_db = decibels;
    return refusal([&] { validate(options); });
  };
  EXPECT_EQ(says(0, 0, 0) + says(9, 0, 0) + says(0, 900, 0) + says(0, 0, 0.5), "");
  for (const std::string& refused : {says(9, 9, 0), says(9, 0, 0.5), says(0, 9, 0.5)})
    expect_says(refused, {"max_gaussians, max_bytes and within_db", "pass one"});
}

// Bug put back: any number of bytes taken; seen to fail.
TEST(TrainOptions, BytesWhoseUnitWasForgottenAreRefused) {
  TrainOptions options;
  for (const int64_t bytes : {1, 5, 499}) {
    options.max_bytes = bytes;
    const std::string number = std::to_string(bytes);
    expect_says(refusal([&] { validate(options); }), {"--max-bytes " + number, number + "MB?"});
  }
  options.max_bytes = 500;
  EXPECT_EQ(refusal([&] { validate(options); }), "");
}

// Bug put back: the smaller of the two limits; seen to fail.
TEST(TrainOptions, GrowsBeyondWhatIsAskedForAndThinsThen) {
  const auto made = [](int64_t peak, int64_t most) {
    TrainOptions options;
    options.peak_gaussians = peak;
    options.max_gaussians = most;
    return options;
  };
  EXPECT_EQ(growth_limit(made(0, 0)), 0);
  EXPECT_EQ(growth_limit(made(0, 70)), 70);
  EXPECT_EQ(growth_limit(made(500, 0)), 500);
  EXPECT_EQ(growth_limit(made(500, 70)), 500);
  EXPECT_EQ(growth_limit(made(50, 70)), 70) << "asked for, so grown to";
  EXPECT_FALSE(prunes_after_growth(made(0, 0)));
  EXPECT_FALSE(prunes_after_growth(made(0, 70))) << "grown to and no further";
  EXPECT_FALSE(prunes_after_growth(made(500, 0)));
  EXPECT_FALSE(prunes_after_growth(made(50, 70)));
  EXPECT_TRUE(prunes_after_growth(made(500, 70)));
  TrainOptions options;
  options.size = ModelSize::kKnee;
  EXPECT_TRUE(prunes_after_growth(options));
  options = {};
  options.max_bytes = 1;
  EXPECT_TRUE(prunes_after_growth(options));
  options = {};
  options.within_db = 0.1;
  EXPECT_TRUE(prunes_after_growth(options));
}

// Bug put back: one of them without decide_colour; seen to fail.
TEST(TrainOptions, PresetsForUseModelNoMoreThanASceneNeeds) {
  for (const Preset& preset : presets()) {
    TrainOptions options;
    apply_preset(options, preset.name);
    const bool ours = preset.name == "balanced" || preset.name == "best";
    EXPECT_EQ(options.size, ours ? ModelSize::kKnee : ModelSize::kGrown) << preset.name;
    EXPECT_EQ(options.decide_motion, ours) << preset.name;
    EXPECT_EQ(options.decide_colour, ours) << preset.name;
  }
}

TEST(TrainOptions, BackgroundColours) {
  using Rgb = std::array<uint8_t, 3>;
  EXPECT_EQ(parse_background("black"), (Rgb{0, 0, 0}));
  EXPECT_EQ(parse_background("white"), (Rgb{255, 255, 255}));
  EXPECT_EQ(parse_background("1,20,255"), (Rgb{1, 20, 255}));
  for (const char* text : {"", "1,2", "1,2,3,4", "256,0,0", "-1,0,0", "1,2,3 ", "White",
                           "99999999999,0,0", "4294967296,0,0"})
    EXPECT_NE(refusal([&] { parse_background(text); }), "") << text;
}

}  // namespace
}  // namespace tessera
