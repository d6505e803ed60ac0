// The .splatv format: the values that players compute from its words at a timestep are those of the
// model. Source: formats 2: the layout and the player's shader.
#include "static3d/formats/splatv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/packing.hpp>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/math/rotation3.h"
#include "kernels/math/spherical_harmonics.h"
#include "kernels/math/splat.h"
#include "static3d/transform/slicer.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

struct SplatvFile {
  nlohmann::json chunk;
  std::vector<std::array<uint32_t, 16>> rows;
};

SplatvFile read_splatv(const std::filesystem::path& path) {
  const std::string file = read_text_file(path);
  ByteReader bytes(file, path);
  EXPECT_EQ(bytes.number<uint32_t>(), 0x674bu);
  const auto text = bytes.number<uint32_t>();
  const auto chunks = nlohmann::json::parse(bytes.take(text));
  EXPECT_EQ(chunks.size(), 1u);
  SplatvFile read{chunks[0], {}};
  EXPECT_EQ(read.chunk["size"].get<uint64_t>(), bytes.left());
  EXPECT_EQ(bytes.left(), 16 * 4096 * read.chunk["texheight"].get<uint64_t>());
  while (bytes.left() > 0) {
    read.rows.emplace_back();
    for (uint32_t& word : read.rows.back()) word = bytes.number<uint32_t>();
  }
  return read;
}

/// A Gaussian of the file at a timestep, as the players' shader has it.
struct Shown {
  double mean[3], opacity, rgb[3];
  Sym3<double> covariance;
};

std::pair<double, double> halves(uint32_t word) {
  const glm::vec2 pair = glm::unpackHalf2x16(word);
  return {pair.x, pair.y};
}

Shown shown_at(const std::array<uint32_t, 16>& row, double time) {
  Shown shown{};
  const auto [centre, width] = halves(row[15]);
  const double dt = time - centre;
  const auto [vx, vy] = halves(row[8]);
  const double velocity[] = {vx, vy, halves(row[9]).first};
  for (size_t k = 0; k < 3; ++k) {
    float x;
    std::memcpy(&x, &row[k], sizeof x);
    shown.mean[k] = double(x) + velocity[k] * dt;
    shown.rgb[k] = double(row[7] >> (8 * k) & 255) / 255;
  }
  const double falloff = std::exp(-std::pow(dt / width, 2));
  shown.opacity = falloff < 0.02 ? 0 : falloff * double(row[7] >> 24) / 255;
  const auto [qw, qx] = halves(row[3]);
  const auto [qy, qz] = halves(row[4]);
  const auto [sx, sy] = halves(row[5]);
  const double sz = halves(row[6]).first;
  shown.covariance = rotate_diagonal(rotation_matrix(Vec4<double>(qw, qx, qy, qz)),
                                     Vec3<double>(sx * sx, sy * sy, sz * sz));
  return shown;
}

/// The row of a slice whose mean is nearest.
int64_t nearest(const GaussianSet& slice, const double (&mean)[3]) {
  int64_t best = 0;
  double least = INFINITY;
  for (int64_t n = 0; n < slice.count(); ++n) {
    const float* const m = slice.values().at(kMean, n);
    const double distance = std::hypot(m[0] - mean[0], m[1] - mean[1], m[2] - mean[2]);
    if (distance < least) {
      least = distance;
      best = n;
    }
  }
  return best;
}

void expect_shown(const Shown& a, const GaussianSet& slice, double speed) {
  const int64_t n = nearest(slice, a.mean);
  const GaussianSpans<const float> b = slice.values();
  constexpr double kHalf = 0x1p-11;  // relative, of a half float
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(a.mean[k], b.at(kMean, n)[k], 1e-5 + kHalf * speed);
    EXPECT_NEAR(a.rgb[k], std::clamp(0.5 + kSh0 * double(b.at(kSh, n)[k]), 0.0, 1.0), 0.51 / 255);
  }
  // half a step of opacity; of the falloff exp(−x²): 2x·dx, time and width rounded
  EXPECT_NEAR(a.opacity, sigmoid(double(*b.at(kOpacityLogit, n))), 0.51 / 255 + 0.01);
  const float* const s = b.at(kLogScale, n);
  const float* const q = b.at(kRotation, n);
  const Sym3<double> expected =
      rotate_diagonal(rotation_matrix(Vec4<double>(q[0], q[1], q[2], q[3])),
                      variances(Vec3<double>(s[0], s[1], s[2])));
  const double size = expected.xx + expected.yy + expected.zz;
  for (const auto member : {&Sym3<double>::xx, &Sym3<double>::xy, &Sym3<double>::xz,
                            &Sym3<double>::yy, &Sym3<double>::yz, &Sym3<double>::zz})
    EXPECT_NEAR(a.covariance.*member, expected.*member, 8 * kHalf * size);
}

double fastest(const GaussianModel& model) {
  double speed = 0;
  const Slicer slicer(model);
  for (const MovingGaussian& g : slicer.moving())
    speed = std::max(speed, double(glm::length(g.spacetime.velocity)));
  return speed;
}

// Bugs put back: the width without √2; motion from word 9 on; red in the highest byte. Each seen to
// fail.
TEST(Splatv, ShowsTheModelAtEveryTimestep) {
  const ScratchFolder folder;
  for (SetForm form : {SetForm::kPair, SetForm::kVelocity}) {
    const GaussianModel model = random_model(30, 60, 5, 16, form);
    const SplatvReport report = save_splatv(folder / "a.splatv", model, {splatv_camera(model)});
    EXPECT_EQ(report.non_finite, 0);
    EXPECT_EQ(report.bytes, int64_t(std::filesystem::file_size(folder / "a.splatv")));
    const SplatvFile read = read_splatv(folder / "a.splatv");
    ASSERT_EQ(read.rows.size(), 1024u);
    const Slicer slicer(model);
    const double speed = fastest(model);
    for (double time : {0.0, 0.37, 1.0}) {
      SCOPED_TRACE(time);
      const GaussianSet slice = slicer.at(time);
      int64_t drawn = 0;
      for (const auto& row : read.rows) {
        const Shown shown = shown_at(row, time);
        // what we do not draw any more (p < 0.05, o·p < 1/255), and rounding
        if (shown.opacity < 0.06) continue;
        expect_shown(shown, slice, speed);
        ++drawn;
      }
      EXPECT_GT(drawn, 40);
      EXPECT_LE(drawn, slice.count());
    }
  }
}

// The timestep of greatest opacity is a half float: off by up to 2⁻¹¹ of the clip.
// Bug put back: the mean as at present before it is rounded; seen to fail.
TEST(Splatv, RoundingTimeMovesNothing) {
  const ScratchFolder folder;
  const GaussianModel model = random_model(0, 40, 5, 1, SetForm::kVelocity);
  save_splatv(folder / "a.splatv", model, {splatv_camera(model)});
  const SplatvFile read = read_splatv(folder / "a.splatv");
  const Slicer slicer(model);
  double farthest = 0;  // that rounding time alone would move one
  for (size_t n = 0; n < slicer.moving().size(); ++n) {
    const MovingGaussian& g = slicer.moving()[n];
    const double time = g.spacetime.mean_time;
    const Shown shown = shown_at(read.rows[n], time);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(shown.mean[k], g.mean[k], 1e-6) << n;
    farthest = std::max(farthest, std::abs(halves(read.rows[n][15]).first - time) *
                                      double(glm::length(g.spacetime.velocity)));
  }
  EXPECT_GT(farthest, 1e-4);
}

// Levels of time: the colour is that of the timestep at which a Gaussian is brightest.
// Bug put back: levels left out; seen to fail.
TEST(Splatv, BakesColoursThatFollowTime) {
  const ScratchFolder folder;
  const GaussianModel model = random_model_in_time(0, 20, 2);
  save_splatv(folder / "a.splatv", model, {splatv_camera(model)});
  const SplatvFile read = read_splatv(folder / "a.splatv");
  size_t row = 0;
  const Slicer slicer(model);
  for (const MovingGaussian& g : slicer.moving()) {
    const double centre = std::clamp(g.spacetime.mean_time, 0.0f, 1.0f);
    const GaussianSet slice = slicer.at(centre);
    const Shown shown = shown_at(read.rows[row++], centre);
    const int64_t n = nearest(slice, shown.mean);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(shown.rgb[c],
                  std::clamp(0.5 + kSh0 * double(slice.values().at(kSh, n)[c]), 0.0, 1.0),
                  0.51 / 255);
  }
  EXPECT_EQ(row, 20u);
}

// Bugs put back: the texture not filled up to whole rows; unsound Gaussians written. Seen to fail.
TEST(Splatv, FillsRowsAndLeavesOutWhatIsNotDrawn) {
  const ScratchFolder folder;
  GaussianModel model = random_model(1025, 4, 5, 1, SetForm::kVelocity);
  *model.static_set.values().at(kOpacityLogit, 7) = NAN;
  *model.dynamic_set.values().at(kSh, 2) = NAN;
  *model.dynamic_set.values().at(kMeanTime, 1) = 90;  // long after the clip
  const SplatvReport report = save_splatv(folder / "a.splatv", model, {splatv_camera(model)});
  EXPECT_EQ(report.gaussians, 1026);
  EXPECT_EQ(report.non_finite, 2);
  EXPECT_EQ(report.never_drawn, 1);
  const SplatvFile read = read_splatv(folder / "a.splatv");
  EXPECT_EQ(read.chunk["texwidth"], 4096);
  EXPECT_EQ(read.chunk["texheight"], 2);
  for (size_t n = 1026; n < read.rows.size(); ++n)
    for (double time : {0.0, 1.0}) EXPECT_EQ(shown_at(read.rows[n], time).opacity, 0) << n;
}

// Bug put back: camera from world instead of world from camera; seen to fail.
TEST(Splatv, CamerasLookAlongTheirThirdColumn) {
  const ScratchFolder folder;
  const GaussianModel model = random_model(3, 0);
  const Camera camera = look_at({2, -1, -3}, {0, 0.5, 0}, 64, 48, 50);
  save_splatv(folder / "a.splatv", model, {{"left", camera}});
  const nlohmann::json stated = read_splatv(folder / "a.splatv").chunk["cameras"][0];
  EXPECT_EQ(stated["img_name"], "left");
  EXPECT_EQ(stated["fx"], 50);
  const glm::dvec3 forward = glm::normalize(glm::dvec3(0, 0.5, 0) - glm::dvec3(2, -1, -3));
  const glm::dvec3 eye = camera.position();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(stated["rotation"][size_t(k)][2].get<double>(), forward[k], 1e-12);
    EXPECT_NEAR(stated["position"][size_t(k)].get<double>(), eye[k], 1e-12);
  }
  const Camera ours = splatv_camera(model).camera;
  EXPECT_LT(ours.position().z, 0) << "in front of the scene, along +z";
}

}  // namespace
}  // namespace tessera::testing
