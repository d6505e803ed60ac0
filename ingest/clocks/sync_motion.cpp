// Clock offsets from moving features: coarse offsets of pairs of posed cameras, then fine ones,
// then all clocks at once.
#include "ingest/clocks/clock_sync.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "ingest/clocks/motion_matches.h"
#include "ingest/clocks/offset_solver.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

/// All pairs of a small rig; of a large one each camera's nearest, and what connects them all.
/// Clips without a pose are in none: views differ, and motion as a whole agrees by chance.
Pairs pairs_to_compare(const std::vector<RigClip>& clips) {
  constexpr size_t kSmallRig = 8, kNearest = 4;
  std::vector<int> posed;
  for (size_t i = 0; i < clips.size(); ++i)
    if (clips[i].camera) posed.push_back(int(i));
  const size_t n = posed.size();
  const auto distance = [&](size_t a, size_t b) {
    const Camera &x = clips[size_t(posed[a])].camera->camera,
                 &y = clips[size_t(posed[b])].camera->camera;
    const glm::dmat3 turn = y.cam_from_world * glm::transpose(x.cam_from_world);
    return glm::length(x.position() - y.position()) * (2 - turn[2][2]);  // and looks elsewhere
  };
  std::vector<std::vector<bool>> chosen(n, std::vector<bool>(n, n <= kSmallRig));
  for (size_t a = 0; a < n; ++a) {
    std::vector<size_t> others;
    for (size_t b = 0; b < n; ++b)
      if (b != a) others.push_back(b);
    std::sort(others.begin(), others.end(),
              [&](size_t x, size_t y) { return distance(a, x) < distance(a, y); });
    for (size_t k = 0; k < std::min(kNearest, others.size()); ++k) chosen[a][others[k]] = true;
  }
  std::vector<bool> reached(n, false);  // Prim's spanning tree
  if (n > 0) reached[0] = true;
  for (size_t step = 1; step < n; ++step) {
    double least = std::numeric_limits<double>::infinity();
    size_t from = 0, to = 0;
    for (size_t a = 0; a < n; ++a)
      for (size_t b = 0; b < n; ++b)
        if (reached[a] && !reached[b] && distance(a, b) < least) {
          least = distance(a, b);
          from = a;
          to = b;
        }
    reached[to] = true;
    chosen[from][to] = true;
  }
  Pairs pairs;
  for (size_t a = 0; a < n; ++a)
    for (size_t b = a + 1; b < n; ++b)
      if (chosen[a][b] || chosen[b][a]) pairs.emplace_back(posed[a], posed[b]);
  return pairs;
}

/// Measures each pair, side by side; pairs without an answer are left out.
template <class Measure>
std::vector<PairOffset> measure(const Pairs& pairs, const Measure& measure_pair) {
  std::vector<std::optional<PairOffset>> found(pairs.size());
  parallel_for(int64_t(pairs.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      found[size_t(i)] = measure_pair(pairs[size_t(i)].first, pairs[size_t(i)].second);
      if (found[size_t(i)]) {
        found[size_t(i)]->a = pairs[size_t(i)].first;
        found[size_t(i)]->b = pairs[size_t(i)].second;
      }
    }
  });
  std::vector<PairOffset> all;
  for (const auto& pair : found)
    if (pair) all.push_back(*pair);
  return all;
}

std::vector<double> offsets_of(const std::vector<SolvedOffset>& solved) {
  std::vector<double> offsets;
  for (const SolvedOffset& s : solved) offsets.push_back(s.offset);
  return offsets;
}

/// The stretch of the rig's time, `length` seconds, in which most moves.
double busiest_begin(const std::vector<MotionEnergy>& energies, const std::vector<double>& offsets,
                     double length) {
  std::vector<std::pair<double, double>> moves;  // timestep, share of its clip's motion
  for (size_t clip = 0; clip < energies.size(); ++clip) {
    double total = 1e-9;
    std::vector<double> sums;
    for (const cv::Mat& cells : energies[clip].cells) {
      sums.push_back(cv::sum(cells)[0]);
      total += sums.back();
    }
    for (size_t i = 0; i < sums.size(); ++i)
      moves.emplace_back(energies[clip].seconds[i] + offsets[clip], sums[i] / total);
  }
  std::sort(moves.begin(), moves.end());
  double inside = 0, most = -1, begin = moves.empty() ? 0 : moves.front().first;
  for (size_t first = 0, last = 0; last < moves.size(); ++last) {
    inside += moves[last].second;
    while (moves[last].first - moves[first].first > length) inside -= moves[first++].second;
    if (inside > most) {
      most = inside;
      begin = moves[first].first;
    }
  }
  return begin;
}

class MotionSync {
 public:
  MotionSync(const std::vector<RigClip>& clips, const IngestProgress& progress)
      : clips_(clips), progress_(progress), pairs_(pairs_to_compare(clips)) {
    constexpr size_t kBytes = size_t(512) << 20;  // of images, for all clips
    for (const RigClip& clip : clips) {
      frame_seconds_ = std::max(frame_seconds_, step_of(clip));
      images_.emplace_back(clip, kBytes / clips.size());
    }
  }

  ClipClocks run() {
    energies_.resize(clips_.size());
    for_posed("motion", [&](size_t i) { energies_[i] = motion_energy(images_[i]); });
    const auto coarse = measure(pairs_, [&](int a, int b) {
      return coarse_offset(energies_[size_t(a)], energies_[size_t(b)], *clips_[size_t(a)].camera,
                           *clips_[size_t(b)].camera);
    });
    const std::vector<double> none(clips_.size());
    const std::vector<double> start = offsets_of(solve_offsets(int(clips_.size()), coarse));
    Fine fine = measure_fine(start, compared(start));
    const bool moved = std::any_of(start.begin(), start.end(), [&](double offset) {
      return std::abs(offset) > frame_seconds_;
    });
    if (moved) {  // a mistaken coarse offset must not win over clocks that agree
      Fine unmoved = measure_fine(none, compared(none));
      if (unmoved.support >= fine.support) fine = std::move(unmoved);
    }
    if (!all_determined(fine.pairs)) {
      // what was compared may lie where a clock that drifts is seconds off; videos begin together
      Fine first = measure_fine(none, {{first_timestep(), first_timestep() + compared_seconds()}});
      fine.pairs.insert(fine.pairs.end(), first.pairs.begin(), first.pairs.end());
      fine.rates.insert(fine.rates.end(), first.rates.begin(), first.rates.end());
    }
    refuse_drift(solve_offsets(int(clips_.size()), fine.rates));
    return clocks_from(joined(coarse, fine.pairs));
  }

 private:
  struct Fine {
    std::vector<PairOffset> pairs, rates;
    size_t support = 0;
  };

  static double step_of(const RigClip& clip) { return clip.timeline.frame_seconds; }

  /// Calls `work` for each clip with a pose, as many at once as there are threads; progress comes
  /// from this one.
  template <class Work>
  void for_posed(const char* what, const Work& work) const {
    const auto threads = size_t(thread_count());
    for (size_t first = 0; first < clips_.size(); first += threads) {
      if (progress_) progress_(what, int64_t(first), int64_t(clips_.size()));
      const size_t count = std::min(threads, clips_.size() - first);
      parallel_for(int64_t(count), 1, [&](int64_t begin, int64_t end) {
        const SerialSection serial;
        for (int64_t i = begin; i < end; ++i)
          if (clips_[first + size_t(i)].camera) work(first + size_t(i));
      });
    }
  }

  double compared_seconds() const {
    constexpr double kFrames = 72;  // three seconds: hundreds of matches a pair
    return kFrames * frame_seconds_;
  }

  /// The latest beginning of a clip.
  double first_timestep() const {
    double first = -std::numeric_limits<double>::infinity();
    for (const MotionEnergy& energy : energies_)
      if (!energy.seconds.empty()) first = std::max(first, energy.seconds.front());
    return std::isfinite(first) ? first : 0;
  }

  bool all_determined(const std::vector<PairOffset>& pairs) const {
    const std::vector<SolvedOffset> solved = solve_offsets(int(clips_.size()), pairs);
    for (size_t i = 0; i < solved.size(); ++i)
      if (clips_[i].camera && !solved[i].determined) return false;
    return true;
  }

  /// Of the busiest stretch of the rig's time, as far as all clips show it, a few frames here and
  /// there: of one texture, neighbouring frames say nearly the same. All of it where it is short.
  std::vector<Stretch> compared(const std::vector<double>& start) const {
    constexpr int kGroups = 8, kFrames = 3;  // a clock that is a frame off meets two of three
    const double length = kFrames * frame_seconds_;
    const double begin = busiest_begin(energies_, start, compared_seconds());
    const Stretch all{begin, begin + compared_seconds()};
    Stretch shown = all;
    for (size_t i = 0; i < clips_.size(); ++i) {
      if (energies_[i].seconds.empty()) continue;
      shown.begin = std::max(shown.begin, energies_[i].seconds.front() + start[i]);
      shown.end = std::min(shown.end, energies_[i].seconds.back() + start[i]);
    }
    const double room = shown.end - shown.begin - length;
    if (room < (kGroups - 1) * length) return {all};
    std::vector<Stretch> groups;
    for (int k = 0; k < kGroups; ++k) {
      const double first = shown.begin + k * room / (kGroups - 1);
      groups.push_back({first, first + length - 0.5 * frame_seconds_});
    }
    return groups;
  }

  /// `stretches`: of the rig's time by the offsets `start`.
  Fine measure_fine(const std::vector<double>& start, const std::vector<Stretch>& stretches) {
    std::vector<std::vector<FrameTriple>> frames(clips_.size());
    for_posed("moving features", [&](size_t i) {
      std::vector<Stretch> of_clip = stretches;
      for (Stretch& stretch : of_clip) {
        stretch.begin -= start[i];
        stretch.end -= start[i];
      }
      frames[i] = frames_in(images_[i], of_clip);
    });
    std::vector<PosedFeatures> features(clips_.size());
    std::vector<std::pair<size_t, size_t>> all;  // clip, frame
    for (size_t i = 0; i < clips_.size(); ++i) {
      if (!clips_[i].camera) continue;
      features[i].camera =
          clips_[i].camera->camera.resized(energies_[i].width, energies_[i].height);
      features[i].frame_seconds = step_of(clips_[i]);
      features[i].frames.resize(frames[i].size());
      for (size_t k = 0; k < frames[i].size(); ++k) all.emplace_back(i, k);
    }
    parallel_for(int64_t(all.size()), 1, [&](int64_t first, int64_t last) {
      for (int64_t n = first; n < last; ++n) {
        const auto [i, k] = all[size_t(n)];
        features[i].frames[k] = straightened(moving_features(frames[i][k]), *clips_[i].camera,
                                             energies_[i].width, energies_[i].height);
      }
    });
    std::vector<PairShift> shifts(clips_.size() * clips_.size());
    Fine fine;
    fine.pairs = measure(pairs_, [&](int a, int b) -> std::optional<PairOffset> {
      const size_t i = size_t(a), j = size_t(b);
      const auto found = fine_offset(features[i], features[j], start[j] - start[i]);
      if (!found || found->sigma > 0.5 * frame_seconds_) return std::nullopt;
      shifts[i * clips_.size() + j] = *found;
      return PairOffset{a, b, found->shift, found->sigma};
    });
    for (const PairOffset& pair : fine.pairs) {
      const PairShift& shift = shifts[size_t(pair.a) * clips_.size() + size_t(pair.b)];
      fine.support += shift.support;
      if (std::isfinite(shift.rate_sigma))
        fine.rates.push_back({pair.a, pair.b, shift.rate, shift.rate_sigma});
    }
    return fine;
  }

  /// Fine pairs, and coarse ones of clips that these leave open.
  std::vector<SolvedOffset> joined(const std::vector<PairOffset>& coarse,
                                   std::vector<PairOffset> pairs) const {
    const int count = int(clips_.size());
    const std::vector<SolvedOffset> solved = solve_offsets(count, pairs);
    for (const PairOffset& pair : coarse)
      if (!solved[size_t(pair.a)].determined || !solved[size_t(pair.b)].determined)
        pairs.push_back(pair);
    return solve_offsets(count, pairs);
  }

  /// A constant offset would be wrong everywhere but in the middle of what was compared. Errors:
  /// InputError naming the camera whose clock runs least like the others'.
  void refuse_drift(const std::vector<SolvedOffset>& rates) const {
    constexpr double kLeastRate = 0.02;  // half of it is what real rigs give by chance
    size_t worst = 0;
    for (size_t i = 0; i < rates.size(); ++i)
      if (std::abs(rates[i].offset) > std::abs(rates[worst].offset)) worst = i;
    const double rate = rates[worst].offset, sigma = rates[worst].sigma;
    if (std::abs(rate) <= std::max(kLeastRate, 5 * sigma)) return;
    throw InputError(fmt::format(
        "{}: its clock drifts: while the others' run 1 s, its own runs {:.3f} s (± {:.3f}; frames "
        "lost and times rewritten?); restore its times, by `ffmpeg -itsscale {:.3f} -i {} -c copy "
        "…` where the drift is even, leave it out with --cameras, or pass --sync none to take the "
        "times as they are",
        clips_[worst].name, 1 - rate, sigma, 1 / (1 - rate),
        clips_[worst].video.filename().string()));
  }

  ClipClocks clocks_from(const std::vector<SolvedOffset>& solved) const {
    ClipClocks result;
    std::vector<double> steps;
    for (const RigClip& clip : clips_) steps.push_back(step_of(clip));
    const std::vector<double> limits = offset_limits(solved, steps);
    std::vector<std::string> unknown, left;  // left: as measured, but not certain to be there
    double farthest = 0;
    for (size_t i = 0; i < solved.size(); ++i) {
      const SolvedOffset& s = solved[i];
      const std::string& name = clips_[i].name;
      if (!s.determined) {
        result.clocks.push_back({0, 0, 0.5 * length_of(clips_[i]), "none"});
        unknown.push_back(name + (clips_[i].camera ? "" : " (no pose)"));
        continue;
      }
      const bool told = std::abs(s.offset) > limits[i], vague = s.sigma > 0.25 * steps[i];
      result.clocks.push_back({told ? s.offset : 0, s.offset, s.sigma, "motion"});
      if (told) farthest = std::max(farthest, std::abs(s.offset));
      if (told && vague)
        result.warnings.push_back(fmt::format(
            "{}: its clock's offset from motion, {:+.3f} s, is only known to {:.3f} s; state it "
            "with --offsets FILE if you know better",
            name, s.offset, s.sigma));
      else if (!told && (vague || std::abs(s.offset) > std::max(2 * s.sigma, 0.1 * steps[i])))
        left.push_back(fmt::format("{} {:+.4f} ± {:.4f} s", name, s.offset, s.sigma));
    }
    say_unknown(unknown, farthest, result);
    if (!left.empty())
      result.notes.push_back(fmt::format(
          "clocks: what motion says of {} is within its errors; they are left as they are",
          listed_names(left)));
    return result;
  }

  static double length_of(const RigClip& clip) {
    const std::vector<int64_t>& ticks = clip.timeline.ticks;
    return ticks.empty() ? 0 : clip.timeline.time_base.at(ticks.back() - ticks.front());
  }

  /// A clock that nothing speaks against is no reason to act. `farthest`: the largest offset of the
  /// others.
  void say_unknown(const std::vector<std::string>& unknown, double farthest,
                   ClipClocks& result) const {
    if (unknown.empty()) return;
    if (farthest > 0)
      result.warnings.push_back(fmt::format(
          "clocks: the images of {} do not tell how their clocks run, and others' are off by up to "
          "{:.3f} s; state them with --offsets FILE",
          listed_names(unknown), farthest));
    else
      result.notes.push_back(fmt::format(
          "clocks: the images of {} do not tell how their clocks run; they are taken as they are",
          listed_names(unknown)));
  }

  const std::vector<RigClip>& clips_;
  const IngestProgress& progress_;
  const Pairs pairs_;
  double frame_seconds_ = 0;  // of the slowest clip
  std::vector<GreyClip> images_;
  std::vector<MotionEnergy> energies_;
};

}  // namespace

ClipClocks synchronise_by_motion(const std::vector<RigClip>& clips,
                                 const IngestProgress& progress) {
  return MotionSync(clips, progress).run();
}

}  // namespace tessera
