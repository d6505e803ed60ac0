// Whitened cross-correlation of all pairs of sounds, and the clocks that fit the peaks best. A
// drift of the clocks within a clip is not modelled. Source: GCC-PHAT (Knapp, Carter 1976).
#include "ingest/clocks/sync_audio.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "ingest/clocks/offset_solver.h"

namespace tessera {
namespace {

constexpr int kRate = 8000;          // samples a second: 0.004 of a frame at 30 frames a second
constexpr double kSeconds = 60;      // of each clip
constexpr double kConfident = 1.5;   // peak to second peak
constexpr double kSoundPath = 5e-3;  // seconds: 1.7 m of difference between the ways of a sound

/// Of the sound, faded in and out: whitening would turn its cut ends into a peak.
cv::Mat spectrum_of(const Sound& sound, int size) {
  constexpr double kFade = 0.1;  // seconds
  cv::Mat samples(1, size, CV_32F, cv::Scalar(0)), spectrum;
  const int count = int(sound.samples.size());
  const double mean =
      cv::mean(cv::Mat(1, count, CV_32F, const_cast<float*>(sound.samples.data())))[0];
  for (int i = 0; i < count; ++i) {
    const double from_end = std::min(i + 0.5, count - i - 0.5) / (kFade * sound.rate);
    const double fade = 0.5 - 0.5 * std::cos(CV_PI * std::min(1.0, from_end));
    samples.at<float>(0, i) = float(fade * (sound.samples[size_t(i)] - mean));
  }
  cv::dft(samples, spectrum, cv::DFT_COMPLEX_OUTPUT);
  return spectrum;
}

/// Correlation at all shifts of a against b; negative shifts at the end. Empty where too little of
/// the band is heard: a hum fits at each of its periods.
cv::Mat whitened_correlation(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kFloor = 0.1;  // of the mean: noise of silent frequencies is not amplified
  constexpr double kBand = 0.05;  // share of the band that is heard
  cv::Mat product, correlation;
  cv::mulSpectrums(a, b, product, 0, true);
  double sum = 0, heard = 0;
  for (int i = 0; i < product.cols; ++i) {
    const cv::Vec2f& z = product.at<cv::Vec2f>(0, i);
    sum += std::hypot(z[0], z[1]);
  }
  const double floor = std::max(1e-30, kFloor * sum / product.cols);
  for (int i = 0; i < product.cols; ++i) {
    cv::Vec2f& z = product.at<cv::Vec2f>(0, i);
    const double strength = std::hypot(double(z[0]), double(z[1]));
    z *= float(1 / (strength + floor));
    heard += strength / (strength + floor);
  }
  if (heard < kBand * product.cols) return {};
  cv::dft(product, correlation, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT);
  return correlation;
}

SoundDelay clear_delay(const cv::Mat& correlation, int rate) {
  if (correlation.empty()) return {};
  const int size = correlation.cols, beside = rate / 100;
  const float* values = correlation.ptr<float>();
  const int best = int(std::max_element(values, values + size) - values);
  double second = 1e-30;
  for (int i = 0; i < size; ++i) {
    const int apart = std::abs(i - best);
    if (std::min(apart, size - apart) > beside) second = std::max(second, double(values[i]));
  }
  const double before = values[(best + size - 1) % size], now = values[best],
               after = values[(best + 1) % size], bend = before - 2 * now + after;
  const double peak = best + (bend < 0 ? 0.5 * (before - after) / bend : 0);
  return {(peak > size / 2 ? peak - size : peak) / rate, now / second};
}

std::string name_of_open_clip(const std::vector<RigClip>& clips,
                              const std::vector<SolvedOffset>& solved) {
  for (size_t i = 0; i < solved.size(); ++i)
    if (!solved[i].determined) return clips[i].name;
  return "";
}

}  // namespace

std::vector<SoundDelay> sound_delays(const std::vector<Sound>& sounds) {
  size_t longest = 1;
  for (const Sound& sound : sounds) longest = std::max(longest, sound.samples.size());
  const int size = cv::getOptimalDFTSize(int(2 * longest));
  std::vector<cv::Mat> spectra;
  for (const Sound& sound : sounds) spectra.push_back(spectrum_of(sound, size));
  std::vector<SoundDelay> delays;
  for (size_t a = 0; a < sounds.size(); ++a)
    for (size_t b = a + 1; b < sounds.size(); ++b) {
      SoundDelay delay = clear_delay(whitened_correlation(spectra[a], spectra[b]), sounds[a].rate);
      delay.seconds += sounds[a].begin - sounds[b].begin;
      delays.push_back(delay);
    }
  return delays;
}

std::optional<std::vector<ClipClock>> synchronise_by_audio(const std::vector<RigClip>& clips,
                                                           const IngestProgress& progress,
                                                           std::string& reason) {
  std::vector<Sound> sounds;
  for (size_t i = 0; i < clips.size(); ++i) {
    if (progress) progress("sound", int64_t(i), int64_t(clips.size()));
    auto sound =
        clips[i].timeline.has_audio ? read_clip_sound(clips[i], kRate, kSeconds) : std::nullopt;
    if (!sound) {
      reason = fmt::format("{}: has no sound that can be decoded", clips[i].name);
      return std::nullopt;
    }
    sounds.push_back(std::move(*sound));
  }
  const std::vector<SoundDelay> delays = sound_delays(sounds);
  std::vector<PairOffset> pairs;
  size_t next = 0;
  for (int a = 0; a < int(clips.size()); ++a)
    for (int b = a + 1; b < int(clips.size()); ++b, ++next)
      if (delays[next].confidence >= kConfident)
        pairs.push_back({a, b, delays[next].seconds, kSoundPath});
  const auto solved = solve_offsets(int(clips.size()), pairs);
  const std::string open = name_of_open_clip(clips, solved);
  if (!open.empty()) {
    reason = fmt::format("{}: its sound does not match the others' clearly", open);
    return std::nullopt;
  }
  std::vector<ClipClock> clocks;
  for (const SolvedOffset& s : solved) {
    // an offset within its error is not applied, because it would add timesteps to the scene
    const double error = std::max(s.sigma, kSoundPath);
    clocks.push_back({std::abs(s.offset) > error ? s.offset : 0, s.offset, error, "audio"});
  }
  return clocks;
}

}  // namespace tessera
