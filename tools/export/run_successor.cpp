// Entry by entry: the old one is renamed to OUT/previous, the new one to OUT. A move has begun
// where OUT/next/complete is there, which names that folder; doing it again does what is left. Of a
// training its model or its plan of windows is moved first: without it in RUN/next, the old files
// are gone already.
#include "tools/export/run_successor.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "tools/session/run_folder.h"
#include "tools/session/windows_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr const char* kComplete = "complete";
constexpr const char* kEntries[] = {"scene", "run", "stages.json"};

void rename_or_fail(const fs::path& from, const fs::path& to) {
  std::error_code reason;
  fs::rename(from, to, reason);
  if (reason) fail_to_write(to, reason.value());
}

/// In all texts of the value.
void replace_prefix(nlohmann::json& value, const std::string& before, const std::string& now) {
  if (value.is_structured())
    for (nlohmann::json& inner : value) replace_prefix(inner, before, now);
  if (!value.is_string()) return;
  const std::string text = value.get<std::string>();
  if (text.starts_with(before)) value = now + text.substr(before.size());
}

/// Paths that a file has written down follow the move.
void follow(const fs::path& file, const fs::path& from, const fs::path& out) {
  if (!fs::exists(file)) return;
  nlohmann::json value = nlohmann::json::parse(read_text_file(file), nullptr, false);
  if (value.is_discarded()) return;
  replace_prefix(value, (from / "").string(), (out / "").string());
  replace_prefix(value, (fs::absolute(from) / "").string(), (fs::absolute(out) / "").string());
  write_text_file(file, value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

/// The same of a clip that was trained window by window.
void follow_windows(const fs::path& run, const fs::path& from, const fs::path& out) {
  const WindowsFolder folder{run};
  if (!folder.exists()) return;
  follow(folder.plan_file(), from, out);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(run))
    if (entry.path().filename() == "config.json") follow(entry.path(), from, out);
}

void remove_previous(const fs::path& previous) {
  std::error_code ignored;
  fs::remove_all(previous / "scene", ignored);
  fs::remove(previous / "stages.json", ignored);
  const RunFolder run{previous / "run"};
  WindowsFolder{run.root}.remove();
  run.remove_files();
  remove_partial_files(run.root);
  fs::remove(run.root / "lock", ignored);
  fs::remove(run.root, ignored);  // unless somebody has put files there
  fs::remove(previous, ignored);
}

/// "previous", or "previous.2" … where files of somebody are in it.
std::string free_name(const fs::path& out) {
  std::string name = "previous";
  for (int i = 2; fs::exists(out / name); ++i) name = "previous." + std::to_string(i);
  return name;
}

}  // namespace

void move_successor(const fs::path& from, const fs::path& out) {
  const fs::path marker = from / kComplete;
  if (!fs::exists(marker)) write_text_file(marker, free_name(out));
  const fs::path previous = out / read_text_file(marker);
  std::error_code ignored;
  fs::create_directories(previous, ignored);
  for (const char* entry : kEntries) {
    if (!fs::exists(from / entry)) continue;
    if (fs::exists(out / entry)) rename_or_fail(out / entry, previous / entry);
    rename_or_fail(from / entry, out / entry);
  }
  follow(out / "run" / "config.json", from, out);
  follow_windows(out / "run", from, out);
  follow(out / "stages.json", from, out);
  remove_previous(previous);
  fs::remove_all(from, ignored);
}

void finish_move(const fs::path& out) {
  if (fs::exists(out / kNext / kComplete)) move_successor(out / kNext, out);
}

void move_training(const fs::path& from, const fs::path& run) {
  const RunFolder place{run};
  const WindowsFolder made{from};
  const fs::path marker = from / kComplete;
  if (!fs::exists(marker)) write_text_file(marker, "");
  const fs::path first = made.exists() ? made.plan_file() : RunFolder{from}.model();
  if (fs::exists(first)) {
    WindowsFolder{run}.remove();
    place.remove_files();
    rename_or_fail(first, run / first.filename());
  }
  std::vector<fs::path> parts;
  for (const auto& entry : fs::directory_iterator(from))
    if (entry.is_regular_file() && entry.path() != marker) parts.push_back(entry.path());
  for (const fs::path& folder : made.folders())
    if (fs::exists(folder)) parts.push_back(folder);
  for (const fs::path& part : parts) rename_or_fail(part, run / part.filename());
  follow_windows(run, from, run);
  std::error_code ignored;
  fs::remove_all(from, ignored);
}

void finish_training_move(const fs::path& run) {
  if (fs::exists(run / kNext / kComplete)) move_training(run / kNext, run);
}

}  // namespace tessera
