// A GaussianSet (static, dynamic or canonical) owns its parameter groups and their Adam moments in
// any memory. A GaussianModel is a static or canonical set, the motion nodes of the latter, and a
// dynamic set. SetStatistics are what training gathers of the elements of a set.
#pragma once
#include <array>
#include <cstdint>

#include "ingest/scene.h"
#include "kernels/backend.h"
#include "kernels/base/buffer.h"
#include "kernels/base/light_gain.h"
#include "kernels/drawing_rules.h"
#include "kernels/gaussians.h"
#include "kernels/math/bounds.h"
#include "kernels/math/spherindrical.h"
#include "kernels/motion_nodes.h"

namespace tessera {

/// Values that are optimised together, with Adam's moments of them.
struct ParameterGroup {
  explicit ParameterGroup(Memory& memory = host_memory())
      : value(memory), moment1(memory), moment2(memory) {}

  Buffer<float> value;  // [N, width]
  /// [N, width] Adam's m and v; empty in a model that only renders. Of groups that pack them both
  /// are in the words of moment1, and moment2 is empty.
  Buffer<float> moment1, moment2;

  /// Deep copy in a memory, with the moments that there are or without.
  ParameterGroup clone_to(Memory& memory, bool moments) const;
};

inline constexpr int64_t kMaxNodes = 1024;
inline constexpr int kMaxKnots = 256;

struct NodeCounts {
  int64_t count = 0;  // M, at most kMaxNodes; 0: there are none
  int knots = 0;      // S, at least kSplineOrder where there are nodes
  /// Steps done when they were made, and when they were last given more control points: from then
  /// on count the steps of Adam of logits and of nodes.
  int64_t started = 0, refitted = 0;
};

/// Nodes that carry a canonical set through the clip (kernels/motion_nodes.h, method D.9): shared
/// positions, radii and control points, stored beside the sets.
struct MotionNodes : NodeCounts {
  explicit MotionNodes(Memory& memory = host_memory())
      : position(memory), log_radius(memory), translation(memory), rotation(memory) {}

  Buffer<float> position;                            // [M, 3] world units, fixed
  ParameterGroup log_radius, translation, rotation;  // [M], [M, S, 3], [M, S, 4]

  bool empty() const { return count == 0; }
  /// Sets the sizes of all arrays; values are undefined until written. Moments are dropped.
  void resize(int64_t nodes, int control_points);
  /// Zero moments where there are none, on the host.
  void ensure_moments();
  /// The groups that are optimised, and their sizes.
  std::array<ParameterGroup*, 3> groups() { return {&log_radius, &translation, &rotation}; }
  std::array<const ParameterGroup*, 3> groups() const {
    return {&log_radius, &translation, &rotation};
  }
  std::array<int64_t, 3> scalars() const { return {count, 3 * count * knots, 4 * count * knots}; }
  NodeSpans<float> spans();
  NodeSpans<const float> spans() const;
  /// Deep copy in a memory, with the moments that there are or without.
  MotionNodes clone_to(Memory& memory, bool moments) const;
};

class GaussianSet {
 public:
  /// `coefficients`: SH coefficients per channel that are stored, (degree+1)²; `time_levels`: of a
  /// dynamic set, how often again, for the levels of time.
  GaussianSet(SetForm form, int coefficients, Memory& memory = host_memory(), int time_levels = 0);

  SetForm form() const { return form_; }
  int dim() const { return dim_of(form_); }
  int64_t count() const { return count_; }
  /// K, the most that an element has.
  int coefficients() const { return coefficients_; }
  /// Where elements differ in K: in a training alone, after element_edits.h has sorted them.
  const ShBlocks& blocks() const { return blocks_; }
  int time_levels() const { return time_levels_; }
  Memory& memory() const { return *memory_; }
  int groups() const { return group_count(form_); }
  /// Scalars of an element. Errors: std::logic_error of kSh and kShTime where elements differ.
  int width(Group group) const;
  /// Scalars of all elements.
  int64_t scalars(Group group) const { return scalars(group, count_, blocks_); }
  ParameterGroup& group(Group group) { return groups_[group]; }
  const ParameterGroup& group(Group group) const { return groups_[group]; }

  /// Sets N; values are undefined until written. Moments are dropped.
  void resize(int64_t count, const ShBlocks& blocks = {});
  /// Declares N before the arrays are there, whoever reads them gives each its size.
  void declare(int64_t count, const ShBlocks& blocks);
  /// Declares N after the groups were replaced element by element (density.cpp). Errors:
  /// std::logic_error when a group does not have N elements.
  void set_count(int64_t count, const ShBlocks& blocks = {});
  /// Zero moments where there are none. Of a set in the host's memory only: std::logic_error.
  void ensure_moments();
  bool has_moments() const { return !groups_[kMean].moment1.empty() || count_ == 0; }

  GaussianSpans<float> values() { return spans<float>(&ParameterGroup::value, *this); }
  GaussianSpans<const float> values() const {
    return spans<const float>(&ParameterGroup::value, *this);
  }
  GaussianSpans<float> moments1() { return spans<float>(&ParameterGroup::moment1, *this); }
  GaussianSpans<float> moments2() { return spans<float>(&ParameterGroup::moment2, *this); }

  /// An empty set of the same form, K and L.
  GaussianSet like(Memory& memory = host_memory()) const {
    return {form_, coefficients_, memory, time_levels_};
  }
  /// Deep copy in a memory, with the moments that there are or of the values alone.
  GaussianSet clone_to(Memory& memory, bool moments = true) const;
  GaussianSet clone_values(Memory& memory = host_memory()) const { return clone_to(memory, false); }
  /// Bytes of the values: 4 · scalars of all groups.
  int64_t value_bytes() const;

 private:
  template <class T, class Self>
  static GaussianSpans<T> spans(Buffer<float> ParameterGroup::*member, Self& self) {
    GaussianSpans<T> result;
    result.form = self.form_;
    result.count = self.count_;
    result.coefficients = self.coefficients_;
    result.time_levels = self.time_levels_;
    result.blocks = self.blocks_;
    for (int g = 0; g < self.groups(); ++g) result.group[g] = (self.groups_[g].*member).span();
    return result;
  }

  int64_t scalars(Group group, int64_t count, const ShBlocks& blocks) const;
  SetForm form_;
  int coefficients_, time_levels_;
  Memory* memory_;
  int64_t count_ = 0;
  ShBlocks blocks_;
  std::array<ParameterGroup, kGroupCount> groups_;
};

/// Colours times the factors of a light, from all directions: of a set of one SH degree in the
/// host's memory, without levels of time.
void apply_light(const LightGain& light, GaussianSet& set);

/// Light from beyond the scene: a map of directions (kernels/math/environment.h).
struct EnvironmentLight {
  EnvironmentLight() = default;
  explicit EnvironmentLight(Memory& memory) : map(memory) {}

  int height = 0;                  // H; 0: there is none
  ParameterGroup map;              // [H, 2H, 3] RGB
  glm::dmat3 map_from_world{1.0};  // a model that is turned looks it up turned

  /// Deep copy in a memory, with the moments that there are or without.
  EnvironmentLight clone_to(Memory& memory, bool moments) const;
};

/// Under which the Gaussians of a model were trained.
struct ModelSettings {
  DrawingRules drawing;                        // as it was trained
  TimeAxis time_axis;                          // normalised time → the capture's own
  Similarity prepared_from_source;             // the model's world by the source's
  std::array<uint8_t, 3> background{0, 0, 0};  // sRGB, what it was trained on
  double train_scale = 1;  // size of the images it was trained on, by the scene's
};

/// What a training produces and every other command reads.
struct GaussianModel : ModelSettings {
  GaussianSet static_set{SetForm::kStatic, kMaxShCoefficients};
  GaussianSet dynamic_set{SetForm::kPair, kMaxShCoefficients};
  MotionNodes nodes;             // of a canonical static set; else none
  EnvironmentLight environment;  // behind both

  template <class Real>
  Cutoff<Real> cutoff() const {
    return make_cutoff<Real>(drawing);
  }
  int64_t count() const { return static_set.count() + dynamic_set.count(); }
  /// Whether anything changes with time.
  bool moves() const { return dynamic_set.count() > 0 || !nodes.empty(); }
  /// Deep copies in a memory: with the moments that there are, or of the values alone.
  GaussianModel clone_to(Memory& memory, bool moments = true) const;
  GaussianModel clone_values(Memory& memory = host_memory()) const {
    return clone_to(memory, false);
  }
};

/// What training gathers of each Gaussian of a set beside its parameters, since the last density
/// control.
struct SetStatistics {
  explicit SetStatistics(Memory& memory = host_memory())
      : gradient_sum(memory), count(memory), filter_size(memory) {}

  Buffer<float> gradient_sum, count;  // [N] as DensityStatistics
  /// [N] φ of the 3D filter, world units; empty: there is none, or it is to be measured.
  Buffer<float> filter_size;

  /// Nothing gathered or measured. The first is for the host's memory.
  void reset(int64_t gaussians);
  void reset(Backend& backend, int64_t gaussians);
  SetStatistics clone_to(Memory& memory) const;
  DensityStatistics<float> spans() { return {gradient_sum.span(), count.span()}; }
  DensityStatistics<const float> spans() const { return {gradient_sum.span(), count.span()}; }
};

}  // namespace tessera
