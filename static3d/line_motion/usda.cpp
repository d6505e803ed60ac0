// A clip for OpenUSD 26.03 as text: ParticleField3DGaussianSplat prims, one of what stands still
// and one of what moves, whose positions have two time samples, between which USD interpolates
// along the lines, and whose opacities have one a frame. The world is turned by half a turn about
// x, to y up. Source: UsdVol's ParticleField3DGaussianSplat, user guide of OpenUSD.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"
#include "kernels/math/splat.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/splat_file.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/lines.h"
#include "static3d/transform/world_change.h"

namespace tessera {
namespace {

constexpr double kLeastOpacity = 1.0 / 255;  // which no renderer shows
constexpr int64_t kMostFrames = 100'000;
constexpr double kMostText = 4e9;  // bytes, which is held in memory

/// [(1, 2, 3), (4, 5, 6)] of `width` numbers a row; plain numbers of one.
template <class Value>
void append_rows(std::string& text, int64_t count, int width, const Value& value) {
  text += '[';
  for (int64_t n = 0; n < count; ++n) {
    if (n > 0) text += ", ";
    if (width > 1) text += '(';
    for (int k = 0; k < width; ++k)
      fmt::format_to(std::back_inserter(text), "{}{:.6g}", k > 0 ? ", " : "", value(n, k));
    if (width > 1) text += ')';
  }
  text += ']';
}

/// The attributes of a prim, indented.
class Prim {
 public:
  Prim(const char* name, const GaussianSpans<const float>& set) : set_(set) {
    text_ = fmt::format("def ParticleField3DGaussianSplat \"{}\"\n{{\n", name);
    text_ +=
        "    uniform token projectionModeHint = \"perspective\"\n"
        "    uniform token sortingModeHint = \"zDepth\"\n";
  }
  template <class Value>
  void add(const std::string& name, int64_t rows, int width, const Value& value) {
    text_ += fmt::format("    {} = ", name);
    append_rows(text_, rows, width, value);
    text_ += '\n';
  }
  /// Rows at some times.
  template <class Value>
  void add_samples(const std::string& name, const std::vector<double>& codes, int width,
                   const Value& value) {
    text_ += fmt::format("    {}.timeSamples = {{\n", name);
    for (size_t i = 0; i < codes.size(); ++i) {
      text_ += fmt::format("        {}: ", codes[i]);
      append_rows(text_, set_.count, width, [&](int64_t n, int k) { return value(i, n, k); });
      text_ += ",\n";
    }
    text_ += "    }\n";
  }
  /// What does not change with time.
  void add_constants() {
    add("quatf[] orientations", set_.count, 4,
        [&](int64_t n, int k) { return set_.at(kRotation, n)[k]; });
    add("float3[] scales", set_.count, 3,
        [&](int64_t n, int k) { return std::exp(set_.at(kLogScale, n)[k]); });
    text_ += fmt::format("    uniform int radiance:sphericalHarmonicsDegree = {}\n",
                         sh_degree_of(set_.coefficients));
    const int64_t width = set_.coefficients;
    add("float3[] radiance:sphericalHarmonicsCoefficients", set_.count * width, 3,
        [&](int64_t i, int k) { return set_.at(kSh, i / width)[3 * (i % width) + k]; });
  }
  std::string text() const { return text_ + "}\n"; }

 private:
  const GaussianSpans<const float>& set_;
  std::string text_;
};

/// Sound, with unit quaternions and SH of `degree`, in USD's world.
GaussianSet in_usd_world(const GaussianSet& from, SetForm form, int degree) {
  GaussianSet set = sound_set(joined_sets({&from}, form, sh_coefficients(degree)));
  flip_axes(set, kRightUpBack);
  return set;
}

std::string still_prim(const GaussianSpans<const float>& set) {
  Prim prim("Still", set);
  prim.add("point3f[] positions", set.count, 3,
           [&](int64_t n, int k) { return set.at(kMean, n)[k]; });
  prim.add("float[] opacities", set.count, 1,
           [&](int64_t n, int) { return sigmoid(*set.at(kOpacityLogit, n)); });
  prim.add_constants();
  return prim.text();
}

std::string moving_prim(const GaussianSpans<const float>& set, int64_t frames) {
  Prim prim("Moving", set);
  const double last = double(std::max<int64_t>(frames - 1, 1));
  prim.add_samples("point3f[] positions", {0, last}, 3, [&](size_t i, int64_t n, int k) {
    const double t = double(i) - double(*set.at(kMeanTime, n));
    return double(set.at(kMean, n)[k]) + t * double(set.at(kVelocity, n)[k]);
  });
  std::vector<double> codes;
  for (int64_t i = 0; i < frames; ++i) codes.push_back(double(i));
  prim.add_samples("float[] opacities", codes, 1, [&](size_t i, int64_t n, int) {
    const double apart = (double(i) / last - double(*set.at(kMeanTime, n))) /
                         std::exp(double(*set.at(kLogScaleTime, n)));
    const double opacity =
        sigmoid(double(*set.at(kOpacityLogit, n))) * std::exp(-0.5 * apart * apart);
    return opacity < kLeastOpacity ? 0.0 : opacity;
  });
  prim.add_constants();
  return prim.text();
}

}  // namespace

int64_t save_usda(const std::filesystem::path& path, const GaussianModel& model, double fps) {
  const double rate = fps > 0 ? fps : kUnstatedRate;
  const bool moves = model.dynamic_set.count() > 0;
  const double frames = moves ? 1 + std::round(model.time_axis.duration * rate) : 1;
  if (frames > double(kMostFrames))
    throw InputError(fmt::format("{}: {} frames are more than one .usda holds; pass a lower --fps",
                                 path.string(), frames));
  const int degree = drawn_degree(model);
  constexpr double kNumber = 10, kZero = 3;  // characters
  const double text = kNumber * double(model.count()) * (3 * sh_coefficients(degree) + 14) +
                      kZero * frames * double(model.dynamic_set.count());
  if (text > kMostText)
    throw InputError(
        fmt::format("{}: {} Gaussians that move, over {} frames, would be {:.0f} GB of text or "
                    "more; take --format glb or ply, a file a frame",
                    path.string(), model.dynamic_set.count(), frames, text / 1e9));
  const GaussianSet still = in_usd_world(model.static_set, SetForm::kStatic, degree);
  const GaussianSet moving = in_usd_world(model.dynamic_set, SetForm::kVelocity, degree);
  AtomicFile output(path);
  output.write(
      fmt::format("#usda 1.0\n(\n    defaultPrim = \"{}\"\n    metersPerUnit = 1\n"
                  "    upAxis = \"Y\"\n    startTimeCode = 0\n    endTimeCode = {}\n"
                  "    timeCodesPerSecond = {}\n    doc = \"tessera\"\n)\n\n",
                  "Clip", frames - 1, rate));
  output.write("def Xform \"Clip\"\n{\n");
  output.write(still_prim(std::as_const(still).values()));
  if (moves) output.write("\n" + moving_prim(std::as_const(moving).values(), int64_t(frames)));
  output.write("}\n");
  output.commit();
  return 0;
}

}  // namespace tessera
