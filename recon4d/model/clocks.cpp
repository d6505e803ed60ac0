// One row a camera, in frames, so that rates do not depend on the length of a clip.
#include "recon4d/model/clocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/base/median.h"
#include "kernels/math/adam.h"

namespace tessera {

double frame_step(const Scene& scene, const std::vector<int>& frames) {
  std::map<std::string, std::vector<double>> times;
  for (const int f : frames)
    times[scene.frames[size_t(f)].camera_name].push_back(scene.frames[size_t(f)].time);
  std::vector<double> steps;
  for (auto& [camera, of_camera] : times) {
    std::sort(of_camera.begin(), of_camera.end());
    for (size_t i = 1; i < of_camera.size(); ++i)
      if (of_camera[i] > of_camera[i - 1]) steps.push_back(of_camera[i] - of_camera[i - 1]);
  }
  return steps.empty() ? 0 : median(std::move(steps));
}

ClockRows clock_rows(const Scene& scene, const std::vector<int>& frames,
                     const TrainOptions& options) {
  ClockRows rows;
  check(options.clocks != Clocks::kAuto, "clock_rows: auto is not resolved");
  if (options.clocks == Clocks::kFixed) return rows;
  std::map<std::string, int32_t> row_of;  // rows are in the order of names
  for (const int f : frames) row_of[scene.frames[size_t(f)].camera_name] = 0;
  for (auto& [name, row] : row_of) {
    row = int32_t(rows.names.size());
    rows.names.push_back(name);
  }
  rows.frame = frame_step(scene, frames);
  if (rows.names.size() < 2 || rows.frame == 0)
    throw InputError(fmt::format(
        "{}: --clocks learn compares the clocks of cameras that film together, and here {}; pass "
        "--clocks fixed",
        scene.path, rows.frame == 0 ? "none has two timesteps" : "there is one camera"));
  for (const int f : frames) rows.of_frame.push_back(row_of[scene.frames[size_t(f)].camera_name]);
  return rows;
}

void step_clocks(const std::vector<int32_t>& rows, const std::vector<double>& d_times, double frame,
                 double rate, LearntRows& state) {
  check(rows.size() == d_times.size(), "clocks: one gradient a view");
  std::map<int32_t, double> by_row;  // so that views of one camera step together
  for (size_t b = 0; b < rows.size(); ++b) by_row[rows[b]] += d_times[b] * frame;
  for (const auto& [row, gradient] : by_row)
    adam_step(adam_scalars<float>(rate, ++state.steps[row]), float(gradient), state.value[row],
              state.moment1[row], state.moment2[row]);
  double mean = 0;
  for (float& value : state.value) {
    value = std::clamp(value, float(-kMostClock), float(kMostClock));
    mean += double(value) / double(state.rows());
  }
  for (float& value : state.value) value = float(double(value) - mean);
}

std::vector<double> clock_offsets_of(const LearntRows& state, double frame) {
  std::vector<double> offsets;
  for (const float value : state.value) offsets.push_back(double(value) * frame);
  return offsets;
}

nlohmann::json clocks_json(const ClockRows& rows, const LearntRows& state, double duration) {
  nlohmann::json by_name;
  const std::vector<double> offsets = clock_offsets_of(state, rows.frame);
  for (size_t r = 0; r < offsets.size(); ++r) by_name[rows.names[r]] = offsets[r] * duration;
  return by_name;
}

}  // namespace tessera
