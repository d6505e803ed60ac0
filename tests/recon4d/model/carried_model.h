// A small model whose Gaussians motion nodes carry, and a measure between models that move.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/recon4d/model/small_models.h"
#include "tests/support/carried_scene.h"

namespace tessera::testing {

/// Gaussians that nine nodes carry, each bound to at most `most` of them, every fifth to none.
inline GaussianModel carried_model(int most, int64_t count = 40) {
  Random random(31);
  TestScene<double> scene = random_scene(count, 3, 0.15, 30);
  const TestNodes<double> nodes = random_nodes(9, 6, random);
  GaussianModel model;
  model.static_set = set_of(canonical(scene.fixed, nodes, random, [most](int64_t n) {
    return n % 5 == 4 ? 0 : 1 + int(n) % most;
  }));
  model.dynamic_set = GaussianSet(SetForm::kVelocity, model.static_set.coefficients());
  model.drawing.sh_degree = 3;
  while (sh_coefficients(model.drawing.sh_degree) > model.static_set.coefficients())
    --model.drawing.sh_degree;
  model.nodes.resize(nodes.count, nodes.knots);
  const NodeSpans<float> to = model.nodes.spans();
  std::copy(nodes.position.begin(), nodes.position.end(), to.position.data);
  std::copy(nodes.log_radius.begin(), nodes.log_radius.end(), to.log_radius.data);
  std::copy(nodes.translation.begin(), nodes.translation.end(), to.translation.data);
  std::copy(nodes.rotation.begin(), nodes.rotation.end(), to.rotation.data);
  return model;
}

/// PSNR between the images of two models at times, normalised; else in the clip, at its ends and
/// beyond. dB.
inline double likeness(const GaussianModel& a, const GaussianModel& b,
                       const std::vector<double>& times = {-0.1, 0.0, 0.3, 0.62, 1.0}) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  std::vector<View> views;
  for (const double time : times)
    for (View view : three_views()) {
      view.time = time;
      views.push_back(view);
    }
  const auto first = render_views(*backend, a, views), second = render_views(*backend, b, views);
  double error = 0, count = 0;
  for (size_t v = 0; v < views.size(); ++v)
    for (size_t i = 0; i < first[v].rgb.size(); ++i, ++count)
      error += std::pow(double(first[v].rgb[i]) - double(second[v].rgb[i]), 2);
  return 10 * std::log10(count / error);
}

}  // namespace tessera::testing
