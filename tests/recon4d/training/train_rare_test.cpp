// An object that few of very many views see keeps its opacity under the regularisers of MCMC.
// Source: failure mode F16 (gsplat #542, #778).
#include <gtest/gtest.h>

#include <cmath>

#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/options/presets.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/support/random.h"
#include "tests/support/test_scene.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

constexpr int kViews = 1500, kRare = 3, kSize = 16;
const glm::dvec3 kRareAt(0, 5, 0);  // far above what the others look at

Camera camera_of(int index) {
  const bool rare = index % (kViews / kRare) == 0;
  const glm::dvec3 target = rare ? kRareAt : glm::dvec3(0, 0, 0);
  const double angle = 0.7 * index;
  return look_at(target + glm::dvec3(4 * std::cos(angle), 0.3 * (index % 3), 4 * std::sin(angle)),
                 target, kSize, kSize, 1.4 * kSize);
}

/// The tiny capture's still blobs, and the first of them once more at kRareAt.
GaussianModel truth() {
  TinyCapture still{.moving = false};
  GaussianModel model = tiny_truth(still);
  const GaussianSet blobs = model.static_set.clone_values();
  model.static_set.resize(blobs.count() + 1);
  for (int g = 0; g < blobs.groups(); ++g) {
    const int width = blobs.width(Group(g));
    const Buffer<float>& from = blobs.group(Group(g)).value;
    float* const to = model.static_set.group(Group(g)).value.data();
    std::copy_n(from.data(), from.size(), to);
    std::copy_n(from.data(), width, to + from.size());
  }
  float* const mean = model.static_set.values().at(kMean, blobs.count());
  for (int k = 0; k < 3; ++k) mean[k] = float(kRareAt[k]);
  return model;
}

struct RareCapture {
  Scene scene;
  std::vector<View> rare;  // that see the object

  RareCapture() {
    const GaussianModel model = truth();
    scene.path = "rare";
    scene.is_static = true;
    std::vector<View> views;
    for (int i = 0; i < kViews; ++i) {
      views.push_back({camera_of(i), 0});
      if (i % (kViews / kRare) == 0) rare.push_back(views.back());
    }
    const std::unique_ptr<Backend> backend = make_cpu_backend();
    const std::vector<RenderedImage> images = render_views(*backend, model, views);
    for (size_t i = 0; i < views.size(); ++i) {
      Frame frame;
      frame.camera = views[i].camera;
      frame.timestep = 0;
      frame.name = std::to_string(i);
      frame.image = quantise(images[i].planar(), kSize, kSize);
      scene.frames.push_back(std::move(frame));
    }
    Random random(5);
    const GaussianSpans<const float> blobs = std::as_const(model).static_set.values();
    for (int64_t n = 0; n < blobs.count; ++n)
      for (int i = 0; i < 12; ++i) {
        glm::vec3 point;
        for (int k = 0; k < 3; ++k)
          point[k] = float(blobs.at(kMean, n)[k] + random.uniform(-0.3, 0.3));
        scene.points.position.push_back(point);
        scene.points.colour.push_back({128, 128, 128});
      }
  }
};

/// Mean opacity of the pixels of the views that see the object, after four rounds of all views.
double opacity_of_the_rare(const RareCapture& capture, double weight) {
  TrainOptions options;
  apply_preset(options, "mcmc");
  options.max_gaussians = int64_t(capture.scene.points.position.size());
  options.init_scale_factor = 1;  // there are few points
  options.mcmc_noise = 0;         // made for scenes of a million Gaussians
  options.lr_opacity = 0.005;     // so that momentum after a view is not what is measured
  options.opacity_weight = options.scale_weight = weight;
  Training training(capture.scene, options);
  training.run(4 * kViews);
  double sum = 0;
  for (const View& view : capture.rare) sum += coverage(render_one(training.model(), view)) / kRare;
  return sum;
}

// Bug put back: Gaussians that no view draws are regularised too; seen to fail: 0.0003 of 0.043.
TEST(RareObject, KeepsItsOpacityUnderRegularisers) {
  const RareCapture capture;
  const double without = opacity_of_the_rare(capture, 0), with = opacity_of_the_rare(capture, 0.01);
  EXPECT_GT(without, 0.03) << "it is there: 0.049 in the truth";
  EXPECT_GE(with, 0.9 * without);
}

}  // namespace
}  // namespace tessera::testing
