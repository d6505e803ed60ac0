// The blobs, the ring of cameras, and a training with its observer.
#include "tests/support/tiny_capture.h"

#include <bit>
#include <cmath>

#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/render.h"
#include "tests/support/test_scene.h"

namespace tessera::testing {
namespace {

struct Blob {
  double mean[3], scale[3], colour[3];
  double mean_time, sigma_time, speed;  // dynamic ones: speed along x per clip
};

void place(const Blob& blob, GaussianSet& set, int64_t n) {
  const GaussianSpans<float> v = set.values();
  const float identity[4] = {1, 0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    v.at(kMean, n)[k] = float(blob.mean[k]);
    v.at(kLogScale, n)[k] = float(std::log(blob.scale[k]));
    v.at(kSh, n)[k] = float((blob.colour[k] - 0.5) / kSh0);
  }
  std::copy_n(identity, 4, v.at(kRotation, n));
  *v.at(kOpacityLogit, n) = 2.5f;
  if (set.dim() == 3) return;
  *v.at(kMeanTime, n) = float(blob.mean_time);
  *v.at(kLogScaleTime, n) = float(std::log(blob.sigma_time));
  // l = r turns the (t, x) plane by twice the angle: a velocity along x
  const double angle = 0.25 * std::atan(blob.speed);
  for (Group side : {kRotation, kRotationRight}) {
    v.at(side, n)[0] = float(std::cos(angle));
    v.at(side, n)[1] = float(std::sin(angle));
    v.at(side, n)[2] = v.at(side, n)[3] = 0;
  }
}

void append_bits(std::vector<uint32_t>& bits, const Buffer<float>& values) {
  for (float value : values) bits.push_back(std::bit_cast<uint32_t>(value));
}

}  // namespace

GaussianModel tiny_truth(const TinyCapture& capture) {
  const std::vector<Blob> still = {{{-0.5, -0.1, 0.2}, {0.3, 0.2, 0.25}, {0.9, 0.2, 0.1}, 0, 0, 0},
                                   {{0.4, 0.4, -0.3}, {0.2, 0.35, 0.2}, {0.1, 0.8, 0.3}, 0, 0, 0},
                                   {{0.1, -0.5, 0.4}, {0.3, 0.15, 0.2}, {0.2, 0.3, 0.9}, 0, 0, 0}};
  const std::vector<Blob> moving = {
      {{0.0, 0.5, 0.3}, {0.2, 0.2, 0.2}, {0.9, 0.8, 0.1}, 0.5, 0.5, 0.5},
      {{-0.3, 0.2, -0.5}, {0.25, 0.2, 0.2}, {0.8, 0.1, 0.8}, 0.2, 0.4, 0}};
  GaussianModel model;
  model.static_set = GaussianSet(SetForm::kStatic, 1);
  model.dynamic_set = GaussianSet(SetForm::kPair, 1);
  model.static_set.resize(int64_t(still.size()));
  model.dynamic_set.resize(capture.moving ? int64_t(moving.size()) : 0);
  for (size_t n = 0; n < still.size(); ++n) place(still[n], model.static_set, int64_t(n));
  for (int64_t n = 0; n < model.dynamic_set.count(); ++n)
    place(moving[size_t(n)], model.dynamic_set, n);
  model.background = capture.background;
  return model;
}

Scene tiny_capture(const TinyCapture& capture) {
  return tiny_capture(capture, tiny_truth(capture));
}

Scene tiny_capture(const TinyCapture& capture, const GaussianModel& truth) {
  Scene scene;
  scene.path = "tiny";
  scene.background = capture.background;
  scene.had_alpha = true;
  scene.is_static = capture.timesteps == 1;
  std::vector<View> views;
  for (int c = 0; c < capture.cameras; ++c)
    for (int m = 0; m < capture.timesteps; ++m) {
      const double angle = capture.arc * c / capture.cameras;
      Frame frame;
      frame.camera = look_at({4 * std::cos(angle), 1 - 0.4 * (c % 3), 4 * std::sin(angle)},
                             {0, 0, 0}, capture.size, capture.size, 1.4 * capture.size);
      frame.camera_name = "ring" + std::to_string(c);
      frame.name = frame.camera_name + "/" + std::to_string(m);
      frame.frame_number = m;
      frame.time = capture.timesteps == 1 ? 0 : double(m) / (capture.timesteps - 1);
      frame.timestep = m;
      views.push_back({frame.camera, frame.time});
      scene.frames.push_back(std::move(frame));
    }
  const std::unique_ptr<Backend> backend = make_cpu_backend();
  const std::vector<RenderedImage> images = render_views(*backend, truth, views);
  for (size_t i = 0; i < images.size(); ++i)
    scene.frames[i].image = quantise(images[i].planar(), images[i].width, images[i].height);
  return scene;
}

void add_noise(Scene& scene, double most, uint64_t seed) {
  Random random(seed);
  for (Frame& frame : scene.frames)
    for (uint8_t& value : frame.image.data)
      value = uint8_t(std::clamp(std::lround(value + random.uniform(-most, most)), 0l, 255l));
}

TrainOptions tiny_options() {
  TrainOptions options;
  options.iterations = options.schedule_iterations = 40;
  options.batch = 2;
  options.init_points = 60;
  options.init_extent = 1.2;
  options.static_fraction = 0.5;
  options.sh_interval = 8;
  options.densify_from = 6;
  options.densify_until = 30;
  options.densify_interval = 6;
  options.prune_large_from = 12;
  options.reorder_interval = 10;
  return options;
}

TrainOptions thrifty_options() {
  TrainOptions options = tiny_options();
  options.iterations = options.schedule_iterations = 200;
  options.init_points = 150;
  options.static_fraction = 0.4;
  options.sh_degree = 2;
  options.sh_interval = 20;
  options.sh_time_degree = 0;
  options.densify_from = 10;
  options.densify_until = 100;
  options.densify_interval = 15;
  options.densify_threshold = 5e-5;
  options.peak_gaussians = 260;
  options.size = ModelSize::kKnee;
  options.decide_motion = true;
  options.decide_colour = true;
  options.thin_rounds = 4;
  options.thin_until = 180;
  options.decide_interval = 30;
  return options;
}

int64_t made_bytes(const GaussianModel& model) {
  return 100 + 40 * model.static_set.count() + 60 * model.dynamic_set.count();
}

TrainState first_state(const Scene& scene, const TrainOptions& options) {
  std::string source;
  return initial_state(scene, options, source);
}

Training::Training(const Scene& scene, const TrainOptions& options)
    : Training(scene, options, first_state(scene, options)) {}

Training::Training(const Scene& scene, const TrainOptions& options, TrainState state)
    : scene_(scene),
      own_backend_(make_cpu_backend()),
      backend_(*own_backend_),
      trainer_(backend_, scene, options, std::move(state), *this) {}

Training::Training(const Scene& scene, const TrainOptions& options, TrainState state,
                   Backend& backend)
    : scene_(scene),
      backend_(backend),
      trainer_(backend_, scene, options, std::move(state), *this) {}

Training& Training::run(int64_t iteration, const std::function<bool()>& stop) {
  trainer_.run(iteration, stop);
  return *this;
}

void Training::check_if_due(Validation& validation) {
  const int64_t i = state().iteration;
  if (validation.due(i)) validation.check(trainer_.drawn_model(), i, state().seconds);
}

Training& Training::run(int64_t iteration, Validation& validation) {
  while (state().iteration < iteration && !validation.stops()) {
    trainer_.run(std::min(iteration, validation.next_after(state().iteration)));
    check_if_due(validation);
  }
  return *this;
}

Training& Training::run(int64_t iteration, ModelReduction& reduction, Validation& validation) {
  while (state().iteration < iteration) {
    int64_t next = std::min(iteration, reduction.schedule().next_after(state().iteration));
    if (validation.on()) next = std::min(next, validation.next_after(state().iteration));
    trainer_.run(next);
    check_if_due(validation);
    if (const auto report = reduction.act(trainer_, validation.record()))
      decisions_.push_back(*report);
  }
  return *this;
}

double Training::psnr() const {
  std::vector<View> views;
  for (const Frame& frame : scene_.frames) views.push_back({frame.camera, frame.time});
  const std::vector<RenderedImage> images = render_views(backend_, model(), views);
  double sum = 0;
  for (size_t i = 0; i < images.size(); ++i)
    sum += psnr_float(images[i].planar(), scene_.frames[i].image);
  return sum / double(images.size());
}

std::vector<uint32_t> model_bits(const GaussianModel& model) {
  std::vector<uint32_t> bits;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set}) {
    bits.push_back(uint32_t(set->count()));
    for (int g = 0; g < set->groups(); ++g) append_bits(bits, set->group(Group(g)).value);
  }
  append_bits(bits, model.environment.map.value);
  append_bits(bits, model.nodes.position);
  for (const ParameterGroup* group : model.nodes.groups()) append_bits(bits, group->value);
  for (int value : {model.drawing.sh_degree, int(model.background[0]), int(model.background[1]),
                    int(model.background[2])})
    bits.push_back(uint32_t(value));
  for (double value : {model.drawing.near_plane, model.drawing.far_plane, model.time_axis.origin,
                       model.time_axis.duration})
    for (int half = 0; half < 2; ++half)
      bits.push_back(uint32_t(std::bit_cast<uint64_t>(value) >> (32 * half)));
  return bits;
}

std::vector<uint32_t> state_bits(const TrainState& state) {
  std::vector<uint32_t> bits = model_bits(state.model);
  for (const GaussianSet* set : {&state.model.static_set, &state.model.dynamic_set})
    for (int g = 0; g < set->groups(); ++g) {
      append_bits(bits, set->group(Group(g)).moment1);
      append_bits(bits, set->group(Group(g)).moment2);
    }
  for (const ParameterGroup* group : state.model.nodes.groups()) {
    append_bits(bits, group->moment1);
    append_bits(bits, group->moment2);
  }
  bits.push_back(uint32_t(state.model.nodes.started));
  bits.push_back(uint32_t(state.model.nodes.refitted));
  append_bits(bits, state.model.environment.map.moment1);
  append_bits(bits, state.model.environment.map.moment2);
  for (const SetStatistics& statistics : state.statistics) {
    append_bits(bits, statistics.gradient_sum);
    append_bits(bits, statistics.count);
    append_bits(bits, statistics.filter_size);
  }
  for (const LearntRows* rows : {&state.exposure, &state.clocks})
    for (const Buffer<float>* values : {&rows->value, &rows->moment1, &rows->moment2})
      append_bits(bits, *values);
  for (const Buffer<float>& mean : state.average.means) append_bits(bits, mean);
  bits.push_back(uint32_t(state.average.states));
  for (const LearntRows* rows : {&state.exposure, &state.clocks})
    for (const int32_t steps : rows->steps) bits.push_back(uint32_t(steps));
  for (int64_t value : {state.iteration, state.sampler_epoch, state.sampler_position, state.decided,
                        state.goal, int64_t(state.finished)})
    bits.push_back(uint32_t(value));
  return bits;
}

}  // namespace tessera::testing
