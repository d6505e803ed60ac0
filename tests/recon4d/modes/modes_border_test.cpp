// A static background shows no border between timesteps, rendered as a whole or exported by frames.
// The clip is trained without chunks, so every pair of neighbouring frames is a border. Source:
// failure mode A13.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "static3d/formats/frame_sequence.h"
#include "static3d/formats/splat_file.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/recon4d/modes/modes_film.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

constexpr int kBelow = 34;  // rows from here on never see the ball

/// A ball crosses before the upper half of a wall.
Film wall_film() {
  Film film;
  film.timesteps = 21;
  film.world = [](double time) {
    synth::World world = even_world();
    add_solid(world, synth::ShapeKind::kBox, {0.9, 0.05, 0.8}, {0, 0.5, 0}, cold(0.15), false);
    add_solid(world, synth::ShapeKind::kSphere, glm::dvec3(0.2), {-0.4 + 0.8 * time, 0, 0.4},
              warm(0.12));
    return world;
  };
  return film;
}

/// Mean difference of neighbouring images in the rows that never change, 8-bit steps.
std::vector<double> borders(const std::vector<RenderedImage>& images) {
  std::vector<double> steps;
  for (size_t m = 1; m < images.size(); ++m) {
    const RenderedImage &a = images[m - 1], &b = images[m];
    const size_t pixels = a.alpha.size(), first = size_t(kBelow * a.width);
    double sum = 0;
    for (size_t i = 0; i < a.rgb.size(); ++i)
      if (i % pixels >= first) sum += std::abs(double(a.rgb[i]) - double(b.rgb[i]));
    steps.push_back(255 * sum / double(3 * (pixels - first)));
  }
  return steps;
}

/// The row's bound is 1.1 × the median; that of a background of static Gaussians is 0, so that
/// anything would be a border: what is far below a step of 8 bits is none.
void expect_no_border(const std::vector<RenderedImage>& images) {
  constexpr double kUnseen = 0.1;  // 8-bit steps, mean of an image
  const std::vector<double> steps = borders(images);
  std::vector<double> sorted = steps;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2];
  for (size_t m = 0; m < steps.size(); ++m)
    EXPECT_LE(steps[m], std::max(1.1 * median, kUnseen)) << "after frame " << m;
}

// Bug put back: still points start as dynamic ones; seen to fail by 0.4 steps.
TEST(Borders, OfAStillBackgroundAreNotSeen) {
  const Film film = wall_film();
  Scene scene = shoot(film);
  scene.points = surface_cloud(film, 400, 300);
  const GaussianModel model = trained(scene, short_training("balanced", 500));
  EXPECT_GT(middle_psnr(model, scene), 26);
  expect_no_border(middle_images(model, scene));
  const ScratchFolder folder;
  std::vector<double> times;
  for (const Frame* frame : held_out(scene)) times.push_back(frame->time);
  export_sequence(model, folder.path(), times, splat_format("ply"));
  std::vector<RenderedImage> exported;
  for (size_t m = 0; m < times.size(); ++m) {
    SplatFile frame = load_splat_file(folder / fmt::format("frame_{:04}.ply", m));
    exported.push_back(render_one(static_model(model, std::move(frame.set)),
                                  {held_out(scene)[m]->camera, times[m]}));
  }
  expect_no_border(exported);
}

}  // namespace
}  // namespace tessera::testing
