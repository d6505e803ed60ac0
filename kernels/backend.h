// The stages of a training step for a batch of views, the operations on sets, and the arguments of
// both. A backend defines how data is traversed; the equations are in math/ and the order of the
// stages is in pipeline.h. CpuBackend exists in float (production) and in double (reference),
// CudaBackend in float only.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "kernels/base/errors.h"
#include "kernels/batch.h"
#include "kernels/gaussians.h"
#include "kernels/math/colour_map.h"
#include "kernels/math/contribution.h"
#include "kernels/math/filter_3d.h"
#include "kernels/math/residual_vote.h"
#include "kernels/motion_nodes.h"
#include "kernels/pixel_search.h"
#include "kernels/stage_clock.h"

namespace tessera {

template <class Real>
struct ProjectArgs {
  const ViewBatch<Real>* batch = nullptr;
  GaussianSpans<const Real> sets[2];  // static, dynamic; either may be empty
  RenderOptions options;
  bool for_backward = false;  // keeps what its gradient needs
};

template <class Real>
struct BinArgs {
  const ViewBatch<Real>* batch = nullptr;
  const Splats<Real>* splats = nullptr;
  RenderOptions options;
  bool for_backward = false;  // also fills TileInstances::slot
};

template <class Real>
struct BlendArgs {
  const ViewBatch<Real>* batch = nullptr;
  const Splats<Real>* splats = nullptr;
  const TileInstances<Real>* instances = nullptr;
  RenderOptions options;
  bool for_backward = false;  // keeps what its gradient needs
};

template <class Real>
struct PhotometricArgs {
  const ViewBatch<Real>* batch = nullptr;
  Span<const Real> colour;                 // [3·pixels], laid out as Images::colour
  std::vector<Span<const uint8_t>> truth;  // [B] each [height, width, 3], in the backend's memory
  LossWeights weights;
  /// [B] each [height, width], 0: the pixel is ignored; an empty span: all pixels of that view
  /// count. Empty: of every view.
  std::vector<Span<const uint8_t>> mask;
};

/// Images as their cameras would have taken them.
template <class Real>
struct ColourMapArgs {
  const ViewBatch<Real>* batch = nullptr;
  std::vector<ColourMap<double>> maps;  // [B]
  Span<const Real> colour;              // [3·pixels] as rendered, laid out as Images::colour
};

template <class Real>
struct BlendBackwardArgs {
  BlendArgs<Real> forward;
  const Images<Real>* images = nullptr;
  Span<const Real> d_colour;  // [3·pixels], laid out as Images::colour
  Span<Real> lengths = {};  // [S] written: Σ over pixels of |f|·‖conic·d‖; empty: not wanted
};

template <class Real>
struct SensitivityArgs {
  BlendBackwardArgs<Real> pass;           // d_colour: the image x
  std::vector<Span<const uint8_t>> mask;  // of what x is the residual: as PhotometricArgs::mask
  std::vector<Vec3<double>> response;     // [B] RGB of each view (channel_response); empty: 1
};

/// The residual of a batch, of which pixels that move may be missed.
template <class Real>
struct MissedArgs {
  const ViewBatch<Real>* batch = nullptr;
  Span<const Real> residual;  // [3·pixels], laid out as Images::colour
  /// [B] as PhotometricArgs::mask, but only kMovingPixel counts.
  std::vector<Span<const uint8_t>> mask;
};

/// Views of one timestep, and the places that they may agree on.
template <class Real>
struct VoteArgs {
  const ViewBatch<Real>* batch = nullptr;
  Span<const uint8_t> missed;  // [pixels]
  VoteGrid<Real> grid;
};

/// Splats of a forward pass and their sums, to be added to those of their Gaussians. Timesteps
/// ascend in each series of views, which follow one another.
template <class Real>
struct ContributionArgs {
  ProjectArgs<Real> forward;
  const Splats<Real>* splats = nullptr;
  Span<const SplatSensitivity<Real>> sums;  // [S]
  Span<ElementSums<Real>> elements;         // [N] static set first
  Span<TimeVariation> variation;            // [N of the static set]; empty: not wanted
};

/// Dynamic Gaussians, all of one K, and the static ones that they become.
template <class Real>
struct DemoteArgs {
  GaussianSpans<const Real> from;
  RenderOptions options;               // by which their colours change with time
  Span<const Real> timestep, opacity;  // [N] at which, and as opaque as; opacity 0: as stored
  GaussianSpans<Real> to;              // [N] of the same K
};

template <class Real>
struct ProjectBackwardArgs {
  ProjectArgs<Real> forward;
  const Splats<Real>* splats = nullptr;
  Span<SplatMoments<Real>> d_splats;  // [S]
  SinkArgs<Real> sinks[2];
  DensityStatistics<Real> statistics[2];  // empty spans: not gathered
  Span<const Real> lengths = {};          // [S] of BlendBackwardArgs, for statistics that take them
  RegulariserWeights regulariser;         // into the gradients
  /// [B, N] of a canonical set: gradient by what each Gaussian is in each view; written.
  Span<CarriedGaussian<Real>> d_carried;
  bool by_time = false;  // the outcome has d_times and d_readouts
};

/// Light from beyond the scene, behind all Gaussians (math/environment.h).
template <class Real>
struct EnvironmentArgs {
  const ViewBatch<Real>* batch = nullptr;
  Span<const Real> map;  // [H, 2H, 3] RGB; empty: there is none
  int height = 0;        // H
  Mat3<Real> map_from_world{1};
};

// A stage has a truth, a mask and a colour map for every view, or none where there may be none.
// Sizes are not checked: a span of a device has only its length.

/// Of masks, for a batch of `views`. Errors: std::logic_error.
inline void check_target(size_t views, const std::vector<Span<const uint8_t>>& mask) {
  check(mask.empty() || mask.size() == views, "one mask per view");
}
template <class Real>
void check_target(const PhotometricArgs<Real>& args) {
  check(args.truth.size() == args.batch->views.size(), "one ground truth per view");
  check_target(args.batch->views.size(), args.mask);
}
template <class Real>
void check_target(const SensitivityArgs<Real>& args) {
  const size_t views = args.pass.forward.batch->views.size();
  check_target(views, args.mask);
  check(args.response.empty() || args.response.size() == views, "one response per view");
}
template <class Real>
void check_target(const ColourMapArgs<Real>& args) {
  check(args.maps.size() == args.batch->views.size(), "one map of colours per view");
}

template <class Real>
void check_missed(const MissedArgs<Real>& args, const Span<uint8_t>& missed) {
  check_target(args.batch->views.size(), args.mask);
  check(args.residual.size == 3 * args.batch->pixels, "missed_pixels: size of the images");
  check(missed.size == args.batch->pixels, "missed_pixels: one level a pixel");
}
template <class Real>
void check_votes(const VoteArgs<Real>& args, const Span<Real>& votes) {
  check(args.missed.size == args.batch->pixels, "residual_votes: one level a pixel");
  check(votes.size == args.grid.places(), "residual_votes: one vote a place");
}

/// The views that may see a set, and what the size of the 3D filter follows from.
template <class Real>
struct FilterArgs {
  const ViewBatch<Real>* views = nullptr;
  GaussianSpans<const Real> set;
  Real near_plane = Real(0);   // world units
  Real focal = Real(1);        // f, pixels: the largest of all training views
  Real time_filter = Real(0);  // RenderOptions::time_filter
};

/// What the stages of a step found out.
struct StepOutcome {
  std::vector<ViewLoss> losses;  // of the last photometric
  unsigned bad_groups = 0;       // a bit (1 << Group) per group with a non-finite gradient
  bool bad_values = false;       // adam_values met a non-finite gradient
  /// [B] of the mean loss by each map, of map_colours_backward after that photometric; empty: none.
  std::vector<ColourMap<double>> d_maps;
  /// [B] of the mean loss by the time and by the readout of each view, through the Gaussians of the
  /// dynamic set; empty: the last project_backward was not asked for it.
  std::vector<double> d_times, d_readouts;
};

/// A device runs behind the host: only `project`, `outcome`, `select_elements`,
/// `growth_weight`, `relocate_elements`, `sum_of_squares` and memory().copy wait for it. All spans
/// and buffers of the arguments lie in memory().
template <class Real>
class BackendOf {
 public:
  virtual ~BackendOf() = default;
  virtual std::string name() const = 0;  // "cpu, 2 threads"
  virtual Memory& memory() = 0;
  virtual StageClock& clock() = 0;
  /// Makes one more backend of the same device, on the thread that will use it: their work runs
  /// side by side. Empty: one uses all of the device.
  virtual std::function<std::unique_ptr<BackendOf>()> another() { return {}; }
  /// Depths of pixels on this device, in its memory; none where the host is as quick. It must end
  /// before this does.
  virtual std::unique_ptr<PixelSearch> pixel_search() { return nullptr; }

  /// Poses of the nodes in every view, weights of every binding, and every Gaussian of a canonical
  /// set in every view. What is bound to no node stays as it is at rest, bit by bit.
  virtual void carry(const CarryArgs<Real>& args, Carried<Real>& carried) = 0;
  /// Gaussians → visible splats of every view: slice, EWA, colour, tiles counted.
  virtual void project(const ProjectArgs<Real>& args, Splats<Real>& splats) = 0;
  /// Splats → instances by tile and depth.
  virtual void bin(const BinArgs<Real>& args, TileInstances<Real>& instances) = 0;
  /// Front-to-back blending of every tile.
  virtual void blend(const BlendArgs<Real>& args, Images<Real>& images) = 0;
  /// colour += transmittance · environment along the pixel. After `blend`, whose background then is
  /// black; before `photometric` and `blend_backward`, which so see what shows through Gaussians.
  virtual void environment(const EnvironmentArgs<Real>& args, Images<Real>& images) = 0;
  /// d_map [H, 2H, 3] is written; equal inputs give equal bits. Texels that a non-finite gradient
  /// falls on are not finite.
  virtual void environment_backward(const EnvironmentArgs<Real>& args, const Images<Real>& images,
                                    Span<const Real> d_colour, Span<Real> d_map) = 0;
  /// mapped [3·pixels], laid out as the images: A·c + o of every pixel.
  virtual void map_colours(const ColourMapArgs<Real>& args, Span<Real> mapped) = 0;
  /// After photometric of mapped images: d_colour becomes the gradient by the images as rendered,
  /// and `outcome` has the gradient by the maps. Equal inputs give equal bits.
  virtual void map_colours_backward(const ColourMapArgs<Real>& args, Span<Real> d_colour) = 0;
  /// Loss of each view, and d_colour of its mean over the batch (empty: not wanted). An ignored
  /// pixel adds nothing: |I − G| = 0, SSIM = 1, d_colour = 0; in the windows of others its truth is
  /// what was rendered, taken as constant. Means are over all pixels of the view, so that a pixel
  /// weighs the same with a mask and without.
  virtual void photometric(const PhotometricArgs<Real>& args, Span<Real> d_colour) = 0;
  /// colour − truth/255 of every pixel and channel, not clamped; 0 where the mask ignores the
  /// pixel. The weights are not used.
  virtual void residual(const PhotometricArgs<Real>& args, Span<Real> residual) = 0;
  /// Gradient of each splat, summed over its pixels, and the lengths that are asked for.
  virtual void blend_backward(const BlendBackwardArgs<Real>& args,
                              Span<SplatMoments<Real>> d_splats) = 0;
  /// What each splat is to the images; written, zeros for a splat that draws no pixel. After a
  /// forward pass with for_backward. Masks and responses are in removal1 and removal2 alone.
  virtual void sensitivity(const SensitivityArgs<Real>& args, Span<SplatSensitivity<Real>> out) = 0;
  /// Raises the value of each Gaussian that has a splat, [N] static set first, to its largest
  /// blending weight T·α over the pixels of the batch; masks are not looked at. After a forward
  /// pass with for_backward.
  virtual void largest_weights(const BlendArgs<Real>& forward, const Images<Real>& images,
                               Span<Real> elements) = 0;
  /// Adds the sums of splats to those of their Gaussians, view by view. The last timestep of the
  /// variation stays open: close_series of kernels/math/contribution.h.
  virtual void contributions(const ContributionArgs<Real>& args) = 0;
  /// Dynamic Gaussians → static ones (kernels/edits/demote.h).
  virtual void demote(const DemoteArgs<Real>& args) = 0;
  /// Of two residuals of one batch, laid out as Images::colour: by how much the squared error of
  /// each pixel grew, in the first channel of `residual`; zeros in the others.
  virtual void added_squares(const ViewBatch<Real>& batch, Span<const Real> before,
                             Span<Real> residual) = 0;
  /// How much each pixel is missed (missed_level); 0 where it does not move. Equal inputs give
  /// equal bits on all backends.
  virtual void missed_pixels(const MissedArgs<Real>& args, Span<uint8_t> missed) = 0;
  /// How much the views that see a place miss it, where enough of them do (residual_vote).
  virtual void residual_votes(const VoteArgs<Real>& args, Span<Real> votes) = 0;
  /// Equal inputs give equal bits. Waits.
  virtual double sum_of_squares(Span<const Real> values) = 0;
  /// Splat gradients → parameter gradients, summed over views, into the sinks; of a canonical set
  /// those by mean and rotation in each view, which carry_backward takes further.
  virtual void project_backward(const ProjectBackwardArgs<Real>& args) = 0;
  /// Gradients by mean and rotation in each view → by those at rest and by the logits, into the
  /// sink, and by the nodes. After project_backward.
  virtual void carry_backward(const CarryBackwardArgs<Real>& args) = 0;
  /// Of the last photometric and project_backward, and of adam_values after it; waits for these,
  /// not for what came after.
  virtual StepOutcome outcome() = 0;

  /// Adam over stored gradients: what the fused sink does, as a stage of its own.
  virtual void adam(const SinkArgs<Real>& args) = 0;
  /// A step of Adam of values that belong to no Gaussian; `outcome` says whether the gradient was
  /// finite.
  virtual void adam_values(Span<const Real> gradient, const AdamScalars<Real>& adam,
                           Span<Real> value, Span<Real> moment1, Span<Real> moment2) = 0;

  /// mean[i] += weight · (values[i] − mean[i]).
  virtual void add_to_mean(Span<const Real> values, Real weight, Span<Real> mean) = 0;

  /// to[i] = from[index[i]] for elements of `width` scalars; index −1 writes zeros, as do elements
  /// from `inherited` on.
  virtual void gather_elements(Span<const Real> from, Span<const int64_t> index, int width,
                               int64_t inherited, Span<Real> to) = 0;
  /// Which elements survive, are cloned and are split. Where room is short the rule says which
  /// grow.
  virtual void select_elements(const GaussianSpans<const Real>& set,
                               const DensityStatistics<const Real>& statistics,
                               const DensityRule& rule, DensityElements& elements) = 0;
  /// Σ of the scores of those that may grow by the rule, whatever room there is. Equal inputs give
  /// equal bits. Waits.
  virtual double growth_weight(const GaussianSpans<const Real>& set,
                               const DensityStatistics<const Real>& statistics,
                               const DensityRule& rule) = 0;
  /// Elements from `first` on, which are two copies of each Gaussian that is split, all first ones
  /// and then all second ones, become its children.
  virtual void place_children(const GaussianSpans<Real>& set, int64_t first,
                              const SplitRule& rule) = 0;
  /// Draws an alive Gaussian for every dead one and for every element that is added, with
  /// probability in proportion to opacity and with replacement. Those that were drawn n − 1 times
  /// become, in place, n Gaussians in one spot that together look as the one did; `elements` states
  /// the source of each copy. Where no Gaussian is alive nothing is moved, and `added` must be 0.
  virtual void relocate_elements(const GaussianSpans<Real>& set, const RelocationRule& rule,
                                 RelocationElements& elements) = 0;
  /// means += Σ·ξ · scale / (1 + exp(100·opacity − ½)), ξ normal.
  virtual void add_position_noise(const GaussianSpans<Real>& set, const PositionNoise& noise) = 0;
  /// Elements in Morton order of the means; of a Dim 4 set then stably by 32 bins of temporal
  /// means.
  virtual void locality_order(const GaussianSpans<const Real>& set, Buffer<int64_t>& order) = 0;
  /// φ[n] = √0.2·d/f, d the least depth of Gaussian n in the views that sample it, each at the time
  /// of that view; of one that none samples: the largest φ of the others; 0 where there are no
  /// others.
  virtual void filter_sizes(const FilterArgs<Real>& args, Span<Real> sizes) = 0;
  /// Every Gaussian of a set that has its φ with it. `limit`: an opacity, for kLimitOpacity.
  virtual void edit_by_filter(FilterEdit edit, const GaussianSpans<Real>& set, Real limit) = 0;
  /// values[i] ← min(values[i], limit).
  virtual void limit_values(Span<Real> values, Real limit) = 0;
  virtual void fill_zero(Span<Real> values) = 0;
};

using Backend = BackendOf<float>;

std::unique_ptr<Backend> make_cpu_backend();
/// On the device of that number, which becomes the calling thread's; device_probe.h tells what is
/// there. Errors: DeviceError when this build or machine has no such CUDA device.
std::unique_ptr<Backend> make_cuda_backend(int device = 0);

}  // namespace tessera
