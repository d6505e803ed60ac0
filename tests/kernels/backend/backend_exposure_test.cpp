// Colour maps of images in the loss of every backend, against the oracle and against the loss of
// images that were mapped by hand, on images that span many tiles of the loss, with and without
// masks. Equal inputs give equal bits. Source: failure mode B10.
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/colour_maps.h"
#include "tests/support/stage_run.h"

namespace tessera::testing {
namespace {

class BackendExposure : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendExposure);

TestScene<double> mapped_scene(uint64_t seed, bool masked) {
  TestScene<double> scene = large_scene(seed);
  Random random(seed + 3);
  for (size_t b = 0; b < scene.views.size(); ++b) {
    scene.maps.push_back(random_colour_map(random));
    scene.mask.emplace_back();
    for (size_t p = 0; p < scene.truth[b].size() / 3 && masked && b != 1; ++p)
      scene.mask.back().push_back(random.below(5) > 0 ? 255 : 0);
  }
  keep_truth_away(scene, seed + 4);
  return scene;
}

/// The stages of the loss alone, on images that lie in the backend's memory.
struct LossOf {
  std::vector<float> d_colour;
  StepOutcome outcome;

  LossOf(const TestScene<float>& scene, const std::vector<float>& colour, Backend& backend) {
    const StoredScene<float> in(scene, backend.memory());
    const ViewBatch<float> batch = make_view_batch<float>(scene.views);
    const Buffer<float> rendered = stored(colour, backend.memory());
    Buffer<float> gradient(int64_t(colour.size()), backend.memory()), mapped(backend.memory());
    const Target target = in.target();
    backend.photometric({&batch, compared_images(backend, batch, target, rendered.span(), mapped),
                         target.truth, target.weights, target.mask},
                        gradient.span());
    if (!target.maps.empty())
      backend.map_colours_backward({&batch, target.maps, rendered.span()}, gradient.span());
    d_colour = fetched(gradient, backend.memory());
    outcome = backend.outcome();
  }
};

/// `body(view, place of its first pixel's red, pixels of the view, pixel)` for every pixel.
template <class Body>
void for_each_pixel(const std::vector<View>& views, Body&& body) {
  const ViewBatch<float> batch = make_view_batch<float>(views);
  for (size_t b = 0; b < views.size(); ++b) {
    const ViewArgs<float>& view = batch.views[b];
    const int64_t pixels = int64_t(view.width) * view.height;
    for (int64_t p = 0; p < pixels; ++p) body(b, size_t(3 * view.first_pixel + p), size_t(pixels));
  }
}

Vec3<double> colour_at(const std::vector<float>& image, size_t red, size_t pixels) {
  return {image[red], image[red + pixels], image[red + 2 * pixels]};
}

// With a map or on images that were mapped beforehand: the same loss. The matrix is applied here
// element by element: x_i = Σ_j A_ij c_j + o_i, where glm has A_ij at [j][i].
// Bugs put back, each seen to fail on the CPU: A in the place of its transpose on the way back;
// dL/dA transposed; maps of the next view; the offset left out of the image; the last pixels left
// out of the sums.
TEST_P(BackendExposure, IsTheLossOfTheProduct) {
  TestScene<float> scene = mapped_scene(75, true).as<float>();
  const std::vector<float> colour = run_stages(scene, backend()).colour;
  const std::vector<ColourMap<double>> maps = scene.maps;
  std::vector<float> product = colour;
  for_each_pixel(scene.views, [&](size_t b, size_t red, size_t pixels) {
    const Vec3<double> c = colour_at(colour, red, pixels);
    for (int i = 0; i < 3; ++i) {
      double x = maps[b].offset[i];
      for (int j = 0; j < 3; ++j) x += maps[b].matrix[j][i] * c[j];
      product[red + size_t(i) * pixels] = float(x);
    }
  });
  const LossOf with(scene, colour, backend());
  scene.maps.clear();
  const LossOf by_hand(scene, product, backend());
  std::vector<float> expected = by_hand.d_colour;
  std::vector<ColourMap<double>> d_maps(scene.views.size(), {Mat3<double>(0), Vec3<double>(0)});
  for_each_pixel(scene.views, [&](size_t b, size_t red, size_t pixels) {
    const Vec3<double> c = colour_at(colour, red, pixels);
    const Vec3<double> d = colour_at(by_hand.d_colour, red, pixels);
    for (int j = 0; j < 3; ++j) {
      double d_c = 0;
      for (int i = 0; i < 3; ++i) {
        d_c += maps[b].matrix[j][i] * d[i];
        d_maps[b].matrix[j][i] += c[j] * d[i];
      }
      d_maps[b].offset[j] += d[j];
      expected[red + size_t(j) * pixels] = float(d_c);
    }
  });
  expect_group(with.d_colour, expected, {1e-4, 1e-4, 0, 1e-5}, "image");
  ASSERT_EQ(with.outcome.d_maps.size(), scene.views.size());
  for (size_t b = 0; b < scene.views.size(); ++b) {
    EXPECT_NEAR(with.outcome.losses[b].total, by_hand.outcome.losses[b].total, 1e-6);
    const std::array<double, 12> found = numbers_of(std::as_const(with.outcome.d_maps[b])),
                                 sums = numbers_of(std::as_const(d_maps[b]));
    for (size_t i = 0; i < 12; ++i)
      EXPECT_NEAR(found[i], sums[i], 1e-4 * std::abs(sums[i]) + 1e-7) << b << ", " << i;
  }
}

// For a device's kernels; the oracle is the CPU's own code, which the test above and
// exposure_test.cpp test.
// Bug put back: sums that begin where those of the last call ended; seen to fail on the CPU.
TEST_P(BackendExposure, LossAndGradientsEqualTheOracles) {
  for (const bool masked : {false, true}) {
    SCOPED_TRACE(masked);
    const TestScene<double> scene = mapped_scene(73, masked);
    CpuBackend<double> oracle;
    const StageRun<double> oracles = run_stages(scene, oracle);
    const Backward<double> expected = backward(scene);
    const Backward<float> actual = backward(scene.as<float>(), backend());
    EXPECT_EQ(actual.bad, 0u);
    ASSERT_EQ(actual.d_maps.size(), scene.views.size());
    std::vector<double> d_maps[2];
    for (size_t b = 0; b < scene.views.size(); ++b) {
      EXPECT_NEAR(actual.losses[b].l1, expected.losses[b].l1,
                  5e-6);  // as backend_gradient_test.cpp
      EXPECT_NEAR(actual.losses[b].ssim, expected.losses[b].ssim, 2e-5);
      for (const double d : numbers_of(actual.d_maps[b])) d_maps[0].push_back(d);
      for (const double d : numbers_of(expected.d_maps[b])) d_maps[1].push_back(d);
    }
    expect_group(d_maps[0], d_maps[1], {2e-4, 2e-4, 0, 2e-4}, "maps");
    // of the oracle's own images, so that no pixel is decided otherwise
    const LossOf stages(scene.as<float>(), {oracles.colour.begin(), oracles.colour.end()},
                        backend());
    expect_group(stages.d_colour, oracles.d_colour, {1e-4, 1e-4, 0, 1e-5}, "image");
    for (int g = 0; g < kGroupCount; ++g)
      expect_group(actual.moving.group[g], expected.moving.group[g], kGradientBounds,
                   group_name(Group(g), SetForm::kPair));
  }
}

// Bug put back: an offset of 1e-4 added; seen to fail on the CPU.
TEST_P(BackendExposure, IdentityIsNone) {
  TestScene<float> scene = mapped_scene(77, true).as<float>();
  scene.maps.clear();
  const StageRun<float> without = run_stages(scene, backend());
  EXPECT_TRUE(without.d_maps.empty());
  scene.maps.resize(scene.views.size());
  const StageRun<float> with = run_stages(scene, backend());
  ASSERT_EQ(with.d_maps.size(), scene.views.size());
  EXPECT_EQ(with.d_colour, without.d_colour);
  for (size_t b = 0; b < scene.views.size(); ++b)
    EXPECT_EQ(with.losses[b].total, without.losses[b].total);
}

// Bug put back: sums that begin where those of the last call ended; seen to fail on the CPU.
TEST_P(BackendExposure, EqualInputsGiveEqualBits) {
  const TestScene<float> scene = mapped_scene(79, true).as<float>();
  const StageRun<float> one = run_stages(scene, backend()), other = run_stages(scene, backend());
  EXPECT_EQ(one.d_colour, other.d_colour);
  ASSERT_EQ(one.d_maps.size(), scene.views.size());
  for (size_t b = 0; b < scene.views.size(); ++b)
    EXPECT_EQ(numbers_of(one.d_maps[b]), numbers_of(other.d_maps[b])) << b;
}

// Without a gradient there is none by the maps either.
// Bug put back: that of the last loss for it; seen to fail on the CPU.
TEST_P(BackendExposure, LossAloneIsThatOfTheMappedImage) {
  const TestScene<float> scene = mapped_scene(81, false).as<float>();
  const StoredScene<float> in(scene, memory());
  Pipeline<float> pipeline(backend());
  pipeline.forward(in.forward(true));
  pipeline.loss(in.target(), true);
  const StepOutcome with = pipeline.outcome();
  EXPECT_EQ(with.d_maps.size(), scene.views.size());
  pipeline.loss(in.target());
  const StepOutcome alone = pipeline.outcome();
  EXPECT_TRUE(alone.d_maps.empty());
  for (size_t b = 0; b < scene.views.size(); ++b)
    EXPECT_EQ(alone.losses[b].total, with.losses[b].total);
}

}  // namespace
}  // namespace tessera::testing
