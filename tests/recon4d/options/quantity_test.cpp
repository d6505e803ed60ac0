// Numbers with suffixes.
#include "recon4d/options/option_value.h"

#include <gtest/gtest.h>

#include "recon4d/options/train_options.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {
namespace {

// Bugs put back, each seen to fail: a blank before the unit is an error; "500ms" is 500 minutes.
TEST(Quantity, BlanksCaseAndMilliseconds) {
  EXPECT_EQ(parse_quantity("500ms", Unit::kSeconds), 0.5);
  EXPECT_EQ(parse_quantity("500 ms", Unit::kSeconds), 0.5);
  EXPECT_EQ(parse_quantity("1h 30 m", Unit::kSeconds), 5400);
  EXPECT_EQ(parse_quantity("5 MB", Unit::kBytes), 5000000);
  EXPECT_EQ(parse_quantity("5 mb", Unit::kBytes), 5000000);
  EXPECT_EQ(parse_quantity("5  mib", Unit::kBytes), 5 << 20);
  EXPECT_EQ(parse_quantity("10 k", Unit::kCount), 10000);
}

// Bugs put back: "5MB" read as 5 MiB; "1h30" read as 1.5 h; each seen to fail.
TEST(Quantity, Suffixes) {
  EXPECT_EQ(parse_quantity("10k", Unit::kCount), 10000);
  EXPECT_EQ(parse_quantity("1.5M", Unit::kCount), 1500000);
  EXPECT_EQ(parse_quantity("7", Unit::kCount), 7);
  EXPECT_EQ(parse_quantity("500kB", Unit::kBytes), 500000);
  EXPECT_EQ(parse_quantity("5MB", Unit::kBytes), 5000000);
  EXPECT_EQ(parse_quantity("5MiB", Unit::kBytes), 5 << 20);
  EXPECT_EQ(parse_quantity("90s", Unit::kSeconds), 90);
  EXPECT_EQ(parse_quantity("90", Unit::kSeconds), 90);
  EXPECT_EQ(parse_quantity("2h", Unit::kSeconds), 7200);
  EXPECT_EQ(parse_quantity("1h30m", Unit::kSeconds), 5400);
  for (const char* text :
       {"", "k", "10q", "10 ", " 10", "1 h 30", "1h30 ", "1h30", "10kk", "1e9999", "nan", "--5"})
    for (const Unit unit : {Unit::kCount, Unit::kBytes, Unit::kSeconds})
      EXPECT_FALSE(parse_quantity(text, unit)) << text;
  EXPECT_FALSE(parse_quantity("5MB", Unit::kCount));
  EXPECT_FALSE(parse_quantity("10k", Unit::kNone));
}

TEST(Quantity, OfOptions) {
  TrainOptions options;
  set_option_from_text(options, "max_gaussians", "10k");
  EXPECT_EQ(options.max_gaussians, 10000);
  set_option_from_text(options, "max_bytes", "5MB");
  EXPECT_EQ(options.max_bytes, 5000000);
  set_option_from_text(options, "iterations", "1.5k");
  EXPECT_EQ(options.iterations, 1500);
  expect_input_error([&] { set_option_from_text(options, "iterations", "1.0005k"); },
                     {"iterations", "whole number"});
  expect_input_error([&] { set_option_from_text(options, "max_bytes", "5TB"); },
                     {"max_bytes", "5TB", "5MB"});
  expect_input_error([&] { set_option_from_text(options, "seed", "1k"); }, {"seed"});
}

// Bug put back: names compared with regard to case; seen to fail.
TEST(Choices, AreComparedWithoutCase) {
  TrainOptions options;
  set_option_from_text(options, "motion", "Velocity");
  EXPECT_EQ(options.motion, Motion::kVelocity);
  set_option_from_text(options, "densification", "MCMC");
  EXPECT_EQ(options.densification, Densification::kMcmc);
}

}  // namespace
}  // namespace tessera::testing
