// What: the forward pass and the two stages that look at it, with truth and masks brought over.
// Not: their arithmetic (kernels/stages/sensitivity).
#include "recon4d/evaluation/scoring_pass.h"

#include <algorithm>
#include <utility>

#include "recon4d/evaluation/render.h"

namespace tessera {
namespace {

/// What the host has where the backend can read it.
Span<const uint8_t> bring(const std::vector<uint8_t>& from, Buffer<uint8_t>& to) {
  const Span<const uint8_t> host{from.data(), int64_t(from.size())};
  if (&to.memory() == &host_memory() || from.empty()) return host;
  to.resize(host.size);
  to.memory().copy(to.data(), host.data, from.size());
  return std::as_const(to).span();
}

}  // namespace

FrameSample sample_training_frames(const Scene& scene, int64_t most) {
  FrameSample at;
  at.scene = &scene;
  std::vector<int> frames = scene.split_indices(Split::kTrain);
  const auto by_time = [&](int a, int b) {
    return scene.frames[size_t(a)].time < scene.frames[size_t(b)].time;
  };
  std::stable_sort(frames.begin(), frames.end(), by_time);
  const auto count = int64_t(frames.size());
  if (most <= 0 || count <= most) {
    at.frames = std::move(frames);
    return at;
  }
  // whole timesteps: what cameras miss each in its own way must not look like a change with time
  std::vector<int64_t> first;  // frame of each timestep
  for (int64_t i = 0; i < count; ++i)
    if (i == 0 || by_time(frames[size_t(i - 1)], frames[size_t(i)])) first.push_back(i);
  const auto timesteps = int64_t(first.size());
  first.push_back(count);
  if (timesteps == 1) {
    for (int64_t i = 0; i < most; ++i) at.frames.push_back(frames[size_t(i * count / most)]);
    return at;
  }
  const int64_t wanted = std::clamp<int64_t>(most * timesteps / count, 2, timesteps);
  for (int64_t m = 0; m < wanted; ++m) {
    const int64_t timestep = m * (timesteps - 1) / (wanted - 1);
    for (int64_t i = first[size_t(timestep)]; i < first[size_t(timestep) + 1]; ++i)
      at.frames.push_back(frames[size_t(i)]);
  }
  return at;
}

ScoringPass::ScoringPass(Backend& backend, const GaussianModel& model)
    : backend_(backend),
      model_(model),
      static_set_(model.static_set.clone_values(backend.memory())),
      dynamic_set_(model.dynamic_set.clone_values(backend.memory())),
      environment_(backend.memory()),
      pipeline_(backend) {
  environment_.copy_from(model.environment.map.value);
}

void ScoringPass::draw(const FrameSample& at, int64_t begin, int64_t end) {
  ForwardArgs<float> args{
      {std::as_const(static_set_).values(), std::as_const(dynamic_set_).values()},
      {},
      render_options(model_),
      true};
  args.options.kernels = at.kernels;
  args.environment = environment_of(model_, std::as_const(environment_).span());
  Target target;
  while (int64_t(truth_.size()) < end - begin)
    truth_.emplace_back(backend_.memory()), mask_.emplace_back(backend_.memory());
  for (int64_t i = begin; i < end; ++i) {
    const Frame& frame = at.scene->frames[size_t(at.frames[size_t(i)])];
    args.views.push_back({frame.camera, frame.time});
    target.truth.push_back(bring(frame.image.data, truth_[size_t(i - begin)]));
    target.mask.push_back(bring(frame.mask.data, mask_[size_t(i - begin)]));
    if (!at.gain.empty()) target.gain.push_back(at.gain[size_t(i)]);
  }
  pipeline_.forward(args);
  pipeline_.residual(target);
  residual_.copy_from(pipeline_.d_colour());
}

const ScoringPass::SplatSums& ScoringPass::sums(Span<const float> x) {
  if (!x.empty())
    backend_.memory().copy(pipeline_.d_colour().data(), x.data, size_t(x.size) * sizeof(float));
  const Span<const SplatSensitivity<float>> found = pipeline_.sensitivity();
  sums_.first_of.copy_from(pipeline_.splats().first_of);
  sums_.sum.resize(found.size);
  if (found.size > 0)
    backend_.memory().copy(sums_.sum.data(), found.data, size_t(found.size) * sizeof(found[0]));
  return sums_;
}

const Buffer<Splat<float>>& ScoringPass::splats() {
  splats_.copy_from(pipeline_.splats().splat);
  return splats_;
}

}  // namespace tessera
