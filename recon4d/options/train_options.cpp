// Sets options by name with the checks of their table, checks conditions between options, and
// converts options to switches of kernels.
#include "recon4d/options/train_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"
#include "kernels/math/sort_keys.h"
#include "recon4d/options/nearest_name.h"
#include "recon4d/options/option_rows.h"

namespace tessera {
namespace {

using O = TrainOptions;

const TrainOption& option_of(const std::string& key) {
  std::vector<std::string> keys;
  for (const TrainOption& option : train_option_table()) {
    if (key == option.key) return option;
    keys.push_back(option.key);
  }
  throw InputError(fmt::format("unknown option '{}'{}", key, did_you_mean(key, keys)));
}

double checked(const TrainOption& option, double value) {
  if (!(value >= option.low && value <= option.high))
    throw InputError(fmt::format("option '{}' is {}, expected {} to {}: {}", option.key, value,
                                 option.low, option.high, option.doc));
  return value;
}

struct Setter {
  TrainOptions& options;
  const TrainOption& option;
  const OptionValue& value;

  [[noreturn]] void refuse(const char* expected) const {
    throw InputError(fmt::format("option '{}' is {}, expected {}: {}", option.key,
                                 quoted_text(value), expected, option.doc));
  }
  void operator()(int64_t O::*member) const { options.*member = whole_number(); }
  void operator()(int O::*member) const { options.*member = int(whole_number()); }
  int64_t whole_number() const {
    if (const auto* whole = std::get_if<int64_t>(&value)) {
      checked(option, double(*whole));
      return *whole;
    }
    const auto* number = std::get_if<double>(&value);  // 3e4
    if (!number || !(std::abs(*number) < 1e15) || *number != std::floor(*number))
      refuse("a whole number");
    return int64_t(checked(option, *number));  // in range, so that it fits
  }
  void operator()(double O::*member) const {
    if (const auto* whole = std::get_if<int64_t>(&value))
      options.*member = checked(option, double(*whole));
    else if (const auto* number = std::get_if<double>(&value))
      options.*member = checked(option, *number);
    else
      refuse("a number");
  }
  void operator()(bool O::*member) const {
    if (!std::holds_alternative<bool>(value)) refuse("true or false");
    options.*member = std::get<bool>(value);
  }
  void operator()(std::string O::*member) const {
    if (!std::holds_alternative<std::string>(value)) refuse("text");
    options.*member = std::get<std::string>(value);
  }
  void operator()(const ChoiceMember& member) const {
    if (!std::holds_alternative<std::string>(value)) refuse("text");
    const std::string& text = std::get<std::string>(value);
    const std::vector<std::string> names(member.names.begin(), member.names.end());
    const auto found = std::find(names.begin(), names.end(), lower_case(text));
    if (found == names.end())
      throw InputError(fmt::format("option '{}' is '{}'{}: {}", option.key, text,
                                   known_names(text, names), option.doc));
    member.set(options, size_t(found - names.begin()));
  }
};

void check_times(const TrainOptions& options) {
  const bool clocks = options.clocks == Clocks::kLearn;
  if (!clocks && !options.learn_readouts) return;
  const char* const off = clocks ? "--clocks fixed" : "--no-learn-readouts";
  if (options.motion == Motion::kNodes)
    throw InputError(
        fmt::format("motion nodes know no gradient by time; pass {} or another --motion", off));
  if (options.validation_share > 0)
    throw InputError(
        fmt::format("validation views keep the times that the scene states; pass {} or "
                    "--validation-share 0",
                    off));
}

/// What is never drawn has no gradient: Gaussians must not start, nor be reset, below the cut-off.
void check_truncation(const TrainOptions& options) {
  constexpr double kResetOpacity = 0.01;  // reset_opacity
  const double least = make_cutoff<double>(options).least_alpha;
  const bool starts = least < options.init_opacity;
  if (starts && !(options.opacity_reset_interval > 0 && least >= kResetOpacity)) return;
  throw InputError(
      fmt::format("truncation_sigma {} draws no opacity below {:.4f}, but Gaussians {} {}; pass "
                  "--truncation-by-falloff true or a larger --truncation-sigma",
                  options.truncation_sigma, least, starts ? "are reset to" : "start with",
                  starts ? kResetOpacity : options.init_opacity));
}

/// Of a unit that was left out. What a scene's file takes is known later.
void check_bytes(int64_t max_bytes) {
  constexpr int64_t kLeast = 500;  // less than the manifest of any model
  if (max_bytes == 0 || max_bytes >= kLeast) return;
  throw InputError(fmt::format("--max-bytes {0}: {0} bytes hold no model; {0}MB?", max_bytes));
}

}  // namespace

void set_option(TrainOptions& options, const std::string& key, const OptionValue& value) {
  const TrainOption& option = option_of(key);
  std::visit(Setter{options, option, value}, option.member);
}

void set_option_from_text(TrainOptions& options, const std::string& key, const std::string& text) {
  const TrainOption& option = option_of(key);
  if (std::holds_alternative<std::string O::*>(option.member) || !option.choices().empty())
    return set_option(options, key, text);
  const OptionValue value = option_value_from_text(text);
  if (option.unit != Unit::kNone && std::holds_alternative<std::string>(value)) {
    const std::optional<double> number = parse_quantity(text, option.unit);
    if (!number) Setter{options, option, value}.refuse(quantity_example(option.unit));
    return set_option(options, key, *number);
  }
  const bool is_share = std::holds_alternative<double O::*>(option.member) && text.ends_with('%');
  const auto percent =
      is_share ? parse_quantity(text.substr(0, text.size() - 1), Unit::kNone) : std::nullopt;
  if (percent) return set_option(options, key, *percent / 100);
  set_option(options, key, value);
}

OptionValue option_value(const TrainOptions& options, const TrainOption& option) {
  if (const auto* choice = std::get_if<ChoiceMember>(&option.member))
    return std::string(choice->names[choice->get(options)]);
  return std::visit(
      [&](const auto& member) -> OptionValue {
        if constexpr (std::is_member_pointer_v<std::decay_t<decltype(member)>>)
          return options.*member;
        else
          return {};
      },
      option.member);
}

std::vector<const char*> TrainOption::choices() const {
  const auto* choice = std::get_if<ChoiceMember>(&member);
  return choice == nullptr ? std::vector<const char*>{} : choice->names;
}

int64_t growth_limit(const TrainOptions& options) {
  if (options.peak_gaussians == 0) return options.max_gaussians;
  return std::max(options.peak_gaussians, options.max_gaussians);
}

bool grows_with(const TrainOptions& options, GrowthPart part) {
  return options.densification == Densification::kBudget && options.budget_without != part;
}

bool prunes_after_growth(const TrainOptions& options) {
  if (options.max_bytes > 0 || options.within_db > 0 || options.size == ModelSize::kKnee)
    return true;
  return options.max_gaussians > 0 && growth_limit(options) > options.max_gaussians;
}

void validate(const TrainOptions& options) {
  if (options.near_plane >= options.far_plane)
    throw InputError(fmt::format("near_plane {} must be smaller than far_plane {}",
                                 options.near_plane, options.far_plane));
  if (options.near_plane > 0 && options.far_plane > options.near_plane * kDepthRange)
    throw InputError(
        fmt::format("far_plane {} is more than 2^32 times near_plane {}, beyond which depths are "
                    "not told apart; pass a larger --near-plane or a smaller --far-plane",
                    options.far_plane, options.near_plane));
  parse_background(options.background);
  check_truncation(options);
  if (!options.fused_optimizer && options.idle_updates != IdleUpdate::kDense)
    throw InputError(fmt::format(
        "idle_updates {} needs the fused optimizer; pass --fused-optimizer true or --idle-updates "
        "dense",
        name_of(options.idle_updates)));
  if (options.motion == Motion::kNodes && options.filter_3d != Filter3d::kNone)
    throw InputError(
        "filter_3d does not reckon with motion nodes; pass --filter-3d none or another --motion");
  check_times(options);
  const int contracts =
      (options.max_gaussians > 0) + (options.max_bytes > 0) + (options.within_db > 0);
  if (contracts > 1)
    throw InputError(
        "max_gaussians, max_bytes and within_db each say how large the model may be; pass one of "
        "them");
  check_bytes(options.max_bytes);
  if (options.densification == Densification::kAdc) return;
  if (growth_limit(options) == 0)
    throw InputError(
        fmt::format("densification {} needs a number of Gaussians to reach; pass --peak-gaussians "
                    "N or --max-gaussians N",
                    name_of(options.densification)));
  if (options.densification == Densification::kMcmc && options.opacity_reset_interval > 0)
    throw InputError("densification mcmc has no opacity resets; pass --opacity-reset-interval 0");
}

std::array<uint8_t, 3> parse_background(const std::string& text) {
  if (text == "black") return {0, 0, 0};
  if (text == "white") return {255, 255, 255};
  std::array<uint8_t, 3> rgb{};
  const char *cursor = text.data(), *const end = cursor + text.size();
  bool good = true;
  for (size_t c = 0; c < 3 && good; ++c) {
    const auto [rest, error] = std::from_chars(cursor, end, rgb[c]);
    good = error == std::errc() && (c == 2 ? rest == end : rest != end && *rest == ',');
    if (c < 2) cursor = rest + 1;
  }
  if (!good)
    throw InputError(
        fmt::format("background '{}': expected black, white or r,g,b with 0 to 255", text));
  return rgb;
}

KernelSwitches kernel_switches(const TrainOptions& options) {
  KernelSwitches switches;
  switches.bounds.rectangular = options.rectangular_bounds;
  switches.bounds.opacity_aware = options.opacity_bounds;
  switches.balanced_instances = options.balanced_instances;
  switches.separate_sort = options.separate_sort;
  switches.warp_culling = options.warp_culling;
  switches.backward = options.backward;
  switches.deterministic = options.deterministic;
  return switches;
}

SetForm dynamic_form(const TrainOptions& options) {
  return dynamic_form_of(options.motion);
}

const std::vector<TrainOption>& train_option_table() {
  static const std::vector<TrainOption> table = OptionRows::all();
  return table;
}

}  // namespace tessera
