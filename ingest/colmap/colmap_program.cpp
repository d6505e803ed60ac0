// Builds the command lines of `colmap`, version 3.6 and later.
#include "ingest/colmap/colmap_program.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "ingest/files/atomic_file.h"
#include "ingest/files/child_process.h"
#include "ingest/files/text_scan.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr const char* kRemedy =
    "install colmap 3.6 or later (Debian: apt install colmap), or pass --poses FILE";

/// Where the library that COLMAP logs by keeps its files.
std::filesystem::path glog_folder(const std::filesystem::path& log) {
  return std::filesystem::absolute(log).parent_path() / "glog";
}

ChildCommand command_of(const std::filesystem::path& program, const std::filesystem::path& log) {
  ChildCommand command{{program.string()}, {{"QT_QPA_PLATFORM", "offscreen"}}, log};  // no screen
  // glog writes a file of each command and level, into the folder for temporary files by default
  if (!log.empty()) command.environment.emplace_back("GLOG_log_dir", glog_folder(log).string());
  return command;
}

/// How many lines like this one there will be, by its own counts: n of "Matching image [1/n]", n·m
/// of "Matching block [1/n, 1/m]"; 0 where it states none.
int64_t stated_steps(std::string_view line) {
  const auto steps_of = [](std::string_view& text) -> std::optional<int64_t> {
    return take_number(text, 9) && take(text, "/") ? take_number(text, 9) : std::nullopt;
  };
  for (size_t place = line.find('['); place != line.npos; place = line.find('[', place + 1)) {
    std::string_view text = line.substr(place + 1);
    const auto first = steps_of(text);
    if (first && take(text, "]")) return *first;
    if (!first || !take(text, ", ")) continue;
    if (const auto second = steps_of(text); second && take(text, "]")) return *first * *second;
  }
  return 0;
}

/// "Check failed: …" of a line of glog; its stack trace, which follows, tells a user nothing.
std::string failed_check(std::string_view line) {
  const size_t place = line.find("Check failed: ");
  if (place == line.npos) return "";
  return std::string(line.substr(place, line.find_last_not_of(' ') + 1 - place));
}

}  // namespace

bool ColmapFailure::has_no_common_points() const {
  // of the mapper without a first pair; of the adjustment where nothing was triangulated
  return reason.find("failed to create sparse model") != std::string::npos ||
         reason.find("bundle_adjuster.Solve") != std::string::npos;
}

void ColmapFailure::rethrow(const std::vector<std::string>& images,
                            const std::string& remedy) const {
  if (!has_no_common_points()) throw ColmapFailure(*this);
  throw InputError(fmt::format("COLMAP found no common points in {}; {}; its log: {}",
                               listed_names(images), remedy, log.string()));
}

ColmapProgram::ColmapProgram(std::filesystem::path log, const IngestProgress& progress)
    : log_(std::move(log)), progress_(progress) {
  const char* stated = std::getenv("TESSERA_COLMAP");
  const std::string name = stated != nullptr && *stated != '\0' ? stated : "colmap";
  program_ = find_program(name);
  if (program_.empty())
    throw InputError(fmt::format("{}: no such program{}; {}", name,
                                 stated != nullptr && *stated != '\0'
                                     ? " (from the environment variable TESSERA_COLMAP)"
                                     : " in PATH, camera poses need it",
                                 kRemedy));
  make_folder(glog_folder(log_));
  ChildCommand command = command_of(program_, {});
  command.arguments.emplace_back("help");
  run_child(command, [&](std::string_view line) {
    if (version_.empty()) read_version(line);
    if (line.empty()) progress_("starting colmap", 0, 0);
  });
  if (version_.empty())
    throw InputError(fmt::format("{}: does not say which version it is, expected COLMAP; {}",
                                 program_.string(), kRemedy));
  if (major_ < 3 || (major_ == 3 && minor_ < 6))
    throw InputError(fmt::format("{}: is COLMAP {}, expected 3.6 or later; {}", program_.string(),
                                 version_, kRemedy));
}

void ColmapProgram::read_version(std::string_view line) {
  constexpr std::string_view kName = "COLMAP ";
  for (size_t place = line.find(kName); place != line.npos; place = line.find(kName, place + 1)) {
    std::string_view text = line.substr(place + kName.size());
    const auto major = take_number(text, 4);
    if (!major || !take(text, ".")) continue;
    const auto minor = take_number(text, 4);
    if (!minor) continue;
    major_ = int(*major);
    minor_ = int(*minor);
    version_ = fmt::format("{}.{}", major_, minor_);
    return;
  }
}

void ColmapProgram::run(const std::string& command, const ColmapOptions& options,
                        const std::string& doing, const std::string& step, int64_t total,
                        const std::string& remedy) const {
  ChildCommand child = command_of(program_, log_);
  child.arguments.push_back(command);
  for (const auto& [name, value] : options) child.arguments.push_back(name + "=" + value);
  int64_t done = 0;
  bool disk_is_full = false;
  std::string reason;
  progress_(doing, done, total);
  const ChildResult result = run_child(child, [&](std::string_view line) {
    disk_is_full |= line.find("disk is full") != std::string_view::npos ||
                    line.find(std::strerror(ENOSPC)) != std::string_view::npos;
    if (reason.empty()) reason = failed_check(line);
    if (!step.empty() && line.find(step) != std::string_view::npos) {
      if (done == 0 && total == 0) total = stated_steps(line);
      ++done;
    }
    progress_(doing, total > 0 ? std::min(done, total) : done, total);
  });
  // COLMAP checks no write of a model: a full disk may be unreported
  disk_is_full |= std::filesystem::space(log_.parent_path()).available == 0;
  if (disk_is_full) fail_to_write(log_.parent_path(), ENOSPC);
  if (result.exit_code == 0) return;
  if (reason.empty()) reason = result.last_line;
  throw ColmapFailure(fmt::format("colmap {} failed (exit code {}): {}; {}; its log: {}", command,
                                  result.exit_code, reason, remedy, log_.string()),
                      reason, log_);
}

void ColmapProgram::extract_features(ColmapOptions options, int64_t images) const {
  options.emplace_back(
      has_feature_groups() ? "--FeatureExtraction.use_gpu" : "--SiftExtraction.use_gpu", "0");
  run("feature_extractor", options, "colmap: finding features", "Processed file", images);
}

void ColmapProgram::match_features(const std::string& matcher, ColmapOptions options) const {
  const std::string group = has_feature_groups() ? "--FeatureMatching" : "--SiftMatching";
  options.emplace_back(group + ".use_gpu", "0");
  options.emplace_back(group + ".guided_matching", "1");
  run(matcher, options, "colmap: matching features", "Matching ");
}

}  // namespace tessera
