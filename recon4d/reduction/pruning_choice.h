// Decisions on the size of a model as pure functions: how many Gaussians remain in the end and
// after this round, how many go at once, and how many SH bands each of them keeps.
// Source: docs/explanation/size.md.
#pragma once
#include <cstdint>
#include <vector>

#include "recon4d/reduction/pruning.h"

namespace tessera {

/// What a round of pruning aims at. At most one of the first three is given; without one the aim is
/// the knee of the scene's curve of size and error.
struct SizeRequest {
  int64_t gaussians = 0;       // 0: not requested
  int64_t bytes = 0;           // of the exported file; 0: not requested
  double within_db = 0;        // dB of PSNR that may be lost; 0: not requested
  int64_t file_bytes = 0;      // of the exported file of the model as it is, with `bytes`
  double validation_room = 0;  // dB that the validation views have left of within_db
  int64_t known_goal = 0;      // Gaussians: the goal of an earlier round that holds; 0: none
  int64_t rounds_left = 1;     // with this one
};

/// Numbers of Gaussians that the pass has seen: what it has not is known to a later one only, and
/// stays.
struct PruningChoice {
  int64_t knee = 0;           // that the knee of the curve leaves
  int64_t goal = 0;           // that the last round is to leave; 0: none was seen
  int64_t after = 0;          // that this round leaves
  double error_per_byte = 0;  // squared error per byte at the knee
};
/// `order`: as removal_order returns it for `contributions`. Rounds take equal shares of the
/// logarithm of the size; with `within_db` each goes all the way, because the next looks again.
PruningChoice choose_pruning(const std::vector<Removal>& order, const Contributions& contributions,
                             const SizeRequest& request);

/// Gaussians that the next cut leaves on the way from `now` to `after`, at least one less: what
/// hides behind those that go is seen only when they are gone, so no more than a share goes at
/// once.
int64_t next_cut(int64_t now, int64_t after);

/// The SH degree of each element of a set, [N]: that at which the squared error of the bands left
/// out and the price of the bytes kept are least together, of equals the lowest.
/// `degrees`: [N] the degrees now, `contributions`: of that set, `dynamic`: which set,
/// `sh_degree`: the highest that is drawn, `error_per_byte`: squared error per byte.
std::vector<uint8_t> choose_degrees(std::vector<uint8_t> degrees,
                                    const SetContributions& contributions, bool dynamic,
                                    int sh_degree, double error_per_byte);

}  // namespace tessera
