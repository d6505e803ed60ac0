// Density control of a set: the backend chooses elements, and every buffer of the set is gathered
// by index.
#include "recon4d/density/density.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "kernels/base/errors.h"
#include "recon4d/model/element_edits.h"

namespace tessera {
namespace {

/// Element i becomes element index[i]; −1 and elements from `inherited` on: zeros. One copy of one
/// buffer at a time.
void gather(Backend& backend, Span<const int64_t> index, int width, int64_t inherited,
            Buffer<float>& buffer) {
  {
    Buffer<float> to(index.size * width, backend.memory());
    backend.gather_elements(std::as_const(buffer).span(), index, width, inherited, to.span());
    buffer = std::move(to);  // swaps: `to` frees the old elements at the end of this block
  }
  // the old elements of a large group are not kept beside the new ones of the next
  constexpr int64_t kLarge = int64_t{1} << 22;
  if (buffer.size() > kLarge) backend.memory().trim();
}

/// Elements of the values and of the moments; moments of places ≥ `inherited` become zero.
void gather(Backend& backend, Span<const int64_t> values, Span<const int64_t> moments,
            int64_t inherited, GaussianSet& set) {
  const bool has_moments = set.has_moments();
  for (int g = 0; g < set.groups(); ++g) {
    ParameterGroup& group = set.group(Group(g));
    const int width = set.width(Group(g));
    gather(backend, values, width, values.size, group.value);
    if (!has_moments) continue;
    const int buffers = moment_buffers(Group(g));
    if (buffers > 0) gather(backend, moments, width, inherited, group.moment1);
    if (buffers > 1) gather(backend, moments, width, inherited, group.moment2);
  }
  set.set_count(values.size);
}

void gather(Backend& backend, Span<const int64_t> index, int64_t inherited, GaussianSet& set) {
  gather(backend, index, index, inherited, set);
}

/// Whether Gaussians of a set grow by halves though others do not.
bool is_halved(const TrainOptions& options, SetForm form) {
  return options.static_halves && !is_dynamic(form);
}

DensityRule rule_of(const DensityContext& context, const GaussianSet& set) {
  const TrainOptions& options = context.options;
  DensityRule rule;
  rule.threshold = options.densify_threshold;
  if (!is_dynamic(set.form())) rule.threshold *= options.static_threshold;
  rule.prune_opacity = options.prune_opacity;
  // a half is no copy: with halves nothing is cloned
  const bool halved = is_halved(options, set.form());
  rule.halves = halved || grows_with(options, GrowthPart::kLongAxisSplit);
  rule.largest_clone = rule.halves ? 0 : options.dense_fraction * context.extent;
  if (context.prune_large) rule.largest_kept = options.prune_extent * context.extent;
  rule.room = context.room;
  rule.drawn = halved || grows_with(options, GrowthPart::kWeightedDraw);
  rule.seed = uint64_t(options.seed) ^ uint64_t(context.step) << 20;
  return rule;
}

}  // namespace

float length_share(const TrainOptions& options, SetForm form) {
  constexpr double kStaticShare = 0.125;
  if (grows_with(options, GrowthPart::kAbsoluteGradient)) return 1;
  // lengths do not cancel where residuals are noise
  return is_halved(options, form) ? float(kStaticShare / (1 + std::max(0.0, options.noise))) : 0;
}

void take_elements(Backend& backend, Span<const int64_t> values, Span<const int64_t> moments,
                   GaussianSet& set) {
  check(!set.blocks().mixed(), "take_elements: of a set of several SH degrees");
  check(values.size == moments.size, "take_elements: as many elements of moments as of values");
  gather(backend, values, moments, moments.size, set);
}

double growth_weight(Backend& backend, const DensityContext& context, const GaussianSet& set,
                     const SetStatistics& statistics) {
  return backend.growth_weight(set.values(), statistics.spans(), rule_of(context, set));
}

DensityReport control_density(Backend& backend, const DensityContext& context, GaussianSet& set,
                              SetStatistics& statistics) {
  check(!set.blocks().mixed(), "control_density: of a set of several SH degrees");
  const StageTimer timer(backend.clock(), kDensity);
  const int64_t before = set.count();
  DensityElements elements(backend.memory());
  const DensityRule rule = rule_of(context, set);
  backend.select_elements(std::as_const(set).values(), std::as_const(statistics).spans(), rule,
                          elements);
  gather(backend, std::as_const(elements.index).span(), elements.survivors, set);
  backend.place_children(set.values(), elements.survivors + elements.clones,
                         {rule.halves, rule.seed});
  statistics.reset(backend, set.count());
  return {elements.clones, elements.parents, elements.pruned, before, set.count()};
}

void reset_opacity(Backend& backend, GaussianSet& set, Span<float> filter_size) {
  constexpr float kResetOpacity = 0.01f, kResetLogit = -4.595119953155518f;  // its logit  [3DGS]
  const StageTimer timer(backend.clock(), kDensity);
  ParameterGroup& group = set.group(kOpacityLogit);
  if (filter_size.empty()) {
    backend.limit_values(group.value.span(), kResetLogit);
  } else {
    GaussianSpans<float> filtered = set.values();
    filtered.filter_size = filter_size;
    backend.edit_by_filter(FilterEdit::kLimitOpacity, filtered, kResetOpacity);
  }
  backend.fill_zero(group.moment1.span());
  backend.fill_zero(group.moment2.span());
}

void reorder(Backend& backend, GaussianSet& set, SetStatistics& statistics) {
  if (set.count() == 0) return;
  const StageTimer timer(backend.clock(), kDensity);
  std::vector<ElementMove> moves;
  for_each_block(set, [&](const ShBlock& block) {
    moves.push_back({block, block.coefficients, Buffer<int64_t>(backend.memory())});
    backend.locality_order(std::as_const(set).values().block(block), moves.back().index);
  });
  move_elements(backend, moves, set, statistics);
}

int64_t prune_invisible(Backend& backend, GaussianSet& set, SetStatistics& statistics,
                        double least) {
  const StageTimer timer(backend.clock(), kDensity);
  DensityRule rule;
  rule.threshold = std::numeric_limits<double>::infinity();
  rule.prune_opacity = least;
  std::vector<ElementMove> moves;
  int64_t pruned = 0;
  for_each_block(set, [&](const ShBlock& block) {
    DensityElements elements(backend.memory());
    backend.select_elements(std::as_const(set).values().block(block),
                            std::as_const(statistics).spans().block(block), rule, elements);
    moves.push_back({block, block.coefficients, std::move(elements.index)});
    pruned += elements.pruned;
  });
  if (pruned > 0) move_elements(backend, moves, set, statistics);
  statistics.reset(backend, set.count());
  return pruned;
}

}  // namespace tessera
