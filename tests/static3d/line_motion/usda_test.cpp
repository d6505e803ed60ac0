// The text for OpenUSD: rows of attributes by a reader of these lines alone, against what is drawn.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "ingest/files/atomic_file.h"
#include "static3d/transform/slicer.h"
#include "tests/static3d/line_motion/some_clip.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

/// The numbers of "NAME = [...]" or, at a time code, "CODE: [...]" behind NAME.timeSamples.
std::vector<double> numbers_of(const std::string& prim, const std::string& name,
                               const std::string& code = "") {
  size_t place = prim.find(name + (code.empty() ? " = " : ".timeSamples = {"));
  EXPECT_NE(place, std::string::npos) << name;
  if (!code.empty()) place = prim.find("        " + code + ": [", place);
  EXPECT_NE(place, std::string::npos) << name << " at " << code;
  const size_t begin = prim.find('[', prim.find(code.empty() ? " = " : ": ", place));
  std::string text = prim.substr(begin, prim.find(']', begin) - begin);
  for (char& letter : text)
    if (std::string("[](),").find(letter) != std::string::npos) letter = ' ';
  std::istringstream words(text);
  std::vector<double> numbers;
  for (double number; words >> number;) numbers.push_back(number);
  return numbers;
}

std::string prim_of(const std::string& text, const std::string& name) {
  const size_t begin = text.find(fmt::format("def ParticleField3DGaussianSplat \"{}\"", name));
  return begin == std::string::npos ? "" : text.substr(begin, text.find("\n}\n", begin) - begin);
}

// Bugs put back, each seen to fail: quaternions with w last; y and z not turned; velocities per
// frame; logarithms of scales.
TEST(Usda, IsInterpolatedByUsdAsWeDraw) {
  const ScratchFolder folder;
  const GaussianModel model = some_clip(4);
  save_lines(folder / "a.usda", model, 4);
  const std::string text = read_text_file(folder / "a.usda");
  EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
  for (const char* line : {"defaultPrim = \"Clip\"", "upAxis = \"Y\"", "endTimeCode = 20",
                           "timeCodesPerSecond = 4", "metersPerUnit = 1"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
  const std::string still = prim_of(text, "Still"), moving = prim_of(text, "Moving");
  const GaussianSpans<const float> fixed = std::as_const(model.static_set).values();
  const std::vector<double> rotations = numbers_of(still, "quatf[] orientations"),
                            places = numbers_of(still, "point3f[] positions"),
                            scales = numbers_of(still, "float3[] scales"),
                            sh = numbers_of(still, "radiance:sphericalHarmonicsCoefficients");
  ASSERT_EQ(rotations.size(), 12u);
  ASSERT_EQ(sh.size(), 36u);
  EXPECT_NE(still.find("int radiance:sphericalHarmonicsDegree = 1"), std::string::npos);
  for (size_t n = 0; n < 3; ++n) {
    const auto row = int64_t(n);
    EXPECT_NEAR(places[3 * n], fixed.at(kMean, row)[0], 1e-5);
    EXPECT_NEAR(places[3 * n + 1], -fixed.at(kMean, row)[1], 1e-5);
    EXPECT_NEAR(scales[3 * n + 2], std::exp(fixed.at(kLogScale, row)[2]), 1e-5);
    EXPECT_NEAR(std::abs(rotations[4 * n]), std::abs(fixed.at(kRotation, row)[0]), 1e-5);
    EXPECT_NEAR(sh[12 * n], fixed.at(kSh, row)[0], 1e-5);
    EXPECT_NEAR(sh[12 * n + 3], -fixed.at(kSh, row)[3], 1e-5) << "y of the first degree";
  }
  const Slicer slicer(model);
  const std::vector<double> first = numbers_of(moving, "point3f[] positions", "0"),
                            last = numbers_of(moving, "point3f[] positions", "20");
  for (const int frame : {0, 7, 20}) {
    const double t = frame / 20.0;
    const std::vector<double> opacities =
        numbers_of(moving, "float[] opacities", std::to_string(frame));
    ASSERT_EQ(opacities.size(), 7u);
    for (const MovingGaussian& line : slicer.moving()) {
      const auto n = size_t(line.source);
      const double dt = t - double(*model.dynamic_set.values().at(kMeanTime, line.source));
      const float* const v = model.dynamic_set.values().at(kVelocity, line.source);
      EXPECT_NEAR(first[3 * n] + t * (last[3 * n] - first[3 * n]), double(line.mean.x) + v[0] * dt,
                  1e-4);
      EXPECT_NEAR(first[3 * n + 2] + t * (last[3 * n + 2] - first[3 * n + 2]),
                  -(double(line.mean.z) + v[2] * dt), 1e-4);
      const double opacity =
          double(line.opacity) * std::exp(-0.5 * dt * dt * double(line.spacetime.precision_time));
      EXPECT_NEAR(opacities[n], opacity < 1 / 255.0 ? 0 : opacity, 1e-5);
    }
  }
}

TEST(Usda, OfOneTimestepHasNoSamples) {
  const ScratchFolder folder;
  const GaussianModel model = some_clip(1, 3, 0);
  save_lines(folder / "a.usda", model);
  const std::string text = read_text_file(folder / "a.usda");
  EXPECT_EQ(text.find("timeSamples"), std::string::npos);
  EXPECT_NE(text.find("endTimeCode = 0\n"), std::string::npos);
  EXPECT_EQ(numbers_of(prim_of(text, "Still"), "float[] opacities").size(), 3u);
}

}  // namespace
}  // namespace tessera::testing
