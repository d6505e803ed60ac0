// Writes the lines of log.jsonl.
#include "tools/session/training_log.h"

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "kernels/base/seconds_since.h"

namespace tessera {

namespace {

/// A full disk or a kill may have left part of a line, to which the next would be added.
void cut_half_written_line(const std::filesystem::path& path) {
  std::error_code absent;
  if (std::filesystem::file_size(path, absent) == 0 || absent) return;
  const std::string text = read_text_file(path);
  std::filesystem::resize_file(path, text.rfind('\n') + 1);  // npos + 1 is 0
}

}  // namespace

TrainingLog::TrainingLog(const std::filesystem::path& path, int64_t total, int64_t first,
                         SessionObserver& observer)
    : path_(path), file_(nullptr, std::fclose), total_(total), first_(first), observer_(observer) {
  cut_half_written_line(path);
  file_.reset(std::fopen(path.c_str(), "ab"));
  if (file_ == nullptr) fail_to_write(path_, errno);
}

void TrainingLog::event(const std::string& name, nlohmann::json fields) {
  fields["event"] = name;
  const std::string line = json_text(fields) + "\n";
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size() ||
      std::fflush(file_.get()) != 0)
    fail_to_write(path_, errno);
}

void TrainingLog::on_step(const StepReport& report) {
  last_ = report;
  sum_.loss += report.loss;
  sum_.l1 += report.l1;
  sum_.ssim += report.ssim;
  sum_.seconds += report.seconds;
  ++steps_;
  const int64_t done = std::max<int64_t>(report.iteration - first_, 1);
  observer_.on_step({report, total_, first_, double(steps_) / sum_.seconds,
                     seconds_left(seconds_since(begin_), done, total_ - report.iteration)});
  if (report.iteration % kStepsPerLine != 0 && report.iteration != total_) return;
  const double n = double(steps_);
  event("steps", {{"iteration", report.iteration},
                  {"loss", sum_.loss / n},
                  {"l1", sum_.l1 / n},
                  {"ssim", sum_.ssim / n},
                  {"seconds_per_step", sum_.seconds / n},
                  {"num_static", report.num_static},
                  {"num_dynamic", report.num_dynamic},
                  {"splats", report.splats},
                  {"peak_device_bytes", report.peak_bytes},
                  {"instances", report.instances},
                  {"invalid_gaussians", report.invalid_gaussians}});
  sum_ = {};
  steps_ = 0;
}

void TrainingLog::on_density(int64_t iteration, const std::string& set,
                             const DensityReport& report) {
  event("density", {{"iteration", iteration},
                    {"set", set},
                    {"cloned", report.cloned},
                    {"split", report.split},
                    {"pruned", report.pruned},
                    {"relocated", report.relocated},
                    {"added", report.added},
                    {"before", report.before},
                    {"after", report.after}});
}

}  // namespace tessera
