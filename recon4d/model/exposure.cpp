// Rows of gains or affine maps, their normalisation and their optimizer steps. The trainer and the
// schedule choose the steps and learning rates.
#include "recon4d/model/exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/math/adam.h"

namespace tessera {
namespace {

constexpr double kGrid = 262144;     // steps of a gain in 1
constexpr float kMostStops = 3;      // |log2 gain|: gains and their ratio to the mean fit a float
constexpr float kMostAffine = 0.5f;  // of each number, before the gauge
constexpr double kAffineRate = 0.1;  // of the rate of log gains
constexpr double kAffineWeight = 1e-3;  // of the squares of an affine map in the loss
constexpr int kAffineWidth = exposure_width(ExposureGains::kAffine);

/// Mean gain of a channel before the gauge is fixed.
double mean_gain(const LearntRows& state, int channel) {
  double sum = 0;
  for (int64_t r = 0; r < state.rows(); ++r) sum += std::exp(double(state.value[3 * r + channel]));
  return sum / double(state.rows());
}

void fix_gain_gauge(LearntRows& state) {
  const float most = kMostStops * std::log(2.0f);
  for (int c = 0; c < 3; ++c) {
    const double shift = std::log(mean_gain(state, c));
    for (int64_t r = 0; r < state.rows(); ++r) {
      float& log_gain = state.value[3 * r + c];
      log_gain = std::clamp(float(double(log_gain) - shift), -most, most);
    }
  }
}

void fix_affine_gauge(LearntRows& state) {
  for (int i = 0; i < kAffineWidth; ++i) {
    double mean = 0;
    for (int64_t r = 0; r < state.rows(); ++r) {
      float& value = state.value[kAffineWidth * r + i];
      value = std::clamp(value, -kMostAffine, kMostAffine);
      mean += double(value) / double(state.rows());
    }
    for (int64_t r = 0; r < state.rows(); ++r) {
      float& value = state.value[kAffineWidth * r + i];
      value = float(double(value) - mean);
    }
  }
}

/// [R] RGB, as colour_maps_of has them.
std::vector<Vec3<double>> gains_of(const LearntRows& state) {
  const int64_t rows = state.rows();
  std::vector<Vec3<double>> gains(static_cast<size_t>(rows));
  for (int c = 0; c < 3 && rows > 0; ++c) {
    const double mean = mean_gain(state, c);
    int64_t missing = rows * int64_t(kGrid);
    for (int64_t r = 0; r < rows; ++r) {
      const double gain = std::exp(double(state.value[3 * r + c])) / mean;
      gains[size_t(r)][c] = double(std::llround(kGrid * gain));
      missing -= int64_t(gains[size_t(r)][c]);
    }
    // rounding left at most half a step a row
    for (int64_t r = 0; r < rows; ++r) {
      const int64_t part = r < std::abs(missing) ? (missing > 0 ? 1 : -1) : 0;
      gains[size_t(r)][c] = (gains[size_t(r)][c] + double(part)) / kGrid;
    }
  }
  return gains;
}

/// The numbers of an affine row as they lie in a state.
using AffineRow = std::array<double, kAffineWidth>;

AffineRow row_of(const ColourMap<double>& map) {
  AffineRow row;
  for (int i = 0; i < 9; ++i) row[size_t(i)] = map.matrix[i / 3][i % 3];
  for (int c = 0; c < 3; ++c) row[size_t(9 + c)] = map.offset[c];
  return row;
}

ColourMap<double> affine_map(const float* row) {
  ColourMap<double> map;
  for (int i = 0; i < 9; ++i) map.matrix[i / 3][i % 3] += double(row[i]);
  for (int c = 0; c < 3; ++c) map.offset[c] = double(row[9 + c]);
  return map;
}

/// By the numbers of a row, for the sum of the gradients of its views. `share`: of the rows that a
/// batch draws.
std::vector<double> row_gradient(const LearntRows& state, int64_t row,
                                 const std::vector<Vec3<double>>& gains,
                                 const ColourMap<double>& d_map, double share) {
  std::vector<double> gradient;
  if (state.width() == 3) {
    for (int c = 0; c < 3; ++c) gradient.push_back(gains[size_t(row)][c] * d_map.matrix[c][c]);
    return gradient;
  }
  const AffineRow d_row = row_of(d_map);
  for (int i = 0; i < kAffineWidth; ++i)
    gradient.push_back(d_row[size_t(i)] +
                       2 * kAffineWeight / share * double(state.value[kAffineWidth * row + i]));
  return gradient;
}

}  // namespace

ExposureRows exposure_rows(const Scene& scene, const std::vector<int>& frames,
                           const TrainOptions& options) {
  ExposureRows rows;
  check(options.exposure != ExposureGains::kAuto, "exposure_rows: auto is not resolved");
  if (options.exposure == ExposureGains::kNone) return rows;
  if (scene.had_alpha && scene.background != std::array<uint8_t, 3>{0, 0, 0})
    throw InputError(
        fmt::format("{}: frames with alpha were put on {}, which has no exposure; pass "
                    "--background black or --exposure none",
                    scene.path, options.background));
  std::map<std::string, int32_t> known;
  for (const int f : frames) {
    const Frame& frame = scene.frames[size_t(f)];
    const std::string& name =
        options.exposure == ExposureGains::kFrame ? frame.name : frame.camera_name;
    const auto [row, is_new] = known.emplace(name, int32_t(rows.names.size()));
    if (is_new) rows.names.push_back(name);
    rows.of_frame.push_back(row->second);
  }
  if (rows.names.size() > 1) return rows;
  throw InputError(fmt::format(
      "{}: all {} training frames are of one {}, '{}', whose gain would be 1; pass --exposure {}",
      scene.path, frames.size(), options.exposure == ExposureGains::kFrame ? "frame" : "camera",
      rows.names.front(), frames.size() > 1 ? "frame" : "none"));
}

std::vector<ColourMap<double>> colour_maps_of(const LearntRows& state) {
  std::vector<ColourMap<double>> maps;
  if (state.width() == 3)
    for (const Vec3<double>& gain : gains_of(state)) maps.push_back(colour_gain(gain));
  else
    for (int64_t r = 0; r < state.rows(); ++r)
      maps.push_back(affine_map(state.value.data() + kAffineWidth * r));
  return maps;
}

void step_exposure(const std::vector<int32_t>& rows, const std::vector<ColourMap<double>>& d_maps,
                   double rate, LearntRows& state) {
  check(rows.size() == d_maps.size(), "exposure: one gradient a view");
  const int width = state.width();
  const bool affine = width == kAffineWidth;
  std::map<int32_t, ColourMap<double>> by_row;  // so that views of one camera step together
  for (size_t b = 0; b < rows.size(); ++b)
    by_row.emplace(rows[b], ColourMap<double>{Mat3<double>(0), Vec3<double>(0)}).first->second +=
        d_maps[b];
  const std::vector<Vec3<double>> gains = affine ? std::vector<Vec3<double>>() : gains_of(state);
  const double share = double(by_row.size()) / double(state.rows());
  for (const auto& [row, d_map] : by_row) {
    const AdamScalars<float> adam =
        adam_scalars<float>(affine ? kAffineRate * rate : rate, ++state.steps[row]);
    const std::vector<double> gradient = row_gradient(state, row, gains, d_map, share);
    for (int k = 0; k < width; ++k) {
      const int64_t i = width * int64_t(row) + k;
      adam_step(adam, float(gradient[size_t(k)]), state.value[i], state.moment1[i],
                state.moment2[i]);
    }
  }
  affine ? fix_affine_gauge(state) : fix_gain_gauge(state);
}

nlohmann::json exposure_json(const ExposureRows& rows, const LearntRows& state,
                             const TrainOptions& options) {
  const bool affine = options.exposure == ExposureGains::kAffine;
  nlohmann::json by_name = nlohmann::json::object();
  const std::vector<ColourMap<double>> maps = colour_maps_of(state);
  for (size_t r = 0; r < rows.names.size(); ++r) {
    const Mat3<double>& a = maps[r].matrix;
    const Vec3<double>& o = maps[r].offset;
    if (affine)
      by_name[rows.names[r]] = {
          {"matrix",
           {{a[0][0], a[1][0], a[2][0]}, {a[0][1], a[1][1], a[2][1]}, {a[0][2], a[1][2], a[2][2]}}},
          {"offset", {o[0], o[1], o[2]}}};
    else
      by_name[rows.names[r]] = {a[0][0], a[1][1], a[2][2]};
  }
  return {{"by", name_of(options.exposure)}, {affine ? "maps" : "gains", by_name}};
}

LearntRows exposure_of_json(const nlohmann::json& json, const ExposureRows& rows,
                            const TrainOptions& options, const std::string& where) {
  const bool affine = options.exposure == ExposureGains::kAffine;
  const int width = exposure_width(options.exposure);
  LearntRows state;
  state.reset(int64_t(rows.names.size()), width);
  try {
    const nlohmann::json& by_name = json.at(affine ? "maps" : "gains");
    for (size_t r = 0; r < rows.names.size(); ++r) {
      const nlohmann::json& stated = by_name.at(rows.names[r]);
      float* const row = state.value.data() + size_t(width) * r;
      for (int i = 0; affine && i < 9; ++i)
        row[i] = stated.at("matrix").at(size_t(i % 3)).at(size_t(i / 3)).get<float>() -
                 (i % 4 == 0 ? 1.0F : 0.0F);
      for (int c = 0; c < 3; ++c) {
        if (affine)
          row[9 + c] = stated.at("offset").at(size_t(c)).get<float>();
        else
          row[c] = std::log(stated.at(size_t(c)).get<float>());
      }
    }
  } catch (const nlohmann::json::exception&) {
    throw InputError(fmt::format("{}: has not the colours of all {} {}s of this training", where,
                                 rows.names.size(), name_of(options.exposure)));
  }
  return state;
}

}  // namespace tessera
