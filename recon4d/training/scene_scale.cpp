// Area averages by box filters over rows and then over columns, without OpenCV, which a
// trainer-only build lacks.
#include "recon4d/training/scene_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// The share of every old pixel [first, first + weight.size()) in a new one; they sum to 1.
struct Window {
  int first = 0;
  std::vector<float> weight;
};

std::vector<Window> windows(int from, int to) {
  std::vector<Window> all;
  const double step = double(from) / to;
  for (int i = 0; i < to; ++i) {
    const double begin = i * step, end = std::min<double>(from, (i + 1) * step);
    Window window{int(begin), {}};
    for (int j = window.first; j < from && j < end; ++j)
      window.weight.push_back(
          float((std::min<double>(end, j + 1) - std::max<double>(begin, j)) / step));
    all.push_back(std::move(window));
  }
  return all;
}

int scaled_side(int side, double scale) {
  return std::max(1, int(std::lround(side * scale)));
}

/// Where all pixels that it comes from are used.
Image8 scaled_mask(const Image8& mask, int width, int height) {
  Image8 scaled = averaged_image(mask, width, height);
  for (uint8_t& used : scaled.data) used = used == 255 ? 255 : 0;
  return scaled;
}

}  // namespace

Image8 averaged_image(const Image8& image, int width, int height) {
  check(width > 0 && height > 0 && width <= image.width && height <= image.height,
        "averaged_image: size");
  const int channels = image.channels;
  const std::vector<Window> columns = windows(image.width, width);
  const std::vector<Window> rows = windows(image.height, height);
  Image8 out{width, height, channels, {}};
  out.data.resize(size_t(width) * size_t(height) * size_t(channels));
  parallel_for(height, 8, [&](int64_t begin, int64_t end) {
    std::vector<float> sum(size_t(image.width) * size_t(channels));
    for (int64_t y = begin; y < end; ++y) {
      const Window& row = rows[size_t(y)];
      std::fill(sum.begin(), sum.end(), 0.0f);
      for (size_t j = 0; j < row.weight.size(); ++j) {
        const uint8_t* from = image.data.data() + (size_t(row.first) + j) * sum.size();
        for (size_t i = 0; i < sum.size(); ++i) sum[i] += row.weight[j] * float(from[i]);
      }
      uint8_t* to = out.data.data() + size_t(y) * size_t(width * channels);
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < channels; ++c) {
          const Window& column = columns[size_t(x)];
          float value = 0;
          for (size_t j = 0; j < column.weight.size(); ++j)
            value +=
                column.weight[j] * sum[(size_t(column.first) + j) * size_t(channels) + size_t(c)];
          to[x * channels + c] = uint8_t(std::clamp(std::floor(value + 0.5f), 0.0f, 255.0f));
        }
    }
  });
  return out;
}

Image8 narrowed_image(const Image8& image, int width) {
  if (image.width <= width) return image;
  const double height = double(width) * image.height / image.width;
  return averaged_image(image, width, std::max(1, int(std::lround(height))));
}

Camera limited_camera(const Camera& camera, int longest) {
  const double scale = double(longest) / std::max(camera.width, camera.height);
  if (scale >= 1) return camera;
  return camera.resized(scaled_side(camera.width, scale), scaled_side(camera.height, scale));
}

Frame scaled_frame(const Frame& frame, double scale) {
  check(scale > 0 && scale <= 1, "scaled_frame: a scale of at most 1");
  if (scale == 1) return frame;
  const int width = scaled_side(frame.image.width, scale);
  const int height = scaled_side(frame.image.height, scale);
  Frame scaled{frame.name,
               frame.camera_name,
               frame.frame_number,
               frame.time,
               frame.timestep,
               frame.split,
               frame.camera.resized(width, height),
               frame.image.data.empty() ? Image8{width, height, 3, {}}
                                        : averaged_image(frame.image, width, height),
               {}};
  if (!frame.mask.data().empty()) scaled.mask = scaled_mask(frame.mask.image(), width, height);
  return scaled;
}

Scene scaled_scene(Scene scene, double scale) {
  if (scale == 1) return scene;
  std::map<const Image8*, FrameMask> masks;  // scaled, by those that frames share
  for (Frame& frame : scene.frames) {
    const FrameMask full = std::exchange(frame.mask, {});
    frame = scaled_frame(frame, scale);
    if (full.data().empty()) continue;
    FrameMask& mask = masks[full.shared()];
    if (mask.data().empty())
      mask = scaled_mask(full.image(), frame.image.width, frame.image.height);
    frame.mask = mask;
  }
  return scene;
}

double truth_scale(double scale, double train_scale) {
  constexpr double kRounding = 1e-9;
  const double truth = scale * train_scale;
  if (truth > 1 + kRounding)
    throw InputError(fmt::format(
        "scale {}: needs images of {} times the scene's size; train with --train-scale {} or "
        "less, so that there are true ones",
        scale, truth, 1 / scale));
  return std::min(truth, 1.0);
}

}  // namespace tessera
