// Compares the folder of a batch with its state at the last look.
#include "tools/batch/batch_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "kernels/base/errors.h"
#include "tools/cli/terminal.h"

namespace tessera {

namespace {

/// "room 1 of 4 runs": done of a scene.
std::string progress_of(const BatchFolder& batch, const std::string& scene) {
  int done = 0, all = 0;
  for (const BatchRun& run : batch.runs)
    if (run.scene == scene) {
      ++all;
      done += run.state == RunState::kDone;
    }
  return fmt::format("{} {} of {} runs", scene, done, all);
}

}  // namespace

BatchWatch::BatchWatch(std::filesystem::path out) : out_(std::move(out)) {
  look();
  silent_ = false;
}

void BatchWatch::tick() {
  if (std::chrono::steady_clock::now() - looked_ > between_) look();
}

void BatchWatch::look() {
  const auto begin = std::chrono::steady_clock::now();
  try {
    const BatchFolder batch = read_batch(out_);
    tell_runs(batch);
    tell_failures(batch);
  } catch (const InputError&) {  // a file that is being replaced: it is read at the next look
  }
  looked_ = std::chrono::steady_clock::now();
  between_ = std::max<std::chrono::steady_clock::duration>(std::chrono::seconds(2),
                                                           20 * (looked_ - begin));
}

void BatchWatch::tell_runs(const BatchFolder& batch) {
  for (const BatchRun& run : batch.runs) {
    if (run.state != RunState::kDone || !done_.insert(run.folder).second || silent_) continue;
    say(fmt::format("batch: {}, {}, seed {} done; {}, all {} of {}", run.scene, run.preset,
                    run.seed, progress_of(batch, run.scene), batch.count(RunState::kDone),
                    batch.runs.size()));
  }
}

void BatchWatch::tell_failures(const BatchFolder& batch) {
  for (const BatchFailure& failure : batch.failures)
    if (!failure.unfinished() && failures_.insert(failure.line()).second && !silent_)
      report_error(fmt::format("batch: {}", failure.line()));
}

}  // namespace tessera
