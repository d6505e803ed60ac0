// What: the manifest tessera_output.json and the rule who may replace what.
// Not: the files themselves; commands write those atomically.
#include "tools/output_folder.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr const char* kManifest = "tessera_output.json";

bool stays_inside(const fs::path& file) {
  for (const fs::path& part : file)
    if (part == "..") return false;
  return file.is_relative() && !file.empty();
}

void remove_listed(const fs::path& folder) {
  const nlohmann::json manifest = read_json(folder / kManifest);
  const auto files = manifest.find("files");
  if (files == manifest.end() || !files->is_array()) return;
  for (const nlohmann::json& file : *files) {
    if (!file.is_string() || !stays_inside(file.get<std::string>())) continue;
    std::error_code ignored;
    fs::remove(folder / file.get<std::string>(), ignored);
  }
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder, const std::string& command,
                           std::vector<std::string> files, bool overwrite)
    : folder_(std::move(folder)), command_(command), files_(std::move(files)) {
  make_folder(folder_);
  if (fs::exists(folder_ / kManifest)) {
    remove_listed(folder_);
  } else if (!fs::is_empty(folder_) && !overwrite) {
    throw InputError(
        fmt::format("{}: has contents that tessera {} did not write; choose another folder or pass "
                    "--overwrite",
                    folder_.string(), command_));
  }
  write_manifest(false);
}

void OutputFolder::finish() {
  write_manifest(true);
}

void OutputFolder::write_manifest(bool complete) const {
  const nlohmann::ordered_json manifest{
      {"written_by", "tessera " + command_}, {"complete", complete}, {"files", files_}};
  write_text_file(folder_ / kManifest, manifest.dump(1) + "\n");
}

}  // namespace tessera
