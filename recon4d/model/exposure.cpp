// What: rows of gains, their gauge and their steps.
// Not: when they step, nor how large the steps are (trainer.cpp, schedule.cpp).
#include "recon4d/model/exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/math/adam.h"

namespace tessera {
namespace {

constexpr double kGrid = 262144;  // steps of a gain in 1
constexpr float kMostStops = 3;   // |log2 gain|: gains and their ratio to the mean fit a float

/// Mean gain of a channel before the gauge is fixed.
double mean_gain(const ExposureState& state, int channel) {
  double sum = 0;
  for (int64_t r = 0; r < state.rows(); ++r)
    sum += std::exp(double(state.log_gain[3 * r + channel]));
  return sum / double(state.rows());
}

void fix_gauge(ExposureState& state) {
  const float most = kMostStops * std::log(2.0f);
  for (int c = 0; c < 3; ++c) {
    const double shift = std::log(mean_gain(state, c));
    for (int64_t r = 0; r < state.rows(); ++r) {
      float& log_gain = state.log_gain[3 * r + c];
      log_gain = std::clamp(float(double(log_gain) - shift), -most, most);
    }
  }
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
        options.exposure == ExposureGains::kCamera ? frame.camera_name : frame.name;
    const auto [row, is_new] = known.emplace(name, int32_t(rows.names.size()));
    if (is_new) rows.names.push_back(name);
    rows.of_frame.push_back(row->second);
  }
  if (rows.names.size() > 1) return rows;
  throw InputError(fmt::format(
      "{}: all {} training frames are of one {}, '{}', whose gain would be 1; pass --exposure {}",
      scene.path, frames.size(), name_of(options.exposure), rows.names.front(),
      frames.size() > 1 ? "frame" : "none"));
}

void ExposureState::reset(int64_t rows) {
  for (Buffer<float>* values : {&log_gain, &moment1, &moment2}) {
    values->resize(3 * rows);
    std::fill(values->begin(), values->end(), 0.0f);
  }
  steps.resize(rows);
  std::fill(steps.begin(), steps.end(), 0);
}

ExposureState ExposureState::clone() const {
  ExposureState copy;
  copy.log_gain.copy_from(log_gain);
  copy.moment1.copy_from(moment1);
  copy.moment2.copy_from(moment2);
  copy.steps.copy_from(steps);
  return copy;
}

std::vector<Vec3<double>> gains_of(const ExposureState& state) {
  const int64_t rows = state.rows();
  std::vector<Vec3<double>> gains(static_cast<size_t>(rows));
  for (int c = 0; c < 3 && rows > 0; ++c) {
    const double mean = mean_gain(state, c);
    int64_t missing = rows * int64_t(kGrid);
    for (int64_t r = 0; r < rows; ++r) {
      const double gain = std::exp(double(state.log_gain[3 * r + c])) / mean;
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

void step_exposure(const std::vector<int32_t>& rows, const std::vector<Vec3<double>>& d_gain,
                   double rate, ExposureState& state) {
  check(rows.size() == d_gain.size(), "exposure: one gradient a view");
  const std::vector<Vec3<double>> gains = gains_of(state);
  std::map<int32_t, Vec3<double>> d_log_gain;  // by row, so that views of one camera step together
  for (size_t b = 0; b < rows.size(); ++b)
    d_log_gain.emplace(rows[b], Vec3<double>(0)).first->second +=
        gains[size_t(rows[b])] * d_gain[b];
  for (const auto& [row, gradient] : d_log_gain) {
    const AdamScalars<float> adam = adam_scalars<float>(rate, ++state.steps[row]);
    for (int c = 0; c < 3; ++c) {
      const int64_t i = 3 * int64_t(row) + c;
      adam_step(adam, float(gradient[c]), state.log_gain[i], state.moment1[i], state.moment2[i]);
    }
  }
  fix_gauge(state);
}

nlohmann::json exposure_json(const ExposureRows& rows, const ExposureState& state,
                             const TrainOptions& options) {
  nlohmann::json gains = nlohmann::json::object();
  const std::vector<Vec3<double>> values = gains_of(state);
  for (size_t r = 0; r < rows.names.size(); ++r)
    gains[rows.names[r]] = {values[r][0], values[r][1], values[r][2]};
  return {{"by", name_of(options.exposure)}, {"gains", gains}};
}

}  // namespace tessera
