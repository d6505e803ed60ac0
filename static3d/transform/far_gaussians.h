// Which Gaussians are so far from the others that a format that rounds by a common range would
// lose the others' values. All such formats ask here, each with what it can hold; floats need none.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "static3d/transform/scene_box.h"

namespace tessera {

/// Gaussians in shells around the median of the means. Shell 0 is the core: within kCoreFactor half
/// extents on all axes. Each further shell has twice the width of the one before.
class FarShells {
 public:
  static constexpr float kCoreFactor = 4;  // half extents

  /// Of sound Gaussians.
  explicit FarShells(const GaussianSpans<const float>& set);

  /// All are in the core where at least half of the means are one point.
  int of_mean(int64_t n) const;
  /// The same of the colour along no direction, whose core is within ±kCoreFactor of the middle.
  int of_colour(int64_t n) const;
  const SceneBox& box() const { return box_; }

 private:
  GaussianSpans<const float> set_;
  SceneBox box_;
};

struct HeldRows {
  std::vector<int64_t> rows, beyond;  // of one set; together all rows
};

/// `beyond`: those outside the core whose mean `holds` refuses. Rows ascend.
HeldRows rows_within(const GaussianSpans<const float>& set, const FarShells& shells,
                     const std::function<bool(const float* mean)>& holds);

/// For formats that round means and colours by the range of every `chunk` rows: shell after shell
/// from the outermost to the core, so that the last chunk alone is not full; along a Morton curve
/// in each. A chunk with rows of the core has none beyond shell 1, another chunk spans four shells
/// at most. `beyond` has the rows that would not fill a chunk so: fewer than `chunk` for each gap,
/// none where each shell has a chunk's rows.
HeldRows rows_in_chunks(const GaussianSpans<const float>& set, int64_t chunk);

}  // namespace tessera
