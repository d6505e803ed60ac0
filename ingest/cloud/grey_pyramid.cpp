// Averages 2 × 2 pixels from level to level; windows are bilinear, their gradients central
// differences.
#include "ingest/cloud/grey_pyramid.h"

#include <cmath>
#include <numeric>

namespace tessera {
namespace {

constexpr int kWide = GreyWindow::kSide + 2;  // with a pixel on either side, for differences

GreyImage halved(const GreyImage& image) {
  GreyImage half{image.width / 2, image.height / 2, {}};
  half.level.reserve(size_t(half.width) * size_t(half.height));
  for (int y = 0; y < half.height; ++y) {
    const uint8_t* upper = image.level.data() + size_t(2 * y) * size_t(image.width);
    const uint8_t* lower = upper + image.width;
    for (int x = 0; x < 2 * half.width; x += 2)
      half.level.push_back(uint8_t((upper[x] + upper[x + 1] + lower[x] + lower[x + 1] + 2) / 4));
  }
  return half;
}

template <size_t count>
void take_mean_out(std::array<float, count>& values) {
  const float mean = std::accumulate(values.begin(), values.end(), 0.0f) / float(count);
  for (float& value : values) value -= mean;
}

/// side × side levels around (u, v), bilinear.
template <int side>
std::array<float, size_t(side* side)> levels_around(const GreyImage& image, double u, double v) {
  const double left = std::floor(u - 0.5), top = std::floor(v - 0.5);
  const float a = float(u - 0.5 - left), b = float(v - 0.5 - top);
  const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
  using Row = std::array<float, size_t(side) + 1>;
  const auto read = [&](int y, Row& row) {
    const uint8_t* from = image.level.data() +
                          size_t(int(top) + y - side / 2) * size_t(image.width) +
                          size_t(int(left) - side / 2);
    for (size_t x = 0; x < row.size(); ++x) row[x] = float(from[x]);
  };
  std::array<float, size_t(side * side)> levels;
  Row upper, lower;
  read(0, upper);
  for (int y = 0; y < side; ++y, upper = lower) {
    read(y + 1, lower);
    float* to = levels.data() + y * side;
    for (size_t x = 0; x < size_t(side); ++x)
      to[x] = w00 * upper[x] + w10 * upper[x + 1] + w01 * lower[x] + w11 * lower[x + 1];
  }
  return levels;
}

}  // namespace

GreyPyramid grey_pyramid(const Image8& image) {
  GreyPyramid pyramid{grey_image(image)};
  while (int(pyramid.size()) < kPyramidLevels && pyramid.back().width >= 2 * kWide &&
         pyramid.back().height >= 2 * kWide)
    pyramid.push_back(halved(pyramid.back()));
  return pyramid;
}

bool has_window(const GreyImage& image, double u, double v) {
  constexpr double kBorder = GreyWindow::kRadius + 2;
  return u >= kBorder && v >= kBorder && u < image.width - kBorder && v < image.height - kBorder;
}

GreyWindow window_at(const GreyImage& image, double u, double v) {
  GreyWindow window{levels_around<GreyWindow::kSide>(image, u, v)};
  take_mean_out(window.level);
  return window;
}

WindowGradient gradient_at(const GreyImage& image, double u, double v) {
  const auto wide = levels_around<kWide>(image, u, v);
  WindowGradient gradient;
  size_t i = 0;
  for (size_t y = 1; y + 1 < size_t(kWide); ++y)
    for (size_t x = 1; x + 1 < size_t(kWide); ++x, ++i) {
      const size_t k = y * size_t(kWide) + x;
      gradient.along_u[i] = 0.5f * (wide[k + 1] - wide[k - 1]);
      gradient.along_v[i] = 0.5f * (wide[k + size_t(kWide)] - wide[k - size_t(kWide)]);
    }
  take_mean_out(gradient.along_u);
  take_mean_out(gradient.along_v);
  return gradient;
}

float difference(const GreyWindow& a, const GreyWindow& b) {
  float sum = 0;
  for (size_t i = 0; i < a.level.size(); ++i) sum += std::abs(a.level[i] - b.level[i]);
  return sum / float(GreyWindow::kPixels);
}

}  // namespace tessera
