// Arrays and JSON header of a checkpoint, from a state to its file and back. The numbers of a
// header are checked against each other and against the size of the file before memory is
// allocated.
#include "recon4d/model/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/math/environment.h"
#include "recon4d/model/checkpoint_file.h"
#include "recon4d/model/clocks.h"
#include "recon4d/options/train_options_json.h"

namespace tessera {
namespace {

using nlohmann::json;

/// Of the arrays that not every state has.
struct CheckpointParts {
  bool filter_sizes;
  int64_t exposures;       // rows
  int64_t exposure_width;  // numbers of a row
  int64_t clocks;          // rows
  int64_t averaged;        // states of which the mean of the parameters is; 0: there is none
};

CheckpointParts parts_of(const TrainState& state) {
  return {state.has_filter_sizes(), state.exposure.rows(), state.exposure.width(),
          state.clocks.rows(), state.average.states};
}

CheckpointParts parts_of(const json& header) {
  const bool affine = header.at("options").value("exposure", "") == name_of(ExposureGains::kAffine);
  return {header.at("filter_sizes"), header.at("exposures"),
          exposure_width(affine ? ExposureGains::kAffine : ExposureGains::kCamera),
          header.value("clocks", int64_t{0}), header.value("averaged_states", int64_t{0})};
}

/// Elements by SH degree of a set in the header; absent where they are alike.
ShBlocks blocks_in(const json& header, const char* set) {
  ShBlocks blocks;
  const auto all = header.find("sh_blocks");
  if (all == header.end()) return blocks;
  const auto elements = all->at(set).get<std::array<int64_t, kMaxShDegree + 1>>();
  std::copy(elements.begin(), elements.end(), blocks.elements);
  return blocks;
}

SetForm dynamic_form(const json& header) {
  return header.at("motion_form") == dynamic_form_name(SetForm::kVelocity) ? SetForm::kVelocity
                                                                           : SetForm::kPair;
}

/// Of a canonical set; absent where there are none.
NodeCounts node_counts(const json& header) {
  const auto found = header.find("motion_nodes");
  if (found == header.end()) return {};
  const int64_t knots = found->at("knots");
  return {found->at("count"), int(std::clamp<int64_t>(knots, -1, kMaxKnots + 1)),
          found->at("started"), found->at("refitted")};
}

void restore_sets(const json& header, GaussianModel& model) {
  const int coefficients = header.at("sh_coefficients");
  static_cast<NodeCounts&>(model.nodes) = node_counts(header);
  const SetForm form = model.nodes.empty() ? SetForm::kStatic : SetForm::kCanonical;
  model.static_set = GaussianSet(form, coefficients);
  model.static_set.declare(header.at("num_static"), blocks_in(header, "static"));
  model.dynamic_set =
      GaussianSet(dynamic_form(header), coefficients, host_memory(), header.at("sh_time_levels"));
  model.dynamic_set.declare(header.at("num_dynamic"), blocks_in(header, "dynamic"));
  model.environment.height = header.at("environment_height");
}

void restore_model(const json& header, GaussianModel& model) {
  const json &time_axis = header.at("time_axis"), &drawing = header.at("drawing");
  for_each_rule(model.drawing,
                [&](const char* name, auto& rule) { drawing.at(name).get_to(rule); });
  model.time_axis = {time_axis.at("origin"), time_axis.at("duration")};
  model.prepared_from_source = similarity_from_numbers(header.at("prepared_from_source"));
  model.background = header.at("background");
  model.train_scale = header.at("train_scale");
}

json drawing_json(const DrawingRules& rules) {
  json object;
  for_each_rule(rules, [&](const char* name, const auto& rule) { object[name] = rule; });
  return object;
}

void restore_progress(const json& header, TrainState& state) {
  state.iteration = header.at("iteration");
  state.finished = header.at("finished");
  state.seconds = header.at("seconds");
  state.decided = header.at("decided");
  state.goal = header.at("goal");
  state.static_is_frozen = header.value("static_is_frozen", false);
  state.average.states = parts_of(header).averaged;
  state.sampler_epoch = header.at("sampler").at("epoch");
  state.sampler_position = header.at("sampler").at("position");
}

TrainOptions restore_options(const std::filesystem::path& path, const json& header) {
  try {
    return train_options_from_json(header.at("options"));
  } catch (const InputError& error) {
    refuse_checkpoint(path, fmt::format("checkpoint of another version: {}", error.what()));
  }
}

/// Whether blocks are of so many elements, with at most so many coefficients each.
bool blocks_fit(const ShBlocks& blocks, int64_t count, int coefficients) {
  int64_t left = count;  // no sum that overflows
  for (int degree = 0; degree <= kMaxShDegree; ++degree) {
    const int64_t elements = blocks.elements[degree];
    if (elements < 0 || elements > left) return false;
    if (elements > 0 && sh_coefficients(degree) > coefficients) return false;
    left -= elements;
  }
  return left == 0 || left == count;
}

/// Numbers of the header against each other.
void check_header(const CheckpointReader& file, const json& header) {
  const int64_t statics = header.at("num_static"), dynamics = header.at("num_dynamic");
  const json& sampler = header.at("sampler");
  const CheckpointParts parts = parts_of(header);
  const int64_t environment = header.at("environment_height");
  const int coefficients = header.at("sh_coefficients"), levels = header.at("sh_time_levels");
  const NodeCounts nodes = node_counts(header);
  constexpr int64_t kMost = int64_t{1} << 40;
  const auto within = [](int64_t value, int64_t low, int64_t high) {
    return value >= low && value <= high;
  };
  if (!within(statics, 0, kMost) || !within(dynamics, 0, kMost) ||
      !within(nodes.count, 0, kMaxNodes) || !within(nodes.started, 0, kMost) ||
      !within(nodes.refitted, 0, kMost) ||
      !within(nodes.knots, nodes.count > 0 ? kSplineOrder : 0, kMaxKnots) ||
      !within(parts.exposures, 0, kMost) || !within(parts.clocks, 0, kMost) ||
      !within(parts.averaged, 0, kMost) || !within(environment, 0, int64_t{1} << 16) ||
      !within(coefficients, 1, kMaxShCoefficients) ||
      !blocks_fit(blocks_in(header, "static"), statics, coefficients) ||
      !blocks_fit(blocks_in(header, "dynamic"), dynamics, coefficients) ||
      !within(levels, 0, kMaxTimeLevels) || !within(header.at("iteration"), 0, kMost) ||
      !within(sampler.at("epoch"), 0, kMost) || !within(sampler.at("position"), 0, kMost))
    refuse_checkpoint(file.path(), "damaged checkpoint: impossible numbers in its header");
}

json checkpoint_header(const TrainState& state, const TrainOptions& options,
                       const std::string& provenance, const ValidationRecord& validation) {
  const GaussianModel& model = state.model;
  json header = {
      {"iteration", state.iteration},
      {"finished", state.finished},
      {"seconds", state.seconds},
      {"decided", state.decided},
      {"goal", state.goal},
      {"sampler", {{"epoch", state.sampler_epoch}, {"position", state.sampler_position}}},
      {"num_static", model.static_set.count()},
      {"num_dynamic", model.dynamic_set.count()},
      {"motion_form", dynamic_form_name(model.dynamic_set.form())},
      {"sh_coefficients", model.static_set.coefficients()},
      {"sh_time_levels", model.dynamic_set.time_levels()},
      {"drawing", drawing_json(model.drawing)},
      {"time_axis", {{"origin", model.time_axis.origin}, {"duration", model.time_axis.duration}}},
      {"prepared_from_source", similarity_numbers(model.prepared_from_source)},
      {"background", model.background},
      {"train_scale", model.train_scale},
      {"filter_sizes", state.has_filter_sizes()},
      {"exposures", state.exposure.rows()},
      {"environment_height", model.environment.height},
      {"options", to_json(options)},
      {"provenance", provenance.empty() ? json::object() : json::parse(provenance)},
      {"validation", to_json(validation)}};
  if (const MotionNodes& nodes = model.nodes; !nodes.empty())
    header["motion_nodes"] = {{"count", nodes.count},
                              {"knots", nodes.knots},
                              {"started", nodes.started},
                              {"refitted", nodes.refitted}};
  if (state.static_is_frozen) header["static_is_frozen"] = true;
  if (state.clocks.rows() > 0) header["clocks"] = state.clocks.rows();
  if (state.average.states > 0) header["averaged_states"] = state.average.states;
  if (state.has_blocks())
    header["sh_blocks"] = {{"static", model.static_set.blocks().elements},
                           {"dynamic", model.dynamic_set.blocks().elements}};
  return header;
}

/// The header of an opened checkpoint. Errors: CheckpointRefused: not JSON.
json parse_checkpoint_header(const CheckpointReader& file) {
  json header = json::parse(file.header(), nullptr, false);
  if (header.is_discarded())
    refuse_checkpoint(file.path(), "damaged checkpoint: its header is not JSON");
  return header;
}

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
  const auto visit_rows = [&](auto& learnt, int64_t rows, int64_t width) {
    for (auto* const buffer : {&learnt.value, &learnt.moment1, &learnt.moment2})
      visit(*buffer, width * rows);
    visit(learnt.steps, rows);
  };
  visit_rows(state.exposure, parts.exposures, parts.exposure_width);
  visit_rows(state.clocks, parts.clocks, kClockWidth);
  auto& nodes = state.model.nodes;
  visit(nodes.position, 3 * nodes.count);
  for (size_t g = 0; g < nodes.groups().size(); ++g) {
    auto& group = *nodes.groups()[g];
    for (auto* const buffer : {&group.value, &group.moment1, &group.moment2})
      visit(*buffer, nodes.scalars()[g]);
  }
  size_t mean = 0;
  const auto visit_mean = [&](int64_t scalars) {
    if (mean < state.average.means.size()) visit(state.average.means[mean++], scalars);
  };
  for (int k = state.trains(0) ? 0 : 1; k < 2; ++k)
    for (int g = 0; g < state.set(k).groups(); ++g) visit_mean(state.set(k).scalars(Group(g)));
  for (const int64_t scalars : nodes.scalars()) visit_mean(scalars);
}

/// Whether the file has the bytes that a state has which its header describes.
void check_size(const CheckpointReader& file, const TrainState& state,
                const CheckpointParts& parts) {
  uint64_t promised = 0;
  for_each_array(state, parts, [&](const auto& buffer, int64_t scalars) {
    promised += sizeof(buffer[0]) * uint64_t(scalars);
  });
  if (file.array_bytes() != promised)
    refuse_checkpoint(file.path(),
                      fmt::format("truncated checkpoint: {} bytes, its header promises {}",
                                  file.bytes(), file.bytes() - file.array_bytes() + promised));
}

/// A checkpoint without its arrays. Its numbers are held against each other and the size of the
/// file before any memory is taken. Errors: as refuse_checkpoint.
Checkpoint restored_without_arrays(const CheckpointReader& file, const json& header) {
  Checkpoint checkpoint;
  try {
    check_header(file, header);
    checkpoint.options = restore_options(file.path(), header);
    checkpoint.provenance = header.at("provenance").dump();
    checkpoint.validation = validation_record_from_json(header.at("validation"));
    restore_progress(header, checkpoint.state);
    restore_model(header, checkpoint.state.model);
    if (const std::string wrong = wrong_rule(checkpoint.state.model.drawing); !wrong.empty())
      refuse_checkpoint(file.path(), fmt::format("damaged checkpoint: {}", wrong));
    restore_sets(header, checkpoint.state.model);
    if (checkpoint.state.average.states > 0)
      checkpoint.state.average.means.resize(averaged_groups(checkpoint.state).size());
    check_size(file, checkpoint.state, parts_of(header));
  } catch (const json::exception& error) {
    refuse_checkpoint(file.path(), fmt::format("damaged checkpoint: {}", error.what()));
  }
  return checkpoint;
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
