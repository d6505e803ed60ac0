// Forward passes through the pipeline, images copied from the backend's memory, and render rates
// from the backend's clock.
#include "recon4d/evaluation/render.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/seconds_since.h"

namespace tessera {
namespace {

double stage_seconds(Backend& backend) {
  double sum = 0;
  for (const StageTotals& stage : backend.clock().totals()) sum += stage.seconds;  // waits
  return sum;
}

}  // namespace

RenderOptions render_options(const GaussianModel& model) {
  RenderOptions options;
  static_cast<DrawingRules&>(options) = model.drawing;
  for (size_t c = 0; c < 3; ++c) options.background[c] = model.background[c] / 255.0;
  if (model.environment.height > 0) std::fill_n(options.background, 3, 0.0);  // it is behind all
  return options;
}

EnvironmentArgs<float> environment_of(const GaussianModel& model, Span<const float> map) {
  if (map.empty()) map = model.environment.map.value.span();
  return {nullptr, map, model.environment.height, Mat3<float>(model.environment.map_from_world)};
}

Renderer::Renderer(Backend& backend, const GaussianModel& model)
    : backend_(backend),
      model_(model),
      options_(render_options(model)),
      pipeline_(backend),
      environment_(backend.memory()) {
  refresh();
}

void Renderer::draw_no_background() {
  background_ = false;
  std::fill_n(options_.background, 3, 0.0);
}

void Renderer::refresh() {
  for (int k = 0; k < 2; ++k) {
    const GaussianSet& model_set = k == 0 ? model_.static_set : model_.dynamic_set;
    copies_[k].reset();
    if (&model_set.memory() != &backend_.memory())
      copies_[k] = model_set.clone_values(backend_.memory());
  }
  nodes_.reset();
  if (!model_.nodes.empty() && &model_.nodes.position.memory() != &backend_.memory())
    nodes_ = model_.nodes.clone_to(backend_.memory(), false);
  const Buffer<float>& map = model_.environment.map.value;
  if (!map.empty() && &map.memory() != &backend_.memory()) environment_.copy_from(map);
}

const GaussianSet& Renderer::set(int k) const {
  return copies_[k] ? *copies_[k] : k == 0 ? model_.static_set : model_.dynamic_set;
}

const Images<float>& Renderer::draw(const std::vector<View>& views) {
  ForwardArgs<float> args{{set(0).values(), set(1).values()}, views, options_, {}};
  args.nodes = (nodes_ ? std::as_const(*nodes_) : model_.nodes).spans();
  if (background_) args.environment = environment_of(model_, std::as_const(environment_).span());
  return pipeline_.forward(args);
}

std::vector<RenderedImage> Renderer::render(const std::vector<View>& views) {
  std::vector<RenderedImage> images(views.size());
  render(views, {images.data(), int64_t(images.size())});
  return images;
}

void Renderer::render(const std::vector<View>& views, Span<RenderedImage> to) {
  check(to.size == int64_t(views.size()), "Renderer: one image a view");
  if (views.empty()) return;
  const Images<float>& images = draw(views);
  Memory& memory = backend_.memory();
  for (size_t i = 0; i < views.size(); ++i) {
    const ViewArgs<float>& view = pipeline_.batch().views[i];
    const size_t pixels = size_t(view.width) * size_t(view.height);
    RenderedImage& image = to[int64_t(i)];
    image.width = view.width;
    image.height = view.height;
    image.rgb.resize(3 * pixels);
    image.alpha.resize(pixels);
    memory.copy(image.rgb.data(), images.colour.data() + 3 * view.first_pixel,
                3 * pixels * sizeof(float));
    memory.copy(image.alpha.data(), images.transmittance.data() + view.first_pixel,
                pixels * sizeof(float));
    for (float& value : image.alpha) value = 1.0f - value;
  }
}

std::vector<RenderedImage> render_views(Backend& backend, const GaussianModel& model,
                                        const std::vector<View>& views) {
  return Renderer(backend, model).render(views);
}

RenderRate measure_render_rate(Backend& backend, const GaussianModel& model,
                               const std::vector<View>& views, const RenderRateOptions& options) {
  using Clock = std::chrono::steady_clock;
  check(!views.empty() && options.frames > 0, "measure_render_rate: views and frames");
  Renderer renderer(backend, model);
  const auto draw = [&](int64_t i) { renderer.draw({views[size_t(i) % views.size()]}); };
  const Clock::time_point start = Clock::now();
  for (int64_t i = 0; i < options.warm_up && (i == 0 || seconds_since(start) < options.seconds / 4);
       ++i)
    draw(i);
  RenderRate rate;
  rate.width = views.front().camera.width;
  rate.height = views.front().camera.height;
  rate.num_gaussians = model.count();
  const double before = stage_seconds(backend);
  const Clock::time_point begin = Clock::now();
  while (rate.frames < options.frames &&
         (rate.frames == 0 || seconds_since(begin) < options.seconds))
    draw(rate.frames++);
  rate.seconds = stage_seconds(backend) - before;
  rate.wall_seconds = seconds_since(begin);
  return rate;
}

}  // namespace tessera
