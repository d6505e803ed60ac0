// Lists and records of jobs as JSON.
#include "tools/jobs/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(JobUses, gpus, threads, memory_mb, minutes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Job, name, words, needs, inputs, output, product,
                                                uses)

namespace {
using nlohmann::json;
}

json read_record(const JobFolder& folder, const std::string& name) {
  std::error_code absent;
  if (!std::filesystem::is_regular_file(folder.record(name), absent)) return json::object();
  json record = json::parse(read_text_file(folder.record(name)), nullptr, false);
  return record.is_object() ? record : json::object();
}

bool is_done(const Job& job, const JobFolder& folder) {
  const json record = read_record(folder, job.name);
  if (!record.value("done", false) || record.value("inputs", "") != job.inputs) return false;
  std::error_code absent;
  for (const std::string& file : {job.output, job.product})
    if (!file.empty() && !std::filesystem::exists(folder.root / file, absent)) return false;
  return std::all_of(job.needs.begin(), job.needs.end(), [&](const std::string& need) {
    const json earlier = read_record(folder, need);
    return earlier.value("done", false) &&
           record.at("needs").value(need, json()) == earlier.value("at", json(0));
  });
}

std::vector<Job> jobs_to_do(const std::vector<Job>& jobs, const JobFolder& folder) {
  std::vector<Job> to_do;
  std::set<std::string> names;
  for (const Job& job : jobs) {
    const bool again = std::any_of(job.needs.begin(), job.needs.end(),
                                   [&](const auto& need) { return names.contains(need); });
    if (!again && is_done(job, folder)) continue;
    names.insert(job.name);
    to_do.push_back(job);
  }
  return to_do;
}

void write_job_list(const std::vector<Job>& jobs, const JobFolder& folder) {
  json names = json::array();
  for (const Job& job : jobs_to_do(jobs, folder)) names.push_back(job.name);
  write_text_file(folder.list(), json_text(json{{"jobs", jobs}, {"to_do", names}}, 1) + "\n");
}

std::vector<Job> read_job_list(const JobFolder& folder) {
  const json file = read_json(folder.list());
  try {
    return file.at("jobs").get<std::vector<Job>>();
  } catch (const json::exception&) {
    throw InputError(fmt::format("{}: is no list of jobs; repeat the command that writes it",
                                 folder.list().string()));
  }
}

}  // namespace tessera
