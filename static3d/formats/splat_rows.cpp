// The .splat format: rows of 32 bytes without a header (f32 mean, f32 linear scale, u8 colour and
// opacity, u8 quaternion w,x,y,z) and colours without direction. Source: formats 1.3
// (antimatter15/splat, MIT), written from its layout.
#include "static3d/formats/splat_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/math/spherical_harmonics.h"
#include "static3d/transform/splat_quanta.h"

namespace tessera {
namespace {

constexpr uint64_t kRowBytes = 32;
constexpr double kQuaternionStep = 128;
constexpr float kLeastScale = 1e-10f;  // world units: 0 has no logarithm

void read_row(ByteReader& bytes, const GaussianSpans<float>& to, int64_t n) {
  for (int k = 0; k < 3; ++k) to.at(kMean, n)[k] = bytes.number<float>();
  for (int k = 0; k < 3; ++k)
    to.at(kLogScale, n)[k] = std::log(std::max(bytes.number<float>(), kLeastScale));
  for (int k = 0; k < 3; ++k)
    to.at(kSh, n)[k] = float((bytes.number<uint8_t>() / 255.0 - 0.5) / kSh0);
  *to.at(kOpacityLogit, n) = logit_of_byte(bytes.number<uint8_t>());
  for (int k = 0; k < 4; ++k)
    to.at(kRotation, n)[k] = float((bytes.number<uint8_t>() - kQuaternionStep) / kQuaternionStep);
}

void append_row(std::string& bytes, const GaussianSpans<const float>& from, int64_t n) {
  for (int k = 0; k < 3; ++k) append(bytes, from.at(kMean, n)[k]);
  for (int k = 0; k < 3; ++k) append(bytes, std::exp(from.at(kLogScale, n)[k]));
  for (int k = 0; k < 3; ++k) append(bytes, byte_of(255 * (0.5 + kSh0 * from.at(kSh, n)[k])));
  append(bytes, opacity_byte(*from.at(kOpacityLogit, n)));
  for (int k = 0; k < 4; ++k)
    append(bytes, byte_of(kQuaternionStep * double(from.at(kRotation, n)[k]) + kQuaternionStep));
}

}  // namespace

SplatFile load_splat_rows(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  if (text.empty() || text.size() % kRowBytes != 0)
    throw InputError(
        fmt::format("{}: {} bytes are no whole number of splats of {}; it is cut off or no .splat",
                    path.string(), text.size(), kRowBytes));
  SplatFile file;
  file.set = GaussianSet(SetForm::kStatic, 1);
  file.set.resize(int64_t(text.size() / kRowBytes));
  ByteReader bytes(text, path);
  for (int64_t n = 0; n < file.set.count(); ++n) read_row(bytes, file.set.values(), n);
  return file;
}

void save_splat_rows(const std::filesystem::path& path, const GaussianSet& set) {
  const GaussianSpans<const float> values = set.values();
  std::vector<double> importance(size_t(set.count()));
  for (int64_t n = 0; n < set.count(); ++n) {
    const float* const s = values.at(kLogScale, n);
    importance[size_t(n)] =
        double(s[0]) + s[1] + s[2] + std::log(sigmoid(double(*values.at(kOpacityLogit, n))));
  }
  std::vector<int64_t> order(size_t(set.count()));
  std::iota(order.begin(), order.end(), int64_t{0});
  std::stable_sort(order.begin(), order.end(), [&](int64_t a, int64_t b) {
    return importance[size_t(a)] > importance[size_t(b)];
  });
  std::string bytes;
  bytes.reserve(size_t(set.count()) * kRowBytes);
  for (int64_t n : order) append_row(bytes, values, n);
  write_text_file(path, bytes);
}

}  // namespace tessera
