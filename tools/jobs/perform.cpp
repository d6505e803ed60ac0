// The command writes its result to jobs/NAME.part, and what it says to its log.
#include "tools/jobs/perform.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "ingest/files/atomic_file.h"
#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "kernels/base/seconds_since.h"
#include "tools/cli/background_program.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kKilled = 128 + SIGKILL;

/// Programs that the kernel has killed for memory until now; 0 where it does not count them.
int64_t kills_for_memory() {
  std::ifstream counters("/proc/vmstat");
  for (std::string name, number; counters >> name >> number;)
    if (name == "oom_kill") return std::atoll(number.c_str());
  return 0;
}

bool speaks_of_memory(std::string message) {
  std::transform(message.begin(), message.end(), message.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return message.find("out of memory") != std::string::npos;
}

fs::path part_of(const fs::path& record) {
  return fs::path(record).replace_extension(".part");
}

/// Of the environment, for devices by their numbers among those that this program sees; "": none.
std::string visible_devices(const std::vector<int>& gpus) {
  if (gpus.empty()) return "";
  const char* const visible = std::getenv("CUDA_VISIBLE_DEVICES");
  std::istringstream list(visible == nullptr ? "" : visible);
  std::vector<std::string> seen, names;
  for (std::string name; std::getline(list, name, ',');) seen.push_back(name);
  for (const int gpu : gpus)
    names.push_back(size_t(gpu) < seen.size() ? seen[size_t(gpu)] : fmt::format("{}", gpu));
  return fmt::format("CUDA_VISIBLE_DEVICES={}", fmt::join(names, ","));
}

constexpr const char* kNotEnded =
    "ended without a word: out of memory or time, or its machine was lost (or it still runs)";

/// Until its end is known.
json begun_record(const Job& job, const JobFolder& folder, double seconds_before) {
  json record = {{"words", job.words},
                 {"inputs", job.inputs},
                 {"needs", json::object()},
                 {"at", std::chrono::system_clock::now().time_since_epoch().count()},
                 {"seconds", seconds_before},
                 {"done", false},
                 {"exit_code", nullptr},
                 {"message", kNotEnded}};
  for (const std::string& need : job.needs)
    record["needs"][need] = read_record(folder, need).value("at", json(0));
  return record;
}

void write_record(const Job& job, const JobFolder& folder, const json& record) {
  make_folder(folder.record(job.name).parent_path());
  write_text_file(folder.record(job.name), json_text(record, 1) + "\n");
}

}  // namespace

void record_refusal(const Job& job, const JobFolder& folder, const std::string& message) {
  json record = begun_record(job, folder, 0);
  record.update({{"exit_code", 1}, {"message", message}});
  write_record(job, folder, record);
}

std::string last_line(const fs::path& log, int64_t begin) {
  std::ifstream file(log, std::ios::binary);
  file.seekg(begin);
  std::string text{std::istreambuf_iterator<char>(file), {}}, last, error;
  std::replace(text.begin(), text.end(), '\r', '\n');
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    if (line.starts_with("tessera: ")) error = line;
    last = line;
  }
  return error.empty() ? last : error;
}

RunningJob::RunningJob(const Job& job, const JobFolder& folder, const std::vector<int>& gpus)
    : job_(job), folder_(folder), gpus_(gpus) {
  make_folder(folder.record(job.name).parent_path());
  make_folder(folder.log(job.name).parent_path());
  const fs::path log = folder.log(job.name);
  log_ = ::open(log.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log_ < 0) fail_to_write(log, errno);
}

RunningJob::~RunningJob() {
  ::close(log_);
}

void RunningJob::signal(int number) const {
  if (child_ > 0) ::kill(-child_, number);
}

void RunningJob::start() {
  const json before = read_record(folder_, job_.name);
  if (before.value("inputs", "") == job_.inputs) seconds_before_ = before.value("seconds", 0.0);
  was_done_ = before.value("done", false);
  write_record(job_, folder_, begun_record(job_, folder_, seconds_before_));
  const fs::path part = part_of(folder_.record(job_.name));
  const int output = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (output < 0) fail_to_write(part, errno);
  std::vector<std::string> words{folder_.program.string()};
  words.insert(words.end(), job_.words.begin(), job_.words.end());
  const std::string title = fmt::format("+ {}\n", fmt::join(words, " "));
  if (::write(log_, title.data(), title.size()) < 0) fail_to_write(folder_.log(job_.name), errno);
  log_begin_ = ::lseek(log_, 0, SEEK_END);
  kills_ = kills_for_memory();
  begin_ = std::chrono::steady_clock::now();
  child_ = start_in_background(folder_.program, words,
                               {.output = output,
                                .errors = log_,
                                .folder = folder_.root,
                                .variable = visible_devices(gpus_)});
  const int reason = errno;
  ::close(output);
  if (child_ < 0)
    throw InputError(
        fmt::format("{}: cannot be started ({})", folder_.program.string(), std::strerror(reason)));
}

std::optional<JobOutcome> RunningJob::poll() {
  if (child_ < 0) {  // a file system without locks has no second start either
    if (::flock(log_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      has_waited_ = true;
      return std::nullopt;
    }
    if (has_waited_ && is_done(job_, folder_)) return JobOutcome{};
    start();
  }
  int status = 0;
  if (::waitpid(child_, &status, WNOHANG) != child_) return std::nullopt;
  return end(status);
}

JobOutcome RunningJob::end(int status) {
  child_ = -1;
  JobOutcome outcome;
  outcome.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  const fs::path part = part_of(folder_.record(job_.name));
  json result = json::parse(read_text_file(part), nullptr, false);
  std::error_code ignored;
  if (outcome.exit_code == 0 && result.is_discarded()) {
    outcome.exit_code = 1;
    outcome.message = "has ended without a result";
  } else if (outcome.exit_code == kKilled) {  // who stops a machine sends this signal, too
    outcome.out_of_memory = kills_for_memory() > kills_;
    outcome.message = outcome.out_of_memory ? "was killed: out of memory" : "was killed";
  } else if (outcome.exit_code != 0) {
    outcome.message = last_line(folder_.log(job_.name), log_begin_);
    if (outcome.message.empty()) outcome.message = "said nothing";
    outcome.out_of_memory = speaks_of_memory(outcome.message);
  }
  // a job that was done is begun anew, unless its command finds nothing left to do
  const bool has_found = result.is_object() && result.value("done_before", false);
  if (was_done_ && !has_found) seconds_before_ = 0;
  json record = begun_record(job_, folder_, 0);
  record["seconds"] = seconds_before_ + (was_done_ && has_found ? 0 : seconds_since(begin_));
  record["done"] = outcome.exit_code == 0;
  if (outcome.exit_code != 0) {
    fs::remove(part, ignored);
    record.update({{"exit_code", outcome.exit_code},
                   {"message", outcome.message},
                   {"out_of_memory", outcome.out_of_memory}});
  } else {
    record.erase("exit_code");
    record.erase("message");
    if (job_.output.empty()) {
      fs::remove(part, ignored);
      record["result"] = std::move(result);
    } else {
      const fs::path output = folder_.root / job_.output;
      make_folder(output.parent_path());
      fs::rename(part, output);
    }
  }
  write_record(job_, folder_, record);
  return outcome;
}

}  // namespace tessera
