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
  rows.offsets = options.clocks == Clocks::kLearn;
  rows.readouts = options.learn_readouts;
  if (!rows.offsets && !rows.readouts) return rows;
  std::map<std::string, int32_t> row_of;  // rows are in the order of names
  for (const int f : frames) row_of[scene.frames[size_t(f)].camera_name] = 0;
  for (auto& [name, row] : row_of) {
    row = int32_t(rows.names.size());
    rows.names.push_back(name);
  }
  rows.frame = frame_step(scene, frames);
  if (rows.offsets && (rows.names.size() < 2 || rows.frame == 0))
    throw InputError(fmt::format(
        "{}: --clocks learn compares the clocks of cameras that film together, and here {}; pass "
        "--clocks fixed",
        scene.path, rows.frame == 0 ? "none has two timesteps" : "there is one camera"));
  if (rows.frame == 0)
    throw InputError(fmt::format(
        "{}: --learn-readouts learns from what moves, and no camera has two timesteps; leave it "
        "out",
        scene.path));
  for (const int f : frames) rows.of_frame.push_back(row_of[scene.frames[size_t(f)].camera_name]);
  return rows;
}

void step_clocks(const std::vector<int32_t>& rows, const std::vector<CameraClock>& gradients,
                 const ClockRows& learnt, double rate, LearntRows& state) {
  check(rows.size() == gradients.size(), "clocks: one gradient a view");
  std::map<int32_t, CameraClock> by_row;  // so that views of one camera step together
  for (size_t b = 0; b < rows.size(); ++b) {
    by_row[rows[b]].offset += gradients[b].offset * learnt.frame;
    by_row[rows[b]].readout += gradients[b].readout * learnt.frame;
  }
  for (const auto& [row, gradient] : by_row) {
    const AdamScalars<float> adam = adam_scalars<float>(rate, ++state.steps[row]);
    const auto step = [&](int64_t i, double by) {
      adam_step(adam, float(by), state.value[i], state.moment1[i], state.moment2[i]);
    };
    if (learnt.offsets) step(kClockWidth * row, gradient.offset);
    if (learnt.readouts) step(kClockWidth * row + 1, gradient.readout);
  }
  for (float& value : state.value) value = std::clamp(value, float(-kMostClock), float(kMostClock));
  double mean = 0;
  for (int64_t r = 0; r < state.rows(); ++r)
    mean += double(state.value[kClockWidth * r]) / double(state.rows());
  for (int64_t r = 0; r < state.rows(); ++r) {
    float& offset = state.value[kClockWidth * r];
    offset = float(double(offset) - mean);
  }
}

std::vector<CameraClock> clocks_of(const LearntRows& state, double frame) {
  std::vector<CameraClock> clocks;
  for (int64_t i = 0; i < state.value.size(); i += kClockWidth)
    clocks.push_back({double(state.value[i]) * frame, double(state.value[i + 1]) * frame});
  return clocks;
}

View at_clock(View view, const CameraClock& clock) {
  view.time += clock.offset;
  view.camera.readout += clock.readout;
  return view;
}

nlohmann::json clocks_json(const ClockRows& rows, const LearntRows& state, double duration) {
  nlohmann::json result{{"clocks", nullptr}, {"readouts", nullptr}};
  const std::vector<CameraClock> clocks = clocks_of(state, rows.frame);
  for (size_t r = 0; r < clocks.size(); ++r) {
    if (rows.offsets) result["clocks"][rows.names[r]] = clocks[r].offset * duration;
    if (rows.readouts) result["readouts"][rows.names[r]] = clocks[r].readout * duration;
  }
  return result;
}

}  // namespace tessera
