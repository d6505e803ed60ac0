// Captures by one camera that travels around a moving body: every timestep is one image, as in a
// monocular video, and the views of all other cameras are held out.
#pragma once
#include "tests/recon4d/model/small_models.h"
#include "tests/support/carried_scene.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {

/// A cluster of blobs that one node turns by `angle` about z and moves by `shift` during the clip,
/// beside the static blobs of the tiny truth.
inline GaussianModel turning_truth(double angle, const Vec3<double>& shift) {
  constexpr int knots = 8;
  Random random(21);
  TestNodes<double> nodes;
  nodes.count = 1;
  nodes.knots = knots;
  nodes.position = {0.1, 0.2, 0};
  nodes.log_radius = {0};
  for (int i = 0; i < knots; ++i) {
    const double share = double(i - 1) / (knots - 3);
    for (int c = 0; c < 3; ++c) nodes.translation.push_back(share * shift[c]);
    for (const double q : {std::cos(share * angle / 2), 0.0, 0.0, std::sin(share * angle / 2)})
      nodes.rotation.push_back(q);
  }
  TestGaussians<double> body = random_gaussians(SetForm::kStatic, 12, 0.45, 0.12, random, 1);
  for (int64_t n = 0; n < body.count; ++n) {
    body.at(kMean, n)[0] *= 1.6;  // longer than wide: a turn shows
    *body.at(kOpacityLogit, n) = 2.5;
    for (int c = 0; c < 3; ++c) body.at(kSh, n)[c] = random.uniform(-1.2, 1.2);
  }
  // the last three are bound to nothing: ground
  body = canonical(body, nodes, random, [](int64_t n) { return n < 9 ? 1 : 0; });
  GaussianModel truth;
  truth.static_set = set_of(body);
  truth.dynamic_set = GaussianSet(SetForm::kPair, 1);
  truth.drawing.sh_degree = 0;
  truth.nodes.resize(nodes.count, knots);
  for (size_t i = 0; i < 3; ++i) truth.nodes.position[int64_t(i)] = float(nodes.position[i]);
  truth.nodes.log_radius.value[0] = 0;
  std::copy(nodes.translation.begin(), nodes.translation.end(),
            truth.nodes.translation.value.begin());
  std::copy(nodes.rotation.begin(), nodes.rotation.end(), truth.nodes.rotation.value.begin());
  return truth;
}

/// Two bodies, each carried by a node of its own, which move towards each other until half of the
/// clip, by `way`, and then back. With 0.3 they touch; with a negative one they part and return.
inline GaussianModel meeting_truth(float way) {
  GaussianModel truth = turning_truth(0, {0, 0, 0});
  constexpr int kKnots = 8;
  GaussianSet& set = truth.static_set;
  const GaussianSpans<float> values = set.values();
  truth.nodes.resize(2, kKnots);
  const NodeSpans<float> nodes = truth.nodes.spans();
  for (int m = 0; m < 2; ++m) {
    const float side = m == 0 ? -1.0f : 1.0f;
    for (int c = 0; c < 3; ++c) nodes.position[3 * m + c] = c == 0 ? 0.55f * side : 0.1f;
    nodes.log_radius[m] = 0;
    for (int i = 0; i < kKnots; ++i) {
      const float share = 1 - std::abs(2 * float(i - 1) / float(kKnots - 3) - 1);  // 0 … 1 … 0
      for (int c = 0; c < 3; ++c)
        nodes.translation[3 * (kKnots * m + i) + c] = c == 0 ? -way * side * share : 0;
      for (int c = 0; c < 4; ++c) nodes.rotation[4 * (kKnots * m + i) + c] = c == 0 ? 1 : 0;
    }
  }
  for (int64_t n = 0; n < 9; ++n) {  // those that a node carries, by turns
    *values.at(kNode, n) = float(n % 2);
    values.at(kMean, n)[0] = 0.3f * values.at(kMean, n)[0] + (n % 2 == 0 ? -0.55f : 0.55f);
  }
  return truth;
}

/// Frames of all cameras at all timesteps, of which each timestep has one that is trained on; every
/// third of the others is a test view.
inline Scene travelling_camera(const GaussianModel& truth, int timesteps, int size) {
  Scene all = tiny_capture({.cameras = timesteps, .timesteps = timesteps, .size = size}, truth);
  Scene scene = all;
  scene.frames.clear();
  for (size_t i = 0; i < all.frames.size(); ++i) {
    const int camera = int(i) / timesteps, timestep = int(i) % timesteps;
    const bool seen = (5 * timestep) % timesteps == camera;  // far apart from frame to frame
    if (!seen && i % 3 != 0) continue;
    scene.frames.push_back(all.frames[i]);
    scene.frames.back().camera_name = "camera";
    scene.frames.back().split = seen ? Split::kTrain : Split::kTest;
  }
  return scene;
}

/// Mean PSNR of a split, un-quantised, dB.
inline double psnr_of(Backend& backend, const GaussianModel& model, const Scene& scene,
                      Split split) {
  double sum = 0;
  int count = 0;
  for (const Frame& frame : scene.frames) {
    if (frame.split != split) continue;
    const std::vector<RenderedImage> images =
        render_views(backend, model, {{frame.camera, frame.time}});
    sum += psnr_float(images[0].planar(), frame.image);
    ++count;
  }
  return sum / count;
}

}  // namespace tessera::testing
