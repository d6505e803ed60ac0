// Motion nodes of a model: shared positions, radii and control points that carry its canonical set
// through the clip (kernels/motion_nodes.h, method D.9). They are data beside the sets.
#pragma once
#include <array>

#include "kernels/motion_nodes.h"
#include "recon4d/model/parameter_group.h"

namespace tessera {

inline constexpr int64_t kMaxNodes = 1024;
inline constexpr int kMaxKnots = 256;

struct MotionNodes {
  explicit MotionNodes(Memory& memory = host_memory())
      : position(memory), log_radius(memory), translation(memory), rotation(memory) {}

  int64_t count = 0;  // M, at most kMaxNodes; 0: there are none
  int knots = 0;      // S, at least kSplineOrder where there are nodes
  /// Steps done when they were made, and when they were last given more control points: from then
  /// on count the steps of Adam of logits and of nodes.
  int64_t started = 0, refitted = 0;
  Buffer<float> position;                            // [M, 3] world units, fixed
  ParameterGroup log_radius, translation, rotation;  // [M], [M, S, 3], [M, S, 4]

  bool empty() const { return count == 0; }
  /// Sets the sizes of all arrays; values are undefined until written. Moments are dropped.
  void resize(int64_t nodes, int control_points);
  /// Zero moments where there are none, on the host.
  void ensure_moments();
  /// The groups that are optimised.
  std::array<ParameterGroup*, 3> groups() { return {&log_radius, &translation, &rotation}; }
  std::array<const ParameterGroup*, 3> groups() const {
    return {&log_radius, &translation, &rotation};
  }
  NodeSpans<float> spans();
  NodeSpans<const float> spans() const;
  /// Deep copy in a memory, with the moments that there are or without.
  MotionNodes clone_to(Memory& memory, bool moments) const;
};

}  // namespace tessera
