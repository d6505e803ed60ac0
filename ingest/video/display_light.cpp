// Tables of 65,536 entries replace the curves of one variable; only HLG's system gamma, which
// depends on a pixel's luminance, is a power for each pixel.
#include "ingest/video/display_light.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tessera {
namespace {

constexpr size_t kLevels = 65536;  // of a 16-bit value
constexpr int kRootOne = 65535;    // index of the square root of white's light
constexpr double kHlgGamma = 1.2;  // of the system at 1,000 nits
constexpr double kHlgPeakNits = 1000;
constexpr double kSdrGamma = 2.4;  // BT.1886 with a black of 0

/// Luminance of linear BT.2020 [BT.2100, table 5].
constexpr float kLuminance[3] = {0.2627f, 0.6780f, 0.0593f};
/// Linear BT.709 from linear BT.2020 [BT.2087-0, with more digits].
constexpr float kBt709FromBt2020[3][3] = {{1.660491f, -0.587641f, -0.072850f},
                                          {-0.124550f, 1.132900f, -0.008349f},
                                          {-0.018151f, -0.100579f, 1.118730f}};

double srgb_signal(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// Values of `curve`, whose argument is 1 at `full` and beyond.
template <class Curve>
auto table_of(const Curve& curve, int full) {
  std::vector<decltype(curve(0.0))> table(kLevels);
  for (size_t i = 0; i < kLevels; ++i) table[i] = curve(std::min(double(i) / full, 1.0));
  return table;
}

/// Light by signal: of the scene for HLG, of the display for the others, with white at 1.
const std::vector<float>& light_table(TransferCurve transfer) {
  static const auto kHlg =
      table_of([](double v) { return float(hlg_scene_light(v)); }, kFullSignal);
  static const auto kPq =
      table_of([](double v) { return float(pq_nits(v) / kWhiteNits); }, kFullSignal);
  static const auto kSdr =
      table_of([](double v) { return float(std::pow(v, kSdrGamma)); }, kFullSignal);
  switch (transfer) {
    case TransferCurve::kHlg:
      return kHlg;
    case TransferCurve::kPq:
      return kPq;
    case TransferCurve::kSdr:
    case TransferCurve::kNone:
      break;
  }
  return kSdr;
}

/// 8-bit values by the square root of light, which resolves the dark ones.
const std::vector<uint8_t>& code_table(TransferCurve transfer) {
  static const auto kSrgb = table_of(
      [](double root) { return uint8_t(std::lround(255 * srgb_signal(root * root))); }, kRootOne);
  static const auto kSdr = table_of(
      [](double root) { return uint8_t(std::lround(255 * std::pow(root, 2 / kSdrGamma))); },
      kRootOne);
  return transfer == TransferCurve::kSdr ? kSdr : kSrgb;
}

/// The gain of the OOTF, with white at 1 [BT.2100, table 5]: F_D = α Y_S^(γ−1) E.
float hlg_gain(const float* scene) {
  constexpr auto kPeak = float(kHlgPeakNits / kWhiteNits);
  const float luminance =
      kLuminance[0] * scene[0] + kLuminance[1] * scene[1] + kLuminance[2] * scene[2];
  return kPeak * std::pow(luminance, float(kHlgGamma - 1));
}

}  // namespace

double hlg_scene_light(double signal) {
  constexpr double kA = 0.17883277, kB = 1 - 4 * kA;
  const double c = 0.5 - kA * std::log(4 * kA);
  return signal <= 0.5 ? signal * signal / 3 : (std::exp((signal - c) / kA) + kB) / 12;
}

double pq_nits(double signal) {
  constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 4096 * 128;
  constexpr double kC1 = 3424.0 / 4096, kC2 = 2413.0 / 4096 * 32, kC3 = 2392.0 / 4096 * 32;
  const double power = std::pow(signal, 1 / kM2);
  return 10000 * std::pow(std::max(power - kC1, 0.0) / (kC2 - kC3 * power), 1 / kM1);
}

void srgb_of(const FrameColour& colour, const uint16_t* rgb, size_t pixels, uint8_t* srgb) {
  const std::vector<float>& light_of = light_table(colour.transfer);
  const std::vector<uint8_t>& code_of = code_table(colour.transfer);
  const bool wide = colour.primaries == ColourPrimaries::kBt2020;
  for (size_t p = 0; p < pixels; ++p, rgb += 3, srgb += 3) {
    const float light[3] = {light_of[rgb[0]], light_of[rgb[1]], light_of[rgb[2]]};
    const float gain = colour.transfer == TransferCurve::kHlg ? hlg_gain(light) : 1;
    for (size_t c = 0; c < 3; ++c) {
      const float* row = kBt709FromBt2020[c];
      const float shown =
          gain * (wide ? row[0] * light[0] + row[1] * light[1] + row[2] * light[2] : light[c]);
      srgb[c] = code_of[size_t(std::sqrt(std::clamp(shown, 0.0f, 1.0f)) * float(kRootOne) + 0.5f)];
    }
  }
}

}  // namespace tessera
