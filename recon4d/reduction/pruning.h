// The order of pruning: the squared error that the removal of each Gaussian adds, per byte that it
// frees; the curve of size and error that follows; and the knee of that curve. Source:
// docs/explanation/size.md.
#pragma once
#include <vector>

#include "recon4d/model/train_state.h"
#include "recon4d/reduction/contributions.h"

namespace tessera {

/// What a Gaussian takes of the shipped file, bytes. Measured on files of trained scenes
/// (docs/explanation/size.md); only ratios matter to what is decided.
struct ByteRates {
  double still = 12.5;  // mean, scales, rotation, opacity, first colour
  double time = 7.5;    // mean timestep, life, velocity
  double band = 0.55;   // of each further SH scalar

  double bytes_of(bool dynamic, int sh_degree) const;
};

/// A Gaussian that could go.
struct Removal {
  int set = 0;  // 0: static, 1: dynamic
  int64_t element = 0;
  /// SetContributions::removal_cost: by the second order alone, as the first is that of a gradient,
  /// which training drives to 0, and of what others take over.
  double error = 0;
  double bytes = 0;  // that it frees
  /// False where the pass has drawn a part of the frames and it was in none of them: nothing is
  /// known of it.
  bool seen = true;

  double error_per_byte() const { return error / bytes; }
};

/// All Gaussians of a model that may go, the cheapest first; of equals those without light, then in
/// the order of their elements. `static_is_frozen`: those of the dynamic set alone.
std::vector<Removal> removal_order(const GaussianModel& model, const Contributions& contributions,
                                   bool static_is_frozen = false, const ByteRates& rates = {});

/// Dynamic Gaussians, ascending, that have less than 0.4 of their light in pixels that may
/// move. Beside a static set that is frozen they correct what it shows of the training views, in
/// each window of a clip in another way, and go. None where it is not known what moves.
std::vector<int64_t> still_dynamic(const Contributions& contributions);

/// Gaussians that are left where the curve of ln(bytes) and dB, as removals in this order add to
/// it, is farthest above the line from its end of `least_share` of the bytes to its beginning, each
/// axis scaled to [0, 1]. No fewer than one, if there are any. Those that were not seen are counted
/// as gone: most of them show nothing in the other frames, either.
int64_t knee_count(const std::vector<Removal>& order, const Contributions& contributions,
                   double least_share = 1.0 / 32);

/// Error by byte of the last removal that leaves `count`: the slope of the rate–distortion curve
/// there; 0 where nothing goes.
double error_per_byte_at(const std::vector<Removal>& order, int64_t count);

/// Elements of each set that are left when only `count` are, ascending: exactly so many, or all
/// where there are fewer; those that are not in the order always.
struct KeptElements {
  std::vector<int64_t> set_elements[2];
};
KeptElements kept_elements(const GaussianModel& model, const std::vector<Removal>& order,
                           int64_t count);
int64_t seen_count(const std::vector<Removal>& order);
/// The edit that leaves `count` of those that were seen, and all others, of the model that `order`
/// is of.
StateEdit cut_to(const std::vector<Removal>& order, int64_t count);

/// The model of only these elements, in the host's memory.
GaussianModel with_elements(const GaussianModel& model, const KeptElements& elements);

}  // namespace tessera
