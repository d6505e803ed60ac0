// Events of a log as sentences: what a training changed by itself, how much, and why.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

#include "tools/report/log_events.h"

namespace tessera {
namespace {

using nlohmann::json;

/// "12,345".
std::string grouped(int64_t count) {
  const std::string digits = std::to_string(std::llabs(count));
  std::string text = count < 0 ? "-" : "";
  for (size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

/// "1 static Gaussian was", "2,000 static Gaussians were".
std::string gaussians_were(int64_t count, const char* kind) {
  return fmt::format("{} {}{}", grouped(count), kind,
                     count == 1 ? "Gaussian was" : "Gaussians were");
}

/// Why so many were pruned: a size limit, or the knee of error over bytes.
std::string pruning_text(const json& event) {
  const int64_t removed = count_at(event, "removed"), goal = count_at(event, "goal");
  std::string text = gaussians_were(removed, "") + " pruned";
  if (goal > 0 && goal != count_at(event, "knee"))
    text += fmt::format(", those that matter least, towards the size limit of {} Gaussians",
                        grouped(goal));
  else if (const auto price = number_at(event, "price"); price && *price > 0)
    text += fmt::format(
        ", each of which lowered the squared error of the training views by less than {:.2g} for "
        "every byte that it takes",
        *price);
  text += ".";
  const auto before = number_at(event, "psnr"), after = number_at(event, "thinned");
  if (before && after && *before > 0 && *after > 0)
    text += fmt::format(" PSNR on sampled training views: {:.2f} dB before, {:.2f} dB after.",
                        *before, *after);
  return text;
}

std::string degrees_text(const json& event) {
  const json& degrees = field_at(event, "degrees");
  if (!degrees.is_array() || degrees.size() != 4) return "";
  std::array<int64_t, 4> counts{};
  int64_t all = 0;
  for (size_t i = 0; i < 4; ++i) {
    if (degrees[i].is_number_integer()) counts[i] = degrees[i].get<int64_t>();
    all += counts[i];
  }
  if (all == 0) return "";
  return fmt::format(
      " Colours now depend on the viewing direction only where that lowers the error: {} Gaussians "
      "have one colour (SH degree 0), {} have degree 1, {} degree 2 and {} degree 3.",
      grouped(counts[0]), grouped(counts[1]), grouped(counts[2]), grouped(counts[3]));
}

std::string reduction_text(const json& event) {
  const int64_t demoted = count_at(event, "demoted"), promoted = count_at(event, "promoted"),
                spawned = count_at(event, "spawned"), missed = count_at(event, "spawned_missed");
  std::string text;
  const auto add = [&](const std::string& sentence) {
    if (!text.empty()) text += ' ';
    text += sentence;
  };
  if (demoted > 0)
    add(gaussians_were(demoted, "dynamic ") +
        " demoted to static, because the views look nearly the same without their motion.");
  if (promoted > 0)
    add(gaussians_were(promoted, "static ") +
        " promoted to dynamic, because the error where they are changes with time.");
  if (spawned > 0)
    add(gaussians_were(spawned, "dynamic ") +
        " added where static ones leave an error that changes with time.");
  if (missed > 0)
    add(gaussians_were(missed, "dynamic ") + " added where several cameras missed what moves.");
  if (count_at(event, "removed") > 0) add(pruning_text(event));
  if (text.empty()) text = "The model was measured, and nothing was changed.";
  return text + degrees_text(event);
}

/// Sums over the density control of one set.
struct DensitySum {
  int64_t first = 0, last = 0;  // steps
  int64_t cloned = 0, split = 0, pruned = 0, relocated = 0, added = 0;

  void add(const json& event) {
    last = count_at(event, "iteration");
    if (first == 0) first = last;
    cloned += count_at(event, "cloned");
    split += count_at(event, "split");
    pruned += count_at(event, "pruned");
    relocated += count_at(event, "relocated");
    added += count_at(event, "added");
  }

  std::string text(const char* set) const {
    std::string changes;
    const auto part = [&](int64_t count, const char* what) {
      if (count > 0)
        changes += fmt::format("{}{} {}", changes.empty() ? "" : ", ", grouped(count), what);
    };
    part(cloned, "cloned");
    part(split, "split");
    part(added, "added");
    part(relocated, "moved to where they are needed");
    part(pruned, "pruned as nearly transparent or too large");
    return fmt::format("Density control of the {} set from step {} on: {}.", set, grouped(first),
                       changes.empty() ? "no change" : changes);
  }
};

std::string end_text(const json& validation) {
  const auto psnr = number_at(validation, "best_psnr");
  std::string text = fmt::format("The model is that of step {}, the best on the validation views",
                                 grouped(count_at(validation, "best_iteration")));
  if (psnr) text += fmt::format(" (PSNR {:.2f} dB)", *psnr);
  if (field_at(validation, "stopped") == true)
    text += "; training stopped because later models were not better";
  return text + ".";
}

}  // namespace

json run_decisions(const std::vector<json>& events) {
  json decisions = json::array();
  DensitySum sums[2];
  const auto add = [&](int64_t step, const std::string& text, json counts = json::object()) {
    counts.update({{"step", step}, {"text", text}});
    decisions.push_back(std::move(counts));
  };
  for (const json& event : events) {
    const std::string name = text_at(event, "event");
    if (name == "density") sums[text_at(event, "set") == "dynamic"].add(event);
    if (name == "decision")
      add(count_at(event, "iteration"), reduction_text(event),
          {{"static", {count_at(event, "static_before"), count_at(event, "static")}},
           {"dynamic", {count_at(event, "dynamic_before"), count_at(event, "dynamic")}}});
    if (name == "end" && field_at(event, "validation").is_object())
      add(count_at(event, "iterations"), end_text(field_at(event, "validation")));
  }
  for (const int k : {0, 1})
    if (sums[k].last > 0) add(sums[k].first, sums[k].text(k == 1 ? "dynamic" : "static"));
  std::stable_sort(decisions.begin(), decisions.end(),
                   [](const json& a, const json& b) { return a["step"] < b["step"]; });
  return decisions;
}

}  // namespace tessera
