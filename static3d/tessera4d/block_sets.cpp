// Decodes blocks one after the other and joins those of one kind; a file that promises more than it
// can hold is refused before its Gaussians take memory.
#include "static3d/tessera4d/block_sets.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"
#include "recon4d/model/element_edits.h"
#include "static3d/tessera4d/block.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostPerByte = 500;     // of memory, for a byte of the file; gzip ends at 1032
constexpr uint64_t kFreeBytes = 64 << 20;  // bytes of memory, however few the file has

/// Copies the elements of `part` behind the first `first` of `whole`.
void place_elements(const GaussianSet& part, GaussianSet& whole, int64_t first) {
  const GaussianSpans<const float> from = part.values();
  const GaussianSpans<float> to = whole.values();
  for (int g = 0; g < part.groups(); ++g)
    std::copy_n(from.group[g].data, from.group[g].size,
                to.group[g].data + first * whole.width(Group(g)));
}

/// The blocks of one kind as one set; unsound Gaussians are left out and counted.
GaussianSet joined(std::vector<GaussianSet> parts, SetForm form, int coefficients,
                   int64_t& unsound) {
  int64_t count = 0;
  for (GaussianSet& part : parts) {
    const std::vector<int64_t> elements = valid_elements(part);
    unsound += part.count() - int64_t(elements.size());
    if (int64_t(elements.size()) != part.count()) part = select_elements(part, elements);
    count += part.count();
  }
  GaussianSet whole(form, coefficients);
  whole.resize(count);
  int64_t first = 0;
  for (const GaussianSet& part : parts) {
    place_elements(part, whole, first);
    first += part.count();
  }
  return whole;
}

/// Static Gaussians in front of those that nodes carry, in one canonical set.
GaussianSet with_carried(const GaussianSet& fixed, const GaussianSet& carried) {
  GaussianSet whole(SetForm::kCanonical, fixed.coefficients());
  whole.resize(fixed.count() + carried.count());
  const GaussianSpans<float> to = whole.values();
  std::fill_n(to.group[kNode].data, kBindings * fixed.count(), -1.0f);
  std::fill_n(to.group[kNodeLogit].data, kBindings * fixed.count(), 0.0f);
  place_elements(fixed, whole, 0);
  place_elements(carried, whole, fixed.count());
  return whole;
}

/// Streams of equal words pack to a thousandth, so that a small damaged file could fill the memory.
/// `gaussians`: of the blocks so far, which have so many bytes.
void check_promise(int64_t gaussians, int64_t bytes, int coefficients, const fs::path& path) {
  const GaussianSet widest(SetForm::kCanonical, coefficients);
  uint64_t scalars = 0;
  for (int g = 0; g < widest.groups(); ++g) scalars += uint64_t(widest.width(Group(g)));
  const uint64_t promised = uint64_t(gaussians) * scalars * sizeof(float);
  if (promised > kMostPerByte * uint64_t(bytes) + kFreeBytes)
    throw InputError(
        fmt::format("{}: its blocks promise {} Gaussians in {} bytes; it is damaged, fetch or "
                    "export it again",
                    path.string(), gaussians, bytes));
}

}  // namespace

GaussianModel rules_of(const GaussianModel& model, const TimeAxis& clock) {
  GaussianModel rules;
  rules.drawing = model.drawing;
  rules.time_axis = clock;
  rules.prepared_from_source = model.prepared_from_source;
  rules.background = model.background;
  rules.train_scale = model.train_scale;
  return rules;
}

GaussianModel model_of_blocks(const Tessera4dContainer& container,
                              const std::function<bool(const BlockInfo&)>& wanted,
                              std::vector<std::string>& warnings) {
  GaussianModel model = rules_of(container.rules(), container.rules().time_axis);
  std::vector<GaussianSet> fixed, moving, carried;
  const int coefficients = sh_coefficients(model.drawing.sh_degree);
  int64_t gaussians = 0, packed = 0;
  for (const BlockInfo& info : container.manifest().blocks) {
    if (!wanted(info)) continue;
    const std::string bytes = container.block(info);
    check_promise(gaussians += info.count, packed += int64_t(bytes.size()), coefficients,
                  container.path());
    (info.moving      ? moving
     : info.nodes > 0 ? carried
                      : fixed)
        .push_back(decode_block(bytes, info, model.drawing.sh_degree,
                                container.manifest().anchor_in_clip, container.file_of(info),
                                &model.nodes));
  }
  int64_t unsound = 0;
  model.static_set = joined(std::move(fixed), SetForm::kStatic, coefficients, unsound);
  if (!carried.empty())
    model.static_set = with_carried(
        model.static_set, joined(std::move(carried), SetForm::kCanonical, coefficients, unsound));
  model.dynamic_set = joined(std::move(moving), SetForm::kVelocity, coefficients, unsound);
  if (unsound > 0)
    warnings.push_back(fmt::format("{}: {} Gaussians that are not finite are left out",
                                   container.path().string(), unsound));
  return model;
}

}  // namespace tessera
