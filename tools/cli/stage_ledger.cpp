// Reads and writes stages.json, and computes keys from inputs. The file is not locked: two runs in
// one folder are not supported.
#include "tools/cli/stage_ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

// File names need not be UTF-8.
constexpr auto kReplaceInvalid = nlohmann::json::error_handler_t::replace;

}  // namespace

StageLedger::StageLedger(fs::path file) : file_(std::move(file)) {
  if (!fs::exists(file_)) return;
  entries_ = nlohmann::json::parse(read_text_file(file_), nullptr, false);
  if (!entries_.is_object())
    throw InputError(
        fmt::format("{}: damaged; remove it to run every stage again", file_.string()));
}

bool StageLedger::done(const std::string& stage, const std::string& key) const {
  return entries_.contains(stage) && entries_[stage].value("key", "") == key &&
         entries_[stage].value("done", false);
}

void StageLedger::set(const std::string& stage, nlohmann::json entry) {
  entries_[stage] = std::move(entry);
  write_text_file(file_, entries_.dump(2, ' ', false, kReplaceInvalid));
}

void StageLedger::begin(const std::string& stage, const std::string& key) {
  set(stage, {{"key", key}, {"done", false}});
}

void StageLedger::finish(const std::string& stage, const std::string& key,
                         const nlohmann::json& result, std::optional<double> seconds) {
  nlohmann::json entry = {{"key", key}, {"done", true}, {"result", result}};
  if (seconds) entry["seconds"] = *seconds;
  set(stage, std::move(entry));
}

const nlohmann::json& StageLedger::result(const std::string& stage) const {
  return entries_.at(stage).at("result");
}

std::string key_of(const nlohmann::json& inputs) {
  Fnv1a hash;
  hash.add(inputs.dump(-1, ' ', false, kReplaceInvalid));
  return hash.hex();
}

namespace {

/// Goes into folders that links name, as the readers of captures do; `open`: the folders that `at`
/// lies in, none of which is entered again.
void add_files(const fs::path& at, std::vector<fs::path>& open, std::vector<fs::path>& files) {
  std::error_code error;
  if (fs::is_regular_file(at, error)) files.push_back(at);
  if (!fs::is_directory(at, error)) return;
  const fs::path real = fs::canonical(at, error);
  if (error || std::find(open.begin(), open.end(), real) != open.end()) return;
  open.push_back(real);
  for (fs::directory_iterator it(at, error), end; !error && it != end; it.increment(error))
    add_files(it->path(), open, files);
  open.pop_back();
}

}  // namespace

nlohmann::json file_stamps(const fs::path& path) {
  std::vector<std::string> stamps;
  std::vector<fs::path> open, files;
  add_files(path, open, files);
  for (const fs::path& file : files)
    stamps.push_back(fmt::format("{} {} {}", file.string(), fs::file_size(file),
                                 fs::last_write_time(file).time_since_epoch().count()));
  std::sort(stamps.begin(), stamps.end());
  return stamps;
}

}  // namespace tessera
