// What: the arrays of a checkpoint, straight between a state and its file.
// Not: when it is written (tools/session/train_session.cpp).
#include "recon4d/model/checkpoint.h"

#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/math/environment.h"
#include "recon4d/model/checkpoint_file.h"
#include "recon4d/model/checkpoint_header.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Calls visit(buffer, scalars) for every array of a state, in file order.
template <class State, class Visit>
void for_each_array(State& state, const CheckpointParts& parts, Visit&& visit) {
  const auto visit_set = [&](auto& set, auto& statistics) {
    for (int g = 0; g < set.groups(); ++g) {
      const int64_t scalars = set.scalars(Group(g));
      auto& group = set.group(Group(g));
      visit(group.value, scalars);
      visit(group.moment1, moment_buffers(Group(g)) > 0 ? scalars : 0);
      visit(group.moment2, moment_buffers(Group(g)) > 1 ? scalars : 0);
    }
    visit(statistics.gradient_sum, set.count());
    visit(statistics.count, set.count());
    if (parts.filter_sizes) visit(statistics.filter_size, set.count());
  };
  visit_set(state.model.static_set, state.statistics[0]);
  visit_set(state.model.dynamic_set, state.statistics[1]);
  auto& map = state.model.environment.map;
  const int64_t texels = environment_scalars(state.model.environment.height);
  visit(map.value, texels);
  visit(map.moment1, texels);
  visit(map.moment2, texels);
  for (auto* const buffer :
       {&state.exposure.value, &state.exposure.moment1, &state.exposure.moment2})
    visit(*buffer, parts.exposure_width * parts.exposures);
  visit(state.exposure.steps, parts.exposures);
  auto& nodes = state.model.nodes;
  visit(nodes.position, 3 * nodes.count);
  const int64_t scalars[] = {nodes.count, 3 * nodes.count * nodes.knots,
                             4 * nodes.count * nodes.knots};
  for (size_t g = 0; g < std::size(scalars); ++g) {
    auto& group = *nodes.groups()[g];
    for (auto* const buffer : {&group.value, &group.moment1, &group.moment2})
      visit(*buffer, scalars[g]);
  }
}

}  // namespace

void save_checkpoint(const std::filesystem::path& path, const TrainState& state,
                     const TrainOptions& options, const std::string& provenance,
                     const ValidationRecord& validation) {
  CheckpointWriter file(path, checkpoint_header(state, options, provenance, validation).dump());
  for_each_array(state, parts_of(state), [&](const auto& buffer, int64_t scalars) {
    check(buffer.size() == scalars, "checkpoint: array of unexpected length");
    check(&buffer.memory() == &host_memory(), "checkpoint: of a state on a device");
    file.write(buffer.data(), sizeof(buffer[0]) * size_t(scalars));
  });
  file.commit();
}

Checkpoint load_checkpoint(const std::filesystem::path& path) {
  CheckpointReader file(path);
  const json header = parse_checkpoint_header(file);
  Checkpoint checkpoint = restored_without_arrays(file, header);
  for_each_array(checkpoint.state, parts_of(header), [&](auto& buffer, int64_t scalars) {
    buffer.resize(scalars);
    file.read(buffer.data(), sizeof(buffer[0]) * size_t(scalars));
  });
  file.check_sum();
  return checkpoint;
}

json read_checkpoint_header(const std::filesystem::path& path) {
  return parse_checkpoint_header(CheckpointReader(path));
}

}  // namespace tessera
