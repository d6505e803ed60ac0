// The whole state of a training, from which it continues as if it had not stopped, and the model in
// it. A StateEdit is a change of its Gaussians as a value: decisions return it, and `apply_edit`
// carries it out.
#pragma once
#include <cstdint>
#include <vector>

#include "kernels/backend.h"
#include "recon4d/model/exposure.h"
#include "recon4d/model/gaussian_set.h"
#include "recon4d/model/parameter_average.h"
#include "recon4d/options/train_options.h"

namespace tessera {

/// How far a training is.
struct TrainProgress {
  int64_t iteration = 0;  // steps done
  int64_t sampler_epoch = 0, sampler_position = 0;
  double seconds = 0;     // spent in steps and decisions
  int64_t decided = 0;    // steps done at the last decision of ModelReduction
  int64_t goal = 0;       // Gaussians that its thinning is to leave; 0: not known yet
  bool finished = false;  // the last clean-up is done
  /// The static set stays to the bit as it is: it is drawn, and nothing else. So do the colours of
  /// the training images, by which it was trained.
  bool static_is_frozen = false;
};

struct TrainState : TrainProgress {
  GaussianModel model;          // in any memory
  SetStatistics statistics[2];  // static, dynamic
  LearntRows exposure;          // on the host
  LearntRows clocks;            // on the host
  ParameterAverage average;     // over the last steps; none before TrainOptions::average_from

  /// Whether set k changes.
  bool trains(int k) const { return k == 1 || !static_is_frozen; }
  GaussianSet& set(int k) { return k == 0 ? model.static_set : model.dynamic_set; }
  const GaussianSet& set(int k) const { return k == 0 ? model.static_set : model.dynamic_set; }
  TrainState clone_to(Memory& memory) const;
  bool has_filter_sizes() const {
    return !statistics[0].filter_size.empty() || !statistics[1].filter_size.empty();
  }
  /// Whether elements of a set differ in their SH degree (element_edits.h).
  bool has_blocks() const {
    return model.static_set.blocks().mixed() || model.dynamic_set.blocks().mixed();
  }
  /// Values of set k with the sizes of the 3D filter, for Backend::edit_by_filter.
  GaussianSpans<float> filtered_values(int k);
};

/// Values of set k as they are to be drawn: with the 3D filter where the options have one.
GaussianSpans<const float> drawn_values(const TrainState& state, int k,
                                        const TrainOptions& options);

/// Whether the model of a state still has a 3D filter to be baked.
bool is_filtered(const TrainState& state, const TrainOptions& options);

/// A copy of the model of a state in the host's memory, with the 3D filter baked and elements that
/// are alike.
GaussianModel baked_model(const TrainState& state, const TrainOptions& options);
/// The same of a state that is not needed afterwards: in its own memory.
GaussianModel baked_model(TrainState&& state, const TrainOptions& options);

/// Index 0 is the static set, index 1 the dynamic set.
struct StateEdit {
  /// Elements of the set as it is before the edit, ascending.
  std::vector<int64_t> dropped[2];
  /// Sets of the same form, K and L as the set that they join, in any memory; in this order.
  std::vector<GaussianSet> added[2];
  /// [N] SH degree of each element after drops and additions; empty: the degrees stay.
  std::vector<uint8_t> degrees[2];

  /// Whether it changes no element.
  bool empty() const;
};

/// Drops static elements, then dynamic ones, then adds to the static set and to the dynamic set,
/// one added set after the other, and last assigns SH degrees. Kept elements keep their moments and
/// statistics; added ones begin with zeros and without a size of the 3D filter. The state lies in
/// the backend's memory. Errors: std::logic_error: dropped elements that do not ascend or do not
/// exist, added sets of another layout, degrees that are not one for each element or that exceed
/// the element's own.
void apply_edit(Backend& backend, const StateEdit& edit, TrainState& state);

}  // namespace tessera
