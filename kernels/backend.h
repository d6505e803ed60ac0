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

/// The operations and what each does are in operations.inc. A device runs behind the host: only
/// `project`, `outcome`, `select_elements`, `growth_weight`, `relocate_elements`, `sum_of_squares`
/// and memory().copy wait for it. All spans and buffers of the arguments lie in memory().
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

#define OPERATION(result, name, parameters, names) virtual result name parameters = 0;
#include "kernels/operations.inc"
};

using Backend = BackendOf<float>;

std::unique_ptr<Backend> make_cpu_backend();
/// On the device of that number, which becomes the calling thread's; device_probe.h tells what is
/// there. Errors: DeviceError when this build or machine has no such CUDA device.
std::unique_ptr<Backend> make_cuda_backend(int device = 0);

}  // namespace tessera
