// Sums over splats per Gaussian on every backend, against loops over what that backend rendered,
// and squares of residuals. Equal inputs give equal bits. Sums over the pixels of a splat are
// tested in backend_sensitivity_test.cpp.
#include <cmath>

#include "kernels/load_gaussian.h"
#include "kernels/pipeline.h"
#include "tests/kernels/backend/backend_scenes.h"
#include "tests/support/backends.h"
#include "tests/support/stored_scene.h"

namespace tessera::testing {
namespace {

class BackendContribution : public EveryBackend {};
TESSERA_ON_EVERY_BACKEND(BackendContribution);

/// The measures of a backend for two timesteps of a scene, and the splats that it drew in the
/// second.
struct Found {
  std::vector<ElementSums<float>> elements;
  std::vector<TimeVariation> variation;
  std::vector<SplatSensitivity<float>> sums[2];  // by timestep
  std::vector<Splat<float>> splats[2];
  std::vector<int64_t> first_of[2];
  double squared_error = 0;
  std::vector<float> residual;
};

template <class T>
Buffer<T> zeros(int64_t count, Memory& memory) {
  return stored(std::vector<T>(size_t(count), T{}), memory);
}

/// `clock`: from one camera's to the next, in normalised time.
Found find(const TestScene<float>& scene, const double (&times)[2], Backend& backend,
           int second_series = 0, double clock = 0) {
  Memory& memory = backend.memory();
  StoredScene<float> in(scene, memory);
  Pipeline<float> pipeline(backend);
  Buffer<ElementSums<float>> elements =
      zeros<ElementSums<float>>(scene.fixed.count + scene.moving.count, memory);
  Buffer<TimeVariation> variation = zeros<TimeVariation>(scene.fixed.count, memory);
  Found found;
  for (int t = 0; t < 2; ++t) {
    double offset = 0;
    for (View& view : in.views) {
      view.time = times[t] + offset;
      view.timestep = t;
      view.series = t * second_series;
      offset += clock;
    }
    pipeline.forward(in.forward(true));
    pipeline.residual(in.target());
    const Span<const SplatSensitivity<float>> sums = pipeline.sensitivity();
    pipeline.add_contributions(elements.span(), variation.span());
    found.sums[t].resize(size_t(sums.size));
    memory.copy(found.sums[t].data(), sums.data, size_t(sums.size) * sizeof(sums[0]));
    found.splats[t] = fetched(pipeline.splats().splat, memory);
    found.first_of[t] = fetched(pipeline.splats().first_of, memory);
  }
  found.squared_error = backend.sum_of_squares(std::as_const(pipeline.d_colour()).span());
  found.residual = fetched(pipeline.d_colour(), memory);
  found.elements = fetched(elements, memory);
  found.variation = fetched(variation, memory);
  for (TimeVariation& v : found.variation) close_series(v);
  return found;
}

constexpr double kTimes[2] = {0.3, 0.6};

/// The colour that a set's Gaussian has in a view with the bands up to `degree`, not clamped.
Vec3<float> colour_of(const TestGaussians<float>& set, int64_t n, const View& view,
                      const RenderOptions& options, int degree) {
  const ViewBatch<float> batch = make_view_batch<float>({view});
  GaussianState<float> g;
  const bool valid =
      set.form == SetForm::kStatic ? load_gaussian<SetForm::kStatic>(set.view(), n, g)
      : set.form == SetForm::kPair ? load_gaussian<SetForm::kPair>(set.view(), n, g)
                                   : load_gaussian<SetForm::kVelocity>(set.view(), n, g);
  EXPECT_TRUE(valid);
  const Slice<float> slice = slice_at(g.mean, g.spacetime, float(view.time));
  float distance;
  const Vec3<float> direction =
      view_direction(batch.views[0], options.sliced_direction ? slice.mean : g.mean, distance);
  return sh_colour(degree, direction, set.at(kSh, n));
}

double relative(double actual, double expected, double scale) {
  return std::abs(actual - expected) / std::max(1e-6, scale);
}

// Bugs put back, each seen to fail on the CPU: the dynamic set's sums added to the first elements;
// the weight of the last splat alone; colours of one view for all.
TEST_P(BackendContribution, SumsOfAGaussianAreThoseOfItsSplats) {
  for (const SetForm form : {SetForm::kPair, SetForm::kVelocity}) {
    TestScene<float> scene = random_scene(60, 60, 0.15, 91, form).as<float>();
    scene.options.sh_degree = 2;
    const Found found = find(scene, kTimes, backend());
    int64_t lit = 0;
    for (int64_t n = 0; n < int64_t(found.elements.size()); ++n) {
      const bool is_static = n < scene.fixed.count;
      const TestGaussians<float>& set = is_static ? scene.fixed : scene.moving;
      double weight = 0, removal1 = 0, removal2 = 0, moving = 0, time = 0, opacity = 0, scale = 0;
      double truncation[2] = {0, 0};
      Vec3<double> image(0.0);
      for (int t = 0; t < 2; ++t)
        for (int64_t s = found.first_of[t][size_t(n)]; s < found.first_of[t][size_t(n) + 1]; ++s) {
          const SplatSensitivity<float>& sum = found.sums[t][size_t(s)];
          const Splat<float>& splat = found.splats[t][size_t(s)];
          if (!(sum.weight > 0)) continue;
          weight += sum.weight;
          removal1 += sum.removal1;
          removal2 += sum.removal2;
          moving += sum.moving;
          time += sum.weight * kTimes[t];
          opacity += sum.weight * splat.opacity;
          image += Vec3<double>(sum.image);
          View view = scene.views[size_t(splat.view)];
          view.time = kTimes[t];
          const int64_t element = is_static ? n : n - scene.fixed.count;
          const Vec3<float> whole = colour_of(set, element, view, scene.options, 2);
          for (int d = 0; d < 2; ++d) {
            const Vec3<float> less = whole - colour_of(set, element, view, scene.options, d);
            for (int c = 0; c < 3; ++c) {
              if (splat.negative >> c & 1) continue;
              truncation[d] +=
                  double(sum.weight2) * less[c] * less[c] - 2.0 * sum.image[c] * less[c];
              scale +=
                  double(sum.weight2) * less[c] * less[c] + std::abs(2.0 * sum.image[c] * less[c]);
            }
          }
        }
      const ElementSums<float>& sums = found.elements[size_t(n)];
      lit += weight > 0;
      EXPECT_LT(relative(sums.weight, weight, weight), 1e-5) << n;
      EXPECT_LT(relative(sums.time, time, time), 1e-5) << n;
      EXPECT_LT(relative(sums.opacity, opacity, opacity), 1e-5) << n;
      EXPECT_LT(relative(sums.removal1, removal1, std::abs(removal1) + removal2), 1e-4) << n;
      EXPECT_LT(relative(sums.removal2, removal2, removal2), 1e-5) << n;
      EXPECT_LT(relative(sums.moving, moving, moving), 1e-5) << n;
      for (int c = 0; c < 3; ++c) EXPECT_LT(relative(sums.image[c], image[c], weight), 1e-5) << n;
      for (int d = 0; d < 2; ++d)
        EXPECT_LT(relative(sums.truncation[d], truncation[d], scale), 1e-4) << n << " " << d;
      EXPECT_EQ(sums.truncation[2], 0.0f);
    }
    EXPECT_GT(lit, 60);
  }
}

// Bugs put back, each seen to fail on the CPU: a timestep that is not closed; the peak of the last;
// a series that continues in the next.
TEST_P(BackendContribution, VariationIsByTimestep) {
  TestScene<float> scene = random_scene(60, 30, 0.15, 92).as<float>();
  scene.options.kernels.deterministic = true;  // the sums of two passes are compared to 1e-9
  const Found found = find(scene, kTimes, backend()), apart = find(scene, kTimes, backend(), 1);
  int64_t seen_twice = 0;
  for (int64_t n = 0; n < scene.fixed.count; ++n) {
    double gain = 0, weight2 = 0, peak = 0, peak_time = 0;
    Vec3<double> residual(0.0);
    int timesteps = 0;
    for (int t = 0; t < 2; ++t) {
      Vec3<double> now(0.0);
      double now2 = 0;
      for (int64_t s = found.first_of[t][size_t(n)]; s < found.first_of[t][size_t(n) + 1]; ++s) {
        now += Vec3<double>(found.sums[t][size_t(s)].image);
        now2 += found.sums[t][size_t(s)].weight2;
      }
      if (!(now2 > 0)) continue;
      ++timesteps;
      const double here = dot(now, now) / now2;
      gain += here;
      residual += now;
      weight2 += now2;
      if (here <= peak) continue;
      peak = here;
      peak_time = kTimes[t];
    }
    const TimeVariation& v = found.variation[size_t(n)];
    EXPECT_EQ(v.timesteps, timesteps) << n;
    if (timesteps < 2) continue;
    ++seen_twice;
    EXPECT_NEAR(v.gain, gain, 1e-9 * gain) << n;
    EXPECT_NEAR(v.varying_gain, gain - dot(residual, residual) / weight2, 1e-9 * gain) << n;
    EXPECT_EQ(v.freedom, 1) << n;
    EXPECT_NEAR(apart.variation[size_t(n)].gain, gain, 1e-9 * gain) << n;
    EXPECT_EQ(apart.variation[size_t(n)].varying_gain, 0) << "one timestep of a series each";
    EXPECT_EQ(apart.variation[size_t(n)].freedom, 0) << n;
    EXPECT_EQ(v.peak_time, float(peak_time)) << n;
    EXPECT_GT(v.light, 0) << n;
  }
  EXPECT_GT(seen_twice, 20);
}

// Bug put back: a timestep is closed where the time changes; seen to fail on the CPU.
TEST_P(BackendContribution, CamerasOfATimestepMayDifferInTheirTime) {
  TestScene<float> scene = random_scene(60, 0, 0.15, 92).as<float>();
  scene.options.kernels.deterministic = true;
  const Found same = find(scene, kTimes, backend()),
              apart = find(scene, kTimes, backend(), 0, 1e-3);
  for (size_t n = 0; n < same.variation.size(); ++n) {
    EXPECT_EQ(apart.variation[n].varying_gain, same.variation[n].varying_gain) << n;
    EXPECT_EQ(apart.variation[n].timesteps, same.variation[n].timesteps) << n;
    EXPECT_EQ(apart.variation[n].freedom, same.variation[n].freedom) << n;
  }
}

TEST_P(BackendContribution, IsRepeatable) {
  TestScene<float> scene = random_scene(200, 200, 0.15, 93).as<float>();
  scene.options.kernels.deterministic = true;
  const Found a = find(scene, kTimes, backend()), b = find(scene, kTimes, backend());
  const auto bytes = [](const auto& values) {
    return std::string(reinterpret_cast<const char*>(values.data()),
                       values.size() * sizeof(values[0]));
  };
  EXPECT_TRUE(bytes(a.elements) == bytes(b.elements));
  EXPECT_EQ(a.squared_error, b.squared_error);
  for (size_t n = 0; n < a.variation.size(); ++n)
    EXPECT_EQ(a.variation[n].gain, b.variation[n].gain);
}

// Bugs put back, each seen to fail on the CPU: the first channel alone; `before` added.
TEST_P(BackendContribution, SquaresOfResiduals) {
  const TestScene<float> scene = random_scene(60, 60, 0.15, 94).as<float>();
  const Found found = find(scene, kTimes, backend());
  double sum = 0;
  for (const float x : found.residual) sum += double(x) * double(x);
  EXPECT_NEAR(found.squared_error, sum, 1e-12 * sum);
  EXPECT_EQ(backend().sum_of_squares({}), 0);

  const ViewBatch<float> batch = make_view_batch<float>(scene.views);
  std::vector<float> before = found.residual;
  for (size_t i = 0; i < before.size(); ++i) before[i] *= i % 3 == 0 ? 0.5f : -1.5f;
  const Buffer<float> before_there = stored(before, memory());
  Buffer<float> residual = stored(found.residual, memory());
  backend().added_squares(batch, before_there.span(), residual.span());
  const std::vector<float> added = fetched(residual, memory());
  for (const ViewArgs<float>& view : batch.views) {
    const int64_t pixels = int64_t(view.width) * view.height;
    for (int64_t p = 0; p < pixels; ++p) {
      double expected = 0;
      for (int c = 0; c < 3; ++c) {
        const auto i = size_t(3 * view.first_pixel + c * pixels + p);
        expected += double(found.residual[i]) * found.residual[i] - double(before[i]) * before[i];
        EXPECT_TRUE(c == 0 || added[i] == 0.0f) << i;
      }
      ASSERT_NEAR(added[size_t(3 * view.first_pixel + p)], expected, 1e-5) << p;
    }
  }
}

}  // namespace
}  // namespace tessera::testing
