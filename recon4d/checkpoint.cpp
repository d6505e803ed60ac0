// What: the checkpoint's bytes.
// Not: when it is written (tools/train_session.cpp).
#include "recon4d/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"
#include "kernels/math/environment.h"
#include "recon4d/train_options_json.h"

namespace tessera {
namespace {

using nlohmann::json;
constexpr char kMagic[8] = {'T', 'E', 'S', 'S', 'C', 'K', 'P', 'T'};
constexpr uint32_t kVersion = 3;
constexpr size_t kScalar = 4;             // bytes, of float32 and int32
constexpr int64_t kExposureScalars = 10;  // of a row
constexpr size_t kPreamble = sizeof(kMagic) + sizeof(uint32_t) + sizeof(uint64_t);

/// Calls visit(name, buffer, scalars) for every array of a state, in file order.
template <class State, class Visit>
void for_each_array(State& state, bool filter_sizes, bool anchor, int64_t exposures,
                    Visit&& visit) {
  const auto visit_set = [&](auto& set, auto& statistics, const std::string& name) {
    for (int g = 0; g < set.groups(); ++g) {
      const std::string key = name + "." + group_name(Group(g), set.form());
      const int64_t scalars = set.scalars(Group(g));
      auto& group = set.group(Group(g));
      visit(key, group.value, scalars);
      visit(key + ".moment1", group.moment1, scalars);
      visit(key + ".moment2", group.moment2, scalars);
    }
    visit(name + ".gradient_sum", statistics.gradient_sum, set.count());
    visit(name + ".gradient_count", statistics.count, set.count());
    visit(name + ".sh_step", statistics.sh_step, set.count());
    if (filter_sizes) visit(name + ".filter_size", statistics.filter_size, set.count());
  };
  visit_set(state.model.static_set, state.statistics[0], "static");
  visit_set(state.model.dynamic_set, state.statistics[1], "dynamic");
  if (anchor)
    visit("dynamic.anchor", state.statistics[1].anchor, 3 * state.model.dynamic_set.count());
  auto& map = state.model.environment.map;
  const int64_t texels = environment_scalars(state.model.environment.height);
  visit("environment.map", map.value, texels);
  visit("environment.map.moment1", map.moment1, texels);
  visit("environment.map.moment2", map.moment2, texels);
  visit("exposure.log_gain", state.exposure.log_gain, 3 * exposures);
  visit("exposure.moment1", state.exposure.moment1, 3 * exposures);
  visit("exposure.moment2", state.exposure.moment2, 3 * exposures);
  visit("exposure.steps", state.exposure.steps, exposures);
}

/// Rows by SH degree of a set in the header; absent where they are alike, as in earlier files.
ShBlocks blocks_in(const json& header, const char* set) {
  ShBlocks blocks;
  const auto all = header.find("sh_blocks");
  if (all == header.end()) return blocks;
  const auto rows = all->at(set).get<std::array<int64_t, kMaxShDegree + 1>>();
  std::copy(rows.begin(), rows.end(), blocks.rows);
  return blocks;
}

json make_header(const TrainState& state, const TrainOptions& options,
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
      {"motion_form", model.dynamic_set.form() == Form::kVelocity ? "velocity" : "pair"},
      {"sh_coefficients", model.static_set.coefficients()},
      {"sh_degree", model.sh_degree},
      {"sh_time",
       {{"degree", model.sh_time_degree},
        {"levels", model.dynamic_set.time_levels()},
        {"period", model.sh_time_period}}},
      {"time_axis", {{"origin", model.time_axis.origin}, {"duration", model.time_axis.duration}}},
      {"prepared_from_source", similarity_numbers(model.prepared_from_source)},
      {"background", model.background},
      {"near_plane", model.near_plane},
      {"far_plane", model.far_plane},
      {"sliced_direction", model.sliced_direction},
      {"truncation_sigma", model.truncation_sigma},
      {"truncation_by_falloff", model.truncation_by_falloff},
      {"filter_2d", model.filter_2d},
      {"time_filter", model.time_filter},
      {"train_scale", model.train_scale},
      {"filter_sizes", state.has_filter_sizes()},
      {"anchor", state.has_anchor()},
      {"exposures", state.exposure.rows()},
      {"environment_height", model.environment.height},
      {"options", to_json(options)},
      {"provenance", provenance.empty() ? json::object() : json::parse(provenance)},
      {"validation", to_json(validation)}};
  if (state.has_blocks())
    header["sh_blocks"] = {{"static", model.static_set.blocks().rows},
                           {"dynamic", model.dynamic_set.blocks().rows}};
  return header;
}

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
  throw CheckpointRefused(fmt::format("{}: {}", path.string(), why));
}

bool holds_filter_sizes(const json& header) {
  return header.value("filter_sizes", false);
}

/// Levels of time of the dynamic set; earlier files have none.
json sh_time_of(const json& header) {
  const auto stored = header.find("sh_time");
  return stored != header.end() ? *stored : json{{"degree", 0}, {"levels", 0}, {"period", 1.0}};
}

bool holds_anchor(const json& header) {
  return header.value("anchor", false);
}

int64_t exposures_in(const json& header) {
  return header.value("exposures", int64_t{0});
}

int64_t environment_in(const json& header) {
  return header.value("environment_height", int64_t{0});
}

struct Parsed {
  json header;
  size_t arrays;  // offset of the first array
};

Parsed parse_header(const std::filesystem::path& path, const std::string& bytes) {
  if (bytes.size() < kPreamble || std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) != 0)
    refuse(path, "not a Tessera checkpoint (the file does not begin with TESSCKPT)");
  uint32_t version = 0;
  uint64_t length = 0;
  std::memcpy(&version, bytes.data() + sizeof(kMagic), sizeof(version));
  std::memcpy(&length, bytes.data() + sizeof(kMagic) + sizeof(version), sizeof(length));
  if (version != kVersion)
    refuse(path, fmt::format("checkpoint version {}, this program reads version {}; resume it "
                             "with the version that wrote it",
                             version, kVersion));
  if (length > bytes.size() - kPreamble) refuse(path, "truncated checkpoint: header incomplete");
  json header = json::parse(bytes.substr(kPreamble, length), nullptr, false);
  if (header.is_discarded()) refuse(path, "damaged checkpoint: its header is not JSON");
  return {std::move(header), kPreamble + size_t(length)};
}

Form dynamic_form(const json& header) {
  return header.at("motion_form") == "velocity" ? Form::kVelocity : Form::kPair;
}

void restore_header(const json& header, Checkpoint& checkpoint) {
  TrainState& state = checkpoint.state;
  GaussianModel& model = state.model;
  state.iteration = header.at("iteration"), state.finished = header.at("finished");
  state.seconds = header.at("seconds");
  state.decided = header.value("decided", int64_t{0});  // absent: older file
  state.goal = header.value("goal", int64_t{0});
  state.sampler_epoch = header.at("sampler").at("epoch");
  state.sampler_position = header.at("sampler").at("position");
  const int coefficients = header.at("sh_coefficients");
  model.static_set = GaussianSet(Form::kStatic, coefficients);
  const json sh_time = sh_time_of(header);
  model.dynamic_set =
      GaussianSet(dynamic_form(header), coefficients, host_memory(), sh_time.at("levels"));
  model.sh_time_degree = sh_time.at("degree"), model.sh_time_period = sh_time.at("period");
  model.environment.height = int(environment_in(header));
  model.sh_degree = header.at("sh_degree");
  model.time_axis = {header.at("time_axis").at("origin"), header.at("time_axis").at("duration")};
  if (const auto world = header.find("prepared_from_source"); world != header.end())
    model.prepared_from_source = similarity_from_numbers(*world);  // absent: older file
  model.background = header.at("background");
  model.near_plane = header.at("near_plane"), model.far_plane = header.at("far_plane");
  model.sliced_direction = header.at("sliced_direction");
  model.truncation_sigma = header.value("truncation_sigma", kTruncationSigma);  // as above
  model.truncation_by_falloff = header.value("truncation_by_falloff", false);
  model.filter_2d = header.value("filter_2d", false);
  model.time_filter = header.value("time_filter", 0.0);
  model.train_scale = header.value("train_scale", 1.0);
  checkpoint.provenance = header.at("provenance").dump();
  checkpoint.validation = validation_record_from_json(header.at("validation"));
}

TrainOptions restore_options(const std::filesystem::path& path, const json& header) {
  try {
    return train_options_from_json(header.at("options"));
  } catch (const InputError& error) {
    refuse(path, fmt::format("checkpoint of another version: {}", error.what()));
  }
}

/// Whether blocks are of so many rows, with at most so many coefficients each.
bool blocks_fit(const ShBlocks& blocks, int64_t count, int coefficients) {
  int64_t left = count;  // no sum that overflows
  for (int degree = 0; degree <= kMaxShDegree; ++degree) {
    const int64_t rows = blocks.rows[degree];
    if (rows < 0 || rows > left) return false;
    if (rows > 0 && sh_coefficients(degree) > coefficients) return false;
    left -= rows;
  }
  return left == 0 || left == count;
}

/// Numbers of the header against each other and the size of the file, before any memory is taken.
void check_header(const std::filesystem::path& path, const json& header, size_t arrays,
                  size_t size) {
  const int64_t statics = header.at("num_static"), dynamics = header.at("num_dynamic");
  const json sh_time = sh_time_of(header);
  const int coefficients = header.at("sh_coefficients"), levels = sh_time.at("levels");
  // values and two moments each; statistics and sh_step, filter size where kept, four bytes like
  // all
  const auto scalars = [&](Form form, int64_t count, const ShBlocks& blocks) {
    const int sets = form == Form::kStatic ? 1 : 1 + levels;
    const int64_t all = blocks.mixed() ? blocks.coefficients() : count * coefficients;
    return count * (int64_t{3} * geometry_scalars(form) + 3 + holds_filter_sizes(header)) +
           9 * all * sets;
  };
  const ShBlocks of_static = blocks_in(header, "static"), of_dynamic = blocks_in(header, "dynamic");
  constexpr int64_t kMost = int64_t{1} << 40;
  const auto within = [](int64_t value, int64_t low, int64_t high) {
    return value >= low && value <= high;
  };
  const json& sampler = header.at("sampler");
  if (!within(statics, 0, kMost) || !within(dynamics, 0, kMost) ||
      !within(exposures_in(header), 0, kMost) ||
      !within(environment_in(header), 0, int64_t{1} << 16) ||
      !within(coefficients, 1, kMaxShCoefficients) ||
      !blocks_fit(of_static, statics, coefficients) ||
      !blocks_fit(of_dynamic, dynamics, coefficients) ||
      !within(header.at("sh_degree"), 0, kMaxShDegree) || !within(levels, 0, kMaxTimeLevels) ||
      !within(sh_time.at("degree"), 0, kMaxTimeLevels) || !(sh_time.at("period") > 0.0) ||
      !within(header.at("iteration"), 0, kMost) || !within(sampler.at("epoch"), 0, kMost) ||
      !within(sampler.at("position"), 0, kMost))
    refuse(path, "damaged checkpoint: impossible numbers in its header");
  const size_t expected = arrays + sizeof(uint64_t) +
                          kScalar * size_t(scalars(Form::kStatic, statics, of_static) +
                                           scalars(dynamic_form(header), dynamics, of_dynamic) +
                                           3 * dynamics * holds_anchor(header) +
                                           kExposureScalars * exposures_in(header) +
                                           3 * environment_scalars(environment_in(header)));
  if (size != expected)
    refuse(path,
           fmt::format("truncated checkpoint: {} bytes, its header promises {}", size, expected));
}

void check_sum(const std::filesystem::path& path, const std::string& bytes) {
  const size_t summed = bytes.size() - sizeof(uint64_t);
  Fnv1a hash;
  hash.add(bytes.data(), summed);
  const uint64_t sum = hash.value();
  if (std::memcmp(bytes.data() + summed, &sum, sizeof(sum)) != 0)
    refuse(path, "damaged checkpoint: its checksum does not match");
}

}  // namespace

void save_checkpoint(const std::filesystem::path& path, const TrainState& state,
                     const TrainOptions& options, const std::string& provenance,
                     const ValidationRecord& validation) {
  AtomicFile file(path);
  Fnv1a hash;
  const auto write = [&](const void* bytes, size_t count) {
    hash.add(bytes, count);
    file.write(bytes, count);
  };
  const std::string header = make_header(state, options, provenance, validation).dump();
  const uint64_t length = header.size();
  write(kMagic, sizeof(kMagic));
  write(&kVersion, sizeof(kVersion));
  write(&length, sizeof(length));
  write(header.data(), header.size());
  for_each_array(state, state.has_filter_sizes(), state.has_anchor(), state.exposure.rows(),
                 [&](const std::string&, const auto& buffer, int64_t scalars) {
                   check(buffer.size() == scalars, "checkpoint: array of unexpected length");
                   check(&buffer.memory() == &host_memory(), "checkpoint: of a state on a device");
                   write(buffer.data(), kScalar * size_t(scalars));
                 });
  const uint64_t sum = hash.value();
  file.write(&sum, sizeof(sum));
  file.commit();
}

Checkpoint load_checkpoint(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  const Parsed parsed = parse_header(path, bytes);
  Checkpoint checkpoint;
  try {
    check_header(path, parsed.header, parsed.arrays, bytes.size());
    check_sum(path, bytes);
    restore_header(parsed.header, checkpoint);
    checkpoint.options = restore_options(path, parsed.header);
  } catch (const json::exception& error) {
    refuse(path, fmt::format("damaged checkpoint: {}", error.what()));
  }
  TrainState& state = checkpoint.state;
  state.model.static_set.resize(parsed.header.at("num_static"), blocks_in(parsed.header, "static"));
  state.model.dynamic_set.resize(parsed.header.at("num_dynamic"),
                                 blocks_in(parsed.header, "dynamic"));
  const char* from = bytes.data() + parsed.arrays;
  const bool filter_sizes = holds_filter_sizes(parsed.header);
  for_each_array(state, filter_sizes, holds_anchor(parsed.header), exposures_in(parsed.header),
                 [&](const std::string&, auto& buffer, int64_t scalars) {
                   buffer.resize(scalars);
                   if (scalars > 0) std::memcpy(buffer.data(), from, kScalar * size_t(scalars));
                   from += kScalar * size_t(scalars);
                 });
  return checkpoint;
}

json read_checkpoint_header(const std::filesystem::path& path) {
  return parse_header(path, read_text_file(path)).header;
}

}  // namespace tessera
