// Convolution of a plane with the separable SSIM window, with zero or reflected borders. The loss
// and the metrics share it.
#pragma once
#include <algorithm>
#include <cstring>
#include <vector>

#include "kernels/math/photometric.h"

namespace tessera {

/// Outside the image: zeros (training loss, 3DGS metrics) or mirror without repeating the edge
/// (torchmetrics); reflection needs width and height > kSsimRadius.
enum class Padding { kZero, kReflect };

/// Index of sample i of a line of `count` samples, or −1 for a zero.
inline int padded_index(int i, int count, Padding padding) {
  if (i >= 0 && i < count) return i;
  if (padding == Padding::kZero) return -1;
  return i < 0 ? -i : 2 * (count - 1) - i;
}

/// to[x] = Σ_k window[k] · line(k)[x], x < width, without the lines that are null. The sums of
/// several samples are held in registers.
template <class Real, class Line>
void weigh(int width, const Line& line, Real* to) {
  constexpr int kBytes = 32, kLanes = kBytes / sizeof(Real);
  using Lanes [[gnu::vector_size(kBytes)]] = Real;
  const Real* lines[kSsimTaps];
  for (int k = 0; k < kSsimTaps; ++k) lines[k] = line(k);
  const auto sum_at = [&](int x, size_t bytes) {
    Lanes sum = {};
    for (int k = 0; k < kSsimTaps; ++k) {
      if (lines[k] == nullptr) continue;
      Lanes samples = {};
      std::memcpy(&samples, lines[k] + x, bytes);
      sum += kSsimWindow<Real>[k] * samples;
    }
    std::memcpy(to + x, &sum, bytes);
  };
  int x = 0;
  for (; x + kLanes <= width; x += kLanes) sum_at(x, sizeof(Lanes));
  sum_at(x, size_t(width - x) * sizeof(Real));
}

/// A line of samples with the border that the window reaches into.
template <class Real>
class PaddedLine {
 public:
  explicit PaddedLine(int width)
      : samples_(size_t(width) + 2 * kSsimRadius, Real(0)), width_(width) {}

  Real* samples() { return samples_.data() + kSsimRadius; }  // [width] to be written

  /// The window over each sample, [width].
  void convolve(Padding padding, Real* to) {
    Real* const first = samples();
    if (padding == Padding::kReflect)
      for (int k = 1; k <= kSsimRadius; ++k) {
        first[-k] = first[k];
        first[width_ - 1 + k] = first[width_ - 1 - k];
      }
    weigh(
        width_, [&](int k) { return samples_.data() + k; }, to);
  }

 private:
  std::vector<Real> samples_;
  int width_;
};

/// The window over row y of lines whose rows are at row(i), [width].
template <class Real, class Row>
void convolve_column(int y, int width, int height, Padding padding, const Row& row, Real* to) {
  const auto line = [&](int k) -> const Real* {
    const int from_row = padded_index(y + k - kSsimRadius, height, padding);
    return from_row < 0 ? nullptr : row(from_row);
  };
  weigh(width, line, to);
}

/// in and out [height, width]; `scratch` of the same size; out may be in.
template <class Real>
void convolve(const Real* in, int width, int height, Padding padding, Real* scratch, Real* out) {
  PaddedLine<Real> line(width);
  for (int y = 0; y < height; ++y) {
    std::copy_n(in + int64_t(y) * width, width, line.samples());
    line.convolve(padding, scratch + int64_t(y) * width);
  }
  const auto row = [&](int y) { return scratch + int64_t(y) * width; };
  for (int y = 0; y < height; ++y)
    convolve_column(y, width, height, padding, row, out + int64_t(y) * width);
}

/// The four windowed moments of two planes, row after row, of which as many are held as the window
/// is high.
template <class Real>
class MomentRows {
 public:
  MomentRows(int width, int height, Padding padding)
      : width_(width), height_(height), padding_(padding), lines_(kCount, PaddedLine<Real>(width)) {
    convolved_.resize(size_t(kSsimTaps * kCount) * size_t(width));
    sums_.resize(size_t(kCount) * size_t(width));
  }

  /// Calls read(y, a, b), which writes row y of both planes, [width] each, for every y in order,
  /// and body(y, moments) in order, where moments(x) has those of pixel x. Each read is asked for
  /// once, up to kSsimRadius rows ahead.
  template <class Read, class Body>
  void compute(const Read& read, const Body& body) {
    int next = 0;
    for (int y = 0; y < height_; ++y) {
      for (; next < height_ && next <= y + kSsimRadius; ++next) add_row(next, read);
      for (int m = 0; m < kCount; ++m)
        convolve_column(
            y, width_, height_, padding_, [&](int row) { return convolved(row, m); }, sum(m));
      body(y, [&](int x) { return SsimMoments<Real>{sum(0)[x], sum(1)[x], sum(2)[x], sum(3)[x]}; });
    }
  }

 private:
  static constexpr int kCount = 4;

  Real* sum(int moment) { return sums_.data() + int64_t(moment) * width_; }
  Real* convolved(int row, int moment) {
    return convolved_.data() + int64_t(row % kSsimTaps * kCount + moment) * width_;
  }

  template <class Read>
  void add_row(int y, const Read& read) {
    Real *const a = lines_[0].samples(), *const b = lines_[1].samples(),
                *const squares = lines_[2].samples(), *const xy = lines_[3].samples();
    read(y, a, b);
    for (int x = 0; x < width_; ++x) {
      squares[x] = a[x] * a[x] + b[x] * b[x];
      xy[x] = a[x] * b[x];
    }
    for (int m = 0; m < kCount; ++m) lines_[size_t(m)].convolve(padding_, convolved(y, m));
  }

  int width_, height_;
  Padding padding_;
  std::vector<PaddedLine<Real>> lines_;
  std::vector<Real> convolved_, sums_;
};

}  // namespace tessera
