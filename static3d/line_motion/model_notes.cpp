// One list of names, which is written and read.
#include "static3d/line_motion/model_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <type_traits>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr std::string_view kPrefix = "tessera.";

/// visit(name, number) of each; numbers that are changed are taken over.
template <class Visit>
void for_each_note(GaussianModel& model, Visit&& visit) {
  const auto as_double = [&](const std::string& name, auto& value) {
    using Value = std::remove_reference_t<decltype(value)>;
    double number = double(value);
    visit(name, number);
    if (number == double(value)) return;
    if constexpr (std::is_floating_point_v<Value>)
      value = Value(number);
    else
      value = Value(std::clamp(std::round(number), 0.0, 255.0));
  };
  for_each_rule(model.drawing, [&](const std::string& name, auto& rule) {
    if (!name.starts_with("sh_") && name != "time_filter") as_double(name, rule);  // in the lines
  });
  as_double("time_origin", model.time_axis.origin);
  as_double("time_duration", model.time_axis.duration);
  as_double("time_is_stated", model.time_axis.is_stated);
  as_double("train_scale", model.train_scale);
  for (size_t k = 0; k < 3; ++k) as_double(fmt::format("background_{}", k), model.background[k]);
  for (int k = 0; k < 3; ++k)
    as_double(fmt::format("origin_{}", k), model.prepared_from_source.translation[k]);
}

}  // namespace

ModelNotes notes_of(const GaussianModel& model) {
  ModelNotes notes;
  GaussianModel rules;
  rules.drawing = model.drawing;
  rules.time_axis = model.time_axis;
  rules.train_scale = model.train_scale;
  rules.background = model.background;
  if (const Similarity& world = model.prepared_from_source; world.rotation == glm::dmat3(1.0))
    rules.prepared_from_source.translation = world.translation;
  for_each_note(rules, [&](const std::string& name, double number) { notes[name] = number; });
  return notes;
}

void take_notes(const ModelNotes& notes, const std::string& where, GaussianModel& model) {
  for_each_note(model, [&](const std::string& name, double& number) {
    const auto found = notes.find(name);
    if (found != notes.end() && std::isfinite(found->second)) number = found->second;
  });
  std::string wrong = wrong_rule(model.drawing);
  if (wrong.empty() && !(model.time_axis.duration > 0)) wrong = "time_duration is not above 0";
  if (wrong.empty() && !(model.train_scale > 0)) wrong = "train_scale is not above 0";
  if (!wrong.empty()) throw InputError(fmt::format("{}: {}; export it again", where, wrong));
}

std::vector<std::string> comments_of(const ModelNotes& notes) {
  std::vector<std::string> comments;
  for (const auto& [name, number] : notes)
    comments.push_back(fmt::format("{}{} {}", kPrefix, name, number));
  return comments;
}

ModelNotes notes_in(const std::vector<std::string>& comments) {
  ModelNotes notes;
  for (const std::string& comment : comments) {
    const size_t blank = comment.find(' ');
    if (!comment.starts_with(kPrefix) || blank == std::string::npos) continue;
    double number = 0;
    std::from_chars(comment.data() + blank + 1, comment.data() + comment.size(), number);
    notes[comment.substr(kPrefix.size(), blank - kPrefix.size())] = number;
  }
  return notes;
}

ModelNotes notes_in(const nlohmann::json& asset) {
  ModelNotes notes;
  if (!asset.is_object() || !asset.contains("tessera")) return notes;
  for (const auto& [name, value] : asset["tessera"].items())
    if (value.is_number()) notes[name] = value.get<double>();
  return notes;
}

}  // namespace tessera
