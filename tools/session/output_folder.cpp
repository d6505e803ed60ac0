// Writes the manifest tessera_output.json, manages the hidden folder, and checks which files may be
// replaced.
#include "tools/session/output_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr const char* kManifest = "tessera_output.json";
constexpr const char* kStem = "tessera";

bool stays_inside(const fs::path& file) {
  for (const fs::path& part : file)
    if (part == "..") return false;
  return file.is_relative() && !file.empty();
}

/// The files that `command` has listed there; nothing where it has listed none.
std::optional<std::vector<std::string>> listed_files(const fs::path& folder,
                                                     const std::string& command) {
  if (!fs::exists(folder / kManifest)) return std::nullopt;
  const nlohmann::json manifest = read_json(folder / kManifest);
  if (!manifest.is_object() || manifest.value("written_by", "") != "tessera " + command)
    return std::nullopt;
  std::vector<std::string> files;
  for (const nlohmann::json& file : manifest.value("files", nlohmann::json::array()))
    if (file.is_string() && stays_inside(file.get<std::string>())) files.push_back(file);
  return files;
}

}  // namespace

bool has_foreign_contents(const fs::path& folder, const std::string& command) {
  std::error_code absent;
  const fs::directory_iterator entries(folder, absent);
  return !listed_files(folder, command) &&
         std::any_of(begin(entries), end(entries), [](const fs::directory_entry& entry) {
           const std::string name = entry.path().filename().string();
           return !(name.starts_with(".") && name.ends_with(".partial"));  // of a killed program
         });
}

OutputFolder::OutputFolder(fs::path folder, const std::string& command,
                           std::vector<std::string> files, bool overwrite)
    : folder_(std::move(folder)),
      staging_(folder_ / staging_name(kStem)),
      command_(command),
      files_(std::move(files)),
      made_folder_(!fs::exists(folder_)) {
  make_folder(folder_);
  if (!overwrite && has_foreign_contents(folder_, command_))
    throw InputError(
        fmt::format("{}: has contents that tessera {} did not write; choose another folder or pass "
                    "--overwrite",
                    folder_.string(), command_));
  earlier_ = listed_files(folder_, command_).value_or(std::vector<std::string>{});
  remove_stale_staging(folder_, kStem);
  remove_partial_files(folder_);
  make_folder(staging_);
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  if (made_folder_) fs::remove(folder_, ignored);  // only if it is empty
}

void OutputFolder::finish() {
  for (const std::string& file : files_) make_folder((folder_ / file).parent_path());
  write_manifest(staging_ / kManifest, true);
  write_manifest(folder_ / kManifest, false);
  // from here on nothing needs room on the disk
  for (const std::string& file : files_) fs::rename(staging_ / file, folder_ / file);
  for (const std::string& file : earlier_) {
    std::error_code ignored;
    if (std::find(files_.begin(), files_.end(), file) == files_.end())
      fs::remove(folder_ / file, ignored);
  }
  fs::rename(staging_ / kManifest, folder_ / kManifest);
}

std::string OutputFolder::in_place(std::string message) const {
  const std::string staging = staging_.string();
  size_t place = 0;
  while ((place = message.find(staging, place)) != std::string::npos)
    message.replace(place, staging.size(), folder_.string());
  return message;
}

/// One that is not complete lists the files of both runs.
void OutputFolder::write_manifest(const fs::path& file, bool complete) const {
  std::vector<std::string> files = files_;
  if (!complete) files.insert(files.end(), earlier_.begin(), earlier_.end());
  const nlohmann::ordered_json manifest{
      {"written_by", "tessera " + command_}, {"complete", complete}, {"files", files}};
  write_text_file(file, json_text(manifest, 1) + "\n");
}

}  // namespace tessera
