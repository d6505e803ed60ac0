// Reads and writes stages.json, and compares inputs. `tessera run` holds the lock of its folder.
#include "tools/cli/stage_ledger.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "ingest/files/atomic_file.h"
#include "ingest/files/fnv1a.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "tools/cli/run_record.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kProduct = "contents of the product";  // 0.3 stamped otherwise: "product"

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

/// A file of text has no zero byte in its first block.
bool is_text(const fs::path& file) {
  constexpr size_t kFirst = 4096;
  std::string begin(kFirst, ' ');
  std::ifstream(file, std::ios::binary).read(begin.data(), std::streamsize(kFirst));
  return begin.find('\0') == std::string::npos;
}

std::string hash_of_contents(const fs::path& file) {
  constexpr int64_t kBlocks = 10, kMostText = int64_t{1} << 26;
  constexpr size_t kBytes = 4096;
  const auto size = int64_t(fs::file_size(file));
  return size <= int64_t(kBytes) * kBlocks || (size <= kMostText && is_text(file))
             ? source_hash(file)
             : sampled_hash(file, kBlocks, kBytes);
}

}  // namespace

StageLedger::StageLedger(fs::path file) : file_(std::move(file)) {
  if (!fs::exists(file_)) return;
  entries_ = nlohmann::json::parse(read_text_file(file_), nullptr, false);
  if (!entries_.is_object())
    throw InputError(
        fmt::format("{}: damaged; remove it to run every stage again", file_.string()));
}

bool StageLedger::is_finished(const std::string& stage) const {
  return entries_.contains(stage) && entries_[stage].value("done", false);
}

bool StageLedger::done(const std::string& stage, const json& inputs) const {
  const json before = this->inputs(stage);
  return is_finished(stage) && before.is_object() && changes(before, inputs).empty();
}

std::vector<std::string> StageLedger::changed(const std::string& stage, const json& inputs) const {
  const json before = this->inputs(stage);
  return before.is_object() ? changes(before, inputs) : std::vector<std::string>();
}

json StageLedger::inputs(const std::string& stage) const {
  return entries_.contains(stage) ? entries_[stage].value("inputs", json()) : json();
}

void StageLedger::set(const std::string& stage, json entry) {
  entries_[stage] = std::move(entry);
  write_text_file(file_, json_text(entries_, 2));
}

void StageLedger::begin(const std::string& stage, const json& inputs) {
  set(stage, {{"inputs", inputs}, {"done", false}});
}

void StageLedger::finish(const std::string& stage, const json& result,
                         std::optional<double> seconds, const json& product) {
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  json entry = {{"inputs", inputs(stage)}, {"done", true}, {"result", result}, {"at", now}};
  if (seconds) entry["seconds"] = *seconds;
  if (!product.is_null()) entry[kProduct] = product;
  set(stage, std::move(entry));
}

bool StageLedger::wrote(const std::string& stage, const json& product) const {
  if (!is_finished(stage)) return false;
  const json before = entries_[stage].value(kProduct, json());
  return before.is_null() || before == product;
}

void StageLedger::adopt(const std::string& stage, const StageLedger& other) {
  set(stage, other.entries_.at(stage));
}

std::string StageLedger::finished_at(const std::string& stage) const {
  return is_finished(stage) ? entries_[stage].value("at", json(0)).dump() : "";
}

const json& StageLedger::result(const std::string& stage) const {
  return entries_.at(stage).at("result");
}

std::string key_of(const json& inputs) {
  Fnv1a hash;
  hash.add(json_text(inputs));
  return hash.hex();
}

json file_stamps(const fs::path& path) {
  std::vector<std::string> stamps;
  std::vector<fs::path> open, files;
  add_files(path, open, files);
  for (const fs::path& file : files) {
    stamps.push_back(fmt::format("{} {} {}", file.lexically_relative(path).generic_string(),
                                 fs::file_size(file), hash_of_contents(file)));
  }
  std::sort(stamps.begin(), stamps.end());
  return stamps;
}

}  // namespace tessera
