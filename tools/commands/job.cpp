// `tessera job`: performs one job of the list in a folder, for engines of batches.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "kernels/base/errors.h"
#include "tools/batch/batch_jobs.h"
#include "tools/cli/background_program.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/jobs/perform.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct JobRequest {
  fs::path out;
  std::string name, refused;
  int64_t attempt = 1;
  bool uses = false;
};

Job job_named(const std::string& name, const JobFolder& folder) {
  const std::vector<Job> jobs = read_job_list(folder);
  const auto found =
      std::find_if(jobs.begin(), jobs.end(), [&](const Job& job) { return job.name == name; });
  if (found == jobs.end())
    throw InputError(fmt::format("{}: has no job '{}'", folder.list().string(), name));
  return *found;
}

int perform(const Job& job, const JobFolder& folder) {
  RunningJob running(job, folder, {});
  int passed_on = 0;
  while (true) {
    if (const std::optional<JobOutcome> outcome = running.poll()) {
      if (outcome->exit_code != 0) report_error(fmt::format("{}: {}", job.name, outcome->message));
      return outcome->exit_code;
    }
    const int number = stop_signal();
    if (number != passed_on) running.signal(passed_on = number);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

int run(const JobRequest& request) {
  const fs::path root = fs::absolute(request.out / "").lexically_normal().parent_path();
  const JobFolder folder{root, this_program()};
  const Job job = job_named(request.name, folder);
  if (!request.refused.empty()) {
    record_refusal(job, folder, request.refused);
    return kExitFailed;
  }
  if (request.uses) {
    const Batch batch = resolve_batch(read_batch_file(root / "batch.yaml"), root);
    print_result(true, forecast_uses(job, batch, root), "");
    return kExitDone;
  }
  // more memory does not change the input
  if (request.attempt > 1 && read_record(folder, job.name).value("exit_code", nlohmann::json()) ==
                                 nlohmann::json(kExitBadInput))
    return kExitBadInput;
  return perform(job, folder);
}

}  // namespace

void add_job_command(CLI::App& app, Work& work) {
  const auto request = std::make_shared<JobRequest>();
  CLI::App& command = *app.add_subcommand("job", "perform one job of a list, for engines");
  command.group("");  // not for people
  command.add_option("out", request->out, "folder with jobs.json")->required();
  command.add_option("name", request->name, "of the job")->required();
  command.add_option("--attempt", request->attempt, "after a failure; bad input is not repeated");
  command.add_option("--refused", request->refused, "record that the cluster did not take it");
  command.add_flag("--uses", request->uses, "print what it takes, by the forecast");
  command.callback([request, &work] { work = [request] { return run(*request); }; });
}

}  // namespace tessera
