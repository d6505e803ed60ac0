// Made-up worlds as images and scenes, shortened presets, and measurements in images.
#include "tests/recon4d/modes/modes_film.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "recon4d/evaluation/metrics.h"
#include "recon4d/options/presets.h"
#include "recon4d/reduction/model_reduction.h"
#include "recon4d/reduction/size_limit.h"
#include "recon4d/training/validation.h"
#include "tests/support/random.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"

namespace tessera::testing {
namespace {

constexpr int kGrid = 3;  // samples a pixel, each way

Camera camera_at(const Film& film, double angle, double height) {
  const glm::dvec3 eye(film.distance * std::sin(angle), -film.distance * std::cos(angle), height);
  return synth::look_at(eye, {0, 0, 0}, film.width, film.height, film.field);
}

Camera camera_of(const Film& film, int c) {
  if (c == film.cameras) return camera_at(film, 0, 0.1);
  const double along = film.cameras == 1 ? 0.5 : double(c) / (film.cameras - 1);
  return camera_at(film, film.arc * (along - 0.5), c % 2 == 0 ? 0.6 : -0.4);
}

/// Over black.
Image8 developed(const synth::RenderedImage& shot) {
  const size_t pixels = size_t(shot.width) * size_t(shot.height);
  std::vector<float> planar(3 * pixels);
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < 3; ++c)
      planar[c * pixels + p] = shot.rgba[4 * p + c] * shot.rgba[4 * p + 3];
  return quantise({planar.data(), int64_t(planar.size())}, shot.width, shot.height);
}

}  // namespace

double Film::pixels_a_unit() const {
  return 0.5 * width / std::tan(0.5 * field) / distance;
}

Scene shoot(const Film& film) {
  Scene scene;
  scene.path = "film";
  scene.had_alpha = film.alpha;
  scene.is_static = film.timesteps == 1;
  scene.frames.resize(size_t(film.timesteps * (film.cameras + 1)));
  const synth::World still = film.world(0);
  for (int c = 0; c <= film.cameras; ++c) {
    const Camera camera = camera_of(film, c);
    const synth::StaticLayer layer = synth::render_static(still, camera, kGrid);
    for (int m = 0; m < film.timesteps; ++m) {
      Frame& frame = scene.frames[size_t(m * (film.cameras + 1) + c)];
      frame.camera = camera;
      frame.camera_name = c == film.cameras ? "middle" : "cam" + std::to_string(c);
      frame.name = frame.camera_name + "/" + std::to_string(m);
      frame.frame_number = m;
      frame.time = film.time(m);
      frame.timestep = m;
      frame.split = c == film.cameras ? Split::kTest : Split::kTrain;
      frame.image = developed(synth::render(film.world(frame.time), camera, frame.time, layer));
    }
  }
  return scene;
}

PointCloud surface_cloud(const Film& film, int still, int moving) {
  constexpr int kTries = 100000;
  PointCloud cloud;
  Random random(11);
  int wanted[2] = {moving, still};
  for (int i = 0; i < kTries && (wanted[0] > 0 || wanted[1] > 0); ++i) {
    const double time = film.time(int(random.below(film.timesteps)));
    const synth::World world = film.world(time);
    std::vector<synth::PlacedSolid> solids = place(world, synth::Part::kStatic, time);
    for (const synth::PlacedSolid& placed : place(world, synth::Part::kMoving, time))
      solids.push_back(placed);
    const Camera camera = camera_of(film, int(random.below(film.cameras)));
    const synth::Ray ray =
        synth::pixel_ray(camera, random.uniform(0, film.width), random.uniform(0, film.height));
    const synth::Meeting meeting = cast(ray, solids);
    if (meeting.placed == nullptr) continue;
    const bool stays = !meeting.placed->solid->moves;
    if (wanted[int(stays)]-- <= 0) continue;
    const glm::vec3 colour = shade(world.light, ray, meeting, {});
    cloud.position.push_back(glm::vec3(ray.origin + meeting.hit.depth * ray.direction));
    cloud.colour.push_back(
        {uint8_t(255 * colour[0]), uint8_t(255 * colour[1]), uint8_t(255 * colour[2])});
    cloud.time.push_back(float(time));
    cloud.still.push_back(stays);
  }
  return cloud;
}

std::vector<const Frame*> held_out(const Scene& scene) {
  std::vector<const Frame*> frames;
  for (int i : scene.split_indices(Split::kTest)) frames.push_back(&scene.frames[size_t(i)]);
  return frames;
}

synth::World even_world() {
  synth::World world;
  world.light.ambient = 1;
  world.light.diffuse = 0;
  return world;
}

synth::Solid& add_solid(synth::World& world, synth::ShapeKind kind, glm::dvec3 half,
                        glm::dvec3 place, const synth::Texture& texture, bool moves) {
  synth::Solid solid;
  solid.shape.kind = kind;
  solid.shape.half = half;
  solid.texture = texture;
  solid.motion.rest = place;
  // a quad lies level; here it stands and faces the cameras
  if (kind == synth::ShapeKind::kQuad) solid.motion.rest_rotation = synth::turn_x(90);
  solid.moves = moves;
  world.solids.push_back(solid);
  return world.solids.back();
}

synth::Texture warm(double cell, double gain) {
  const auto lit = [&](float r, float g, float b) { return glm::vec3(r, g, b) * float(gain); };
  return {synth::TextureKind::kPatches,
          lit(.75f, .45f, .2f),
          lit(.55f, .3f, .2f),
          lit(.9f, .85f, .7f),
          cell,
          3};
}

synth::Texture cold(double cell) {
  return {
      synth::TextureKind::kPatches, {.2f, .4f, .7f}, {.15f, .25f, .5f}, {.8f, .85f, .9f}, cell, 5};
}

TrainOptions short_training(const std::string& preset, int64_t steps) {
  TrainOptions options;
  apply_preset(options, preset);
  const double faster = double(options.iterations) / double(steps);
  options.iterations = steps;
  for (double* rate : {&options.lr_mean, &options.lr_mean_final, &options.lr_velocity})
    *rate *= faster;
  options.init_points = 800;
  options.max_gaussians = 1200;
  options.densify_interval = std::max<int64_t>(10, steps / 30);
  options.densify_threshold = 1e-3;
  return options;
}

GaussianModel trained(const Scene& scene, const TrainOptions& options) {
  Training training(scene, options);
  training.run();
  return training.model().clone_values();
}

GaussianModel decided(const Scene& scene, TrainOptions options) {
  options.peak_gaussians = std::exchange(options.max_gaussians, 0);
  Training training(scene, options);
  Validation validation(training.backend(), scene, options, ValidationRecord{});
  const auto bytes = [](const GaussianModel&) -> int64_t { return 0; };  // not asked for
  ModelReduction reduction(training.backend(), options, bytes);
  training.run(options.iterations, reduction, validation);
  return fit_to_limit({}, training.backend(), training.trainer().host_model(),
                      training.trainer().sample_frames());
}

std::vector<RenderedImage> middle_images(const GaussianModel& model, const Scene& scene) {
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  std::vector<View> views;
  for (const Frame* frame : held_out(scene)) views.push_back({frame->camera, frame->time});
  return render_views(*backend, model, views);
}

double middle_psnr(const GaussianModel& model, const Scene& scene) {
  const std::vector<RenderedImage> images = middle_images(model, scene);
  const std::vector<const Frame*> frames = held_out(scene);
  double sum = 0;
  for (size_t i = 0; i < images.size(); ++i)
    sum += psnr_float(images[i].planar(), frames[i]->image);
  return sum / double(images.size());
}

std::vector<double> deviation_over_time(const std::vector<RenderedImage>& images) {
  std::vector<double> deviation;
  const double count = double(images.size());
  for (size_t i = 0; i < images[0].rgb.size(); ++i) {
    double sum = 0, squares = 0;
    for (const RenderedImage& image : images) {
      const double value = 255 * std::clamp(double(image.rgb[i]), 0.0, 1.0);
      sum += value;
      squares += value * value;
    }
    deviation.push_back(std::sqrt(std::max(0.0, squares / count - sum / count * sum / count)));
  }
  return deviation;
}

std::array<double, 2> centroid(const RenderedImage& image) {
  double sum = 0, x_sum = 0, y_sum = 0;
  for (size_t i = 0; i < image.rgb.size(); ++i) {
    const size_t p = i % image.alpha.size();
    const double value = std::clamp(double(image.rgb[i]), 0.0, 1.0);
    sum += value;
    x_sum += value * (double(p % size_t(image.width)) + 0.5);
    y_sum += value * (double(p / size_t(image.width)) + 0.5);
  }
  if (sum == 0) return {-1, -1};
  return {x_sum / sum, y_sum / sum};
}

RenderedImage image_of(const Image8& image) {
  const size_t pixels = image.data.size() / 3;
  RenderedImage planar{image.width, image.height, std::vector<float>(3 * pixels),
                       std::vector<float>(pixels, 1)};
  for (size_t i = 0; i < image.data.size(); ++i)
    planar.rgb[i % 3 * pixels + i / 3] = float(image.data[i]) / 255;
  return planar;
}

double largest_difference(const RenderedImage& a, const RenderedImage& b) {
  double worst = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i)
    worst = std::max(worst, std::abs(double(a.rgb[i]) - double(b.rgb[i])));
  return 255 * worst;
}

}  // namespace tessera::testing
