// Markdown of the command and preset pages.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "recon4d/options/presets.h"
#include "tools/cli/option_reference.h"
#include "tools/reference/reference.h"

namespace tessera {
namespace {

/// Text inside a cell of a table: on one line, without marks of its own.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '|' || c == '<' || c == '_' || c == '*') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result;
}

std::string code(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return "`" + escaped + "`";
}

std::string names_cell(const OptionReference& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names)
    names.push_back(code(option.placeholder.empty() || !option.choices.empty()
                             ? name
                             : name + " " + option.placeholder));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string choices_text(const OptionReference& option) {
  std::vector<std::string> names;
  for (const std::string& choice : option.choices) names.push_back(code(choice));
  return names.empty() ? "" : fmt::format(" One of {}.", fmt::join(names, ", "));
}

constexpr const char* kMade =
    "<!-- Made by `tessera reference markdown docs/reference`; edit the sources, not this page. "
    "-->\n\n";

std::string page_of_command(const CommandReference& command) {
  std::string arguments, rows;
  bool has_training = false;
  for (const OptionReference& option : command.options) {
    if (option.is_argument)
      arguments += option.required ? " " + option.names.front() : " [" + option.names.front() + "]";
    if (option.row != nullptr) {
      has_training = true;
      continue;
    }
    const std::string required = option.required ? " Required." : "";
    rows += fmt::format("| {} | {}.{}{} | {} |\n", names_cell(option), cell(first_line(option.doc)),
                        choices_text(option), required,
                        option.defaults.empty() ? "" : code(option.defaults));
  }
  std::string text = fmt::format("{}# tessera {}\n\n{}.\n\n```sh\ntessera {}{} [options]\n```\n",
                                 kMade, command.name, command.doc, command.name, arguments);
  if (has_training) text += "\nAll [training options](../training-options.md) apply, too.\n";
  return text + "\n| option | meaning | default |\n|---|---|---|\n" + rows;
}

std::string training_page() {
  std::string text = kMade, group;
  text +=
      "# Training options\n\n"
      "These options apply to `train`, `run` and `batch`, and by their names with underscores in "
      "`--config FILE.json`. Counts take `k` and `M` (`10k`), sizes take `kB`, `MB` and `MiB`, "
      "choices are compared without regard to case. A switch `--x` has the twin `--no-x`.\n\n"
      "The default is that of `balanced`; presets that differ follow after the semicolon.\n";
  for (const TrainOption& row : train_option_table()) {
    if (row.group != group)
      text += fmt::format(
          "\n## {}\n\n| option | meaning | range | default | source |\n|---|---|---|---|---|\n",
          group = row.group);
    const std::string name = "--" + dashed(row.key);
    std::string range = option_range(row);
    if (const auto choices = row.choices(); !choices.empty())
      range = fmt::format("{}", fmt::join(choices, ", "));
    text += fmt::format("| {} | {}. | {} | {} | {} |\n",
                        row.is_switch() ? fmt::format("`{0}`, `--no-{1}`", name, dashed(row.key))
                        : row.choices().empty() ? code(name + " " + option_placeholder(row))
                                                : code(name),
                        cell(row.doc), cell(range), cell(default_text(row)), cell(row.source));
  }
  return text;
}

std::string cli_page(const std::vector<CommandReference>& commands) {
  std::string text = kMade;
  text +=
      "# Commands and options\n\n"
      "Results go to standard output, messages to standard error. `tessera COMMAND --help` shows "
      "what is used often, `--help-all` also the rest and [training options](training-options.md)."
      "\n\n| command | what it does |\n|---|---|\n";
  for (const CommandReference& command : commands)
    text += fmt::format("| [`{0}`](commands/{0}.md) | {1} |\n", command.name, cell(command.doc));
  return text;
}

std::string presets_page() {
  std::string text = kMade;
  text +=
      "# Presets\n\n"
      "A preset sets options; every option can still be given on the command line. Options that a "
      "preset does not list have the value in the last table.\n\n"
      "| preset | use |\n|---|---|\n";
  for (const Preset& preset : presets())
    text += fmt::format("| `{}` | {} |\n", preset.name, cell(preset.doc));
  text +=
      "\nA *rig* is a scene with three or more cameras that film at the same time. Options that "
      "depend on the frame rate are given in frames there.\n\n";
  // of a key that is overridden twice the last value counts
  const auto list = [&](const OptionOverrides& overrides) {
    for (size_t i = 0; i < overrides.size(); ++i) {
      const auto& [key, value] = overrides[i];
      const bool is_last = std::none_of(
          overrides.begin() + long(i) + 1, overrides.end(),
          [&](const auto& later) { return std::string(later.first) == overrides[i].first; });
      if (is_last) text += fmt::format("- `--{}` {}\n", dashed(key), code(plain_text(value)));
    }
  };
  const auto section = [&](const char* title, const auto& overrides) {
    if (overrides.empty()) return;
    text += fmt::format("\n{}:\n\n", title);
    list(overrides);
  };
  for (const Preset& preset : presets()) {
    text += fmt::format("## {}\n\n", preset.name);
    list(preset.overrides);
    section("For a scene with one timestep", preset.still_overrides);
    if (preset.fits_to_views)
      text += fmt::format(
          "\nAnd at most {} steps for each training image; with less than {} of them "
          "`--gaussians-per-pixel` and `--lr-sh-rest` are lower and `--opacity-weight` and "
          "`--scale-weight` higher in proportion.\n",
          kStepsPerView, kManyViews);
    if (!preset.rig_overrides.empty() || preset.rig_rates.extent_frames > 0) {
      text += "\nFor a rig:\n\n";
      list(preset.rig_overrides);
      const FrameRates& rates = preset.rig_rates;
      if (rates.extent_frames > 0)
        text += fmt::format("- initial temporal extent {:g} frames\n", rates.extent_frames);
      if (rates.velocity_rate > 0)
        text += fmt::format("- `--lr-velocity` {:g} scene extents a frame\n", rates.velocity_rate);
      if (rates.mean_time_rate > 0)
        text += fmt::format("- `--lr-mean-time` {:g} frames\n", rates.mean_time_rate);
    }
    section("With one view a timestep", preset.single_view_overrides);
    section("Where motion nodes carry the scene", preset.node_overrides);
    if (preset.fits_to_views && !preset.node_overrides.empty())
      text += fmt::format(
          "\nAnd at most {} steps for each training image; with less than {} of them "
          "`--lr-sh-rest` is lower in proportion.\n",
          kStepsPerView, kManyViews);
    if (preset.fits_to_cameras)
      text += fmt::format(
          "\nFor N training cameras that film at once: during growth at most one Gaussian per {}/N "
          "of their pixels, {} for {} or fewer. Of a rig: at most {} steps for each camera; with "
          "less than {} cameras `--clear-distance -1`; with less than {} cameras `--lr-sh-rest` is "
          "lower in proportion; `--opacity-weight` and "
          "`--scale-weight` {:g}/N; with images of less than {:g} pixels `--static-threshold` is "
          "higher as their sides are shorter.\n",
          kFewCameras * kPixelsOfFewCameras, kPixelsOfFewCameras, kFewCameras, kStepsPerCamera,
          kEnoughCameras, kManyCameras, kRigWeight, kThresholdPixels);
    text += "\n";
  }
  text += "## Without a preset's value\n\n| option | value |\n|---|---|\n";
  const TrainOptions defaults;
  for (const TrainOption& row : train_option_table())
    text += fmt::format("| `--{}` | {} |\n", dashed(row.key),
                        code(plain_text(option_value(defaults, row))));
  return text;
}

}  // namespace

ReferencePages markdown_pages(const std::vector<CommandReference>& commands) {
  ReferencePages pages = {{"cli.md", cli_page(commands)},
                          {"training-options.md", training_page()},
                          {"presets.md", presets_page()}};
  for (const CommandReference& command : commands)
    pages["commands/" + command.name + ".md"] = page_of_command(command);
  return pages;
}

}  // namespace tessera
