// The forward pass and the stages that measure its splats, with truth and masks copied to the
// backend.
#include "recon4d/evaluation/scoring_pass.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "recon4d/evaluation/render.h"

namespace tessera {
namespace {

/// What the host has where the backend can read it.
Span<const uint8_t> bring(const Span<const uint8_t>& host, Buffer<uint8_t>& to) {
  if (&to.memory() == &host_memory() || host.empty()) return host;
  to.resize(host.size);
  to.memory().copy(to.data(), host.data, size_t(host.size));
  return std::as_const(to).span();
}

}  // namespace

ElementBuffers::ElementBuffers(Backend& backend, const GaussianModel& model, bool varying)
    : sums(model.count(), backend.memory()),
      variation(varying ? model.static_set.count() : 0, backend.memory()) {
  const auto zero = [&](auto& buffer) {
    const auto bytes = int64_t(sizeof(*buffer.data())) * buffer.size();
    backend.fill_zero({reinterpret_cast<float*>(buffer.data()), bytes / int64_t(sizeof(float))});
  };
  zero(sums);
  zero(variation);
}

ScoringPass::ScoringPass(Backend& backend, const GaussianModel& model, bool sums_elements)
    : backend_(backend),
      model_(model),
      sums_elements_(sums_elements),
      environment_(backend.memory()),
      pipeline_(backend) {
  for (int k = 0; k < 2; ++k) {
    const GaussianSet& set = k == 0 ? model.static_set : model.dynamic_set;
    if (&set.memory() != &backend.memory()) copies_[k] = set.clone_values(backend.memory());
  }
  if (!model.nodes.empty() && &model.nodes.position.memory() != &backend.memory())
    nodes_ = model.nodes.clone_to(backend.memory(), false);
  environment_.copy_from(model.environment.map.value);
}

void ScoringPass::draw(const FrameSample& sample, int64_t begin, int64_t end) {
  std::vector<int64_t> frames(size_t(end - begin));
  std::iota(frames.begin(), frames.end(), begin);
  draw(sample, frames);
}

void ScoringPass::draw(const FrameSample& sample, const std::vector<int64_t>& frames) {
  views_.clear();
  target_ = {};
  kernels_ = sample.kernels;
  while (truth_.size() < frames.size()) {
    truth_.emplace_back(backend_.memory());
    mask_.emplace_back(backend_.memory());
  }
  for (const int64_t i : frames) {
    const Frame& frame = sample.frame(i);
    const size_t b = views_.size();
    views_.push_back(sample.view(i));
    if (sample.images.empty()) {
      const std::vector<uint8_t>& used = frame.mask.data();
      const Span<const uint8_t> mask = sample.moving.empty() || sample.moving[size_t(i)].empty()
                                           ? Span<const uint8_t>{used.data(), int64_t(used.size())}
                                           : sample.moving[size_t(i)];
      target_.truth.push_back(
          bring({frame.image.data.data(), int64_t(frame.image.data.size())}, truth_[b]));
      target_.mask.push_back(bring(mask, mask_[b]));
    } else {
      target_.truth.push_back(sample.images[size_t(i)]);
      target_.mask.push_back(sample.masks[size_t(i)]);
    }
    if (!sample.maps.empty()) target_.maps.push_back(sample.maps[size_t(i)]);
  }
  draw_batch();
}

void ScoringPass::draw_frames_of(const ScoringPass& other) {
  views_ = other.views_;
  target_ = other.target_;
  kernels_ = other.kernels_;
  draw_batch();
}

void ScoringPass::draw_batch() {
  const auto values = [&](int k, const GaussianSet& set) {
    return copies_[k] ? std::as_const(*copies_[k]).values() : set.values();
  };
  ForwardArgs<float> args{{values(0, model_.static_set), values(1, model_.dynamic_set)},
                          views_,
                          render_options(model_),
                          sums_elements_};
  args.options.kernels = kernels_;
  args.nodes = (nodes_ ? std::as_const(*nodes_) : model_.nodes).spans();
  args.environment = environment_of(model_, std::as_const(environment_).span());
  pipeline_.forward(args);
  pipeline_.residual(target_);
}

double ScoringPass::squared_error() {
  const StageTimer timer(backend_.clock(), kPhotometric);
  return backend_.sum_of_squares(std::as_const(pipeline_.d_colour()).span());
}

void ScoringPass::missed_pixels(Span<uint8_t> missed) {
  const StageTimer timer(backend_.clock(), kPhotometric);
  backend_.missed_pixels(
      {&pipeline_.batch(), std::as_const(pipeline_.d_colour()).span(), target_.mask}, missed);
}

void ScoringPass::compare(ScoringPass& before) {
  const StageTimer timer(backend_.clock(), kPhotometric);
  backend_.added_squares(pipeline_.batch(), std::as_const(before.pipeline_.d_colour()).span(),
                         pipeline_.d_colour().span());
}

void ScoringPass::add_to(ElementBuffers& elements) {
  pipeline_.sensitivity();
  pipeline_.add_contributions(elements.sums.span(), elements.variation.span());
}

}  // namespace tessera
