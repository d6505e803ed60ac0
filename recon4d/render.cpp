// What: forward through the pipeline, pictures out of the backend's memory.
// Not: any pixel arithmetic but alpha = 1 − transmittance.
#include "recon4d/render.h"

namespace tessera {

RenderOptions render_options(const GaussianModel& model) {
  RenderOptions options;
  options.sh_degree = model.sh_degree;
  for (size_t c = 0; c < 3; ++c) options.background[c] = model.background[c] / 255.0;
  options.near_plane = model.near_plane, options.far_plane = model.far_plane;
  return options;
}

std::vector<Picture> Renderer::render(const std::vector<View>& views) {
  std::vector<Picture> pictures;
  if (views.empty()) return pictures;
  const Images<float>& images =
      pipeline_.forward(model_.static_set.values(), model_.dynamic_set.values(), views, options_);
  for (const ViewArgs<float>& view : pipeline_.batch().views) {
    const size_t pixels = size_t(view.width) * size_t(view.height);
    Picture picture{view.width, view.height, std::vector<float>(3 * pixels),
                    std::vector<float>(pixels)};
    Memory& memory = backend_.memory();
    memory.copy(picture.rgb.data(), images.colour.data() + 3 * view.first_pixel,
                3 * pixels * sizeof(float));
    memory.copy(picture.alpha.data(), images.transmittance.data() + view.first_pixel,
                pixels * sizeof(float));
    for (float& value : picture.alpha) value = 1.0f - value;
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

std::vector<Picture> render_views(Backend& backend, const GaussianModel& model,
                                  const std::vector<View>& views) {
  return Renderer(backend, model).render(views);
}

}  // namespace tessera
