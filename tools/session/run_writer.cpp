// Files appear whole, in an order in which a program that is killed leaves a run that resumes.
#include "tools/session/run_writer.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/model/model_file.h"

namespace tessera {

void RunWriter::warn(const std::string& warning) {
  observer_.on_warning(warning);
  if (log_)
    log_->event("warning", {{"text", warning}});
  else
    early_warnings_.push_back(warning);
}

void RunWriter::replace_previous_run(const nlohmann::json& config) {
  AtomicFile file(folder_.config());
  file.write(json_text(config, 2));
  file.sync();
  folder_.remove_files();
  file.commit();
}

GaussianModel RunWriter::read_best(int64_t step) {
  const std::filesystem::path file = folder_.best(step);
  if (!std::filesystem::exists(file))
    throw CheckpointRefused(
        fmt::format("{}: is gone, the best model so far of this run; train again with --overwrite",
                    file.string()));
  best_ = step;
  return load_model(file);
}

TrainingLog& RunWriter::begin_log(int64_t total, int64_t first, nlohmann::json start) {
  log_.emplace(folder_.log(), total, first, observer_);
  log_->event("start", std::move(start));
  for (const std::string& warning : early_warnings_) log_->event("warning", {{"text", warning}});
  early_warnings_.clear();
  return *log_;
}

void RunWriter::write_checkpoint(const TrainState& state, const TrainOptions& options,
                                 const nlohmann::json& config, const Validation& validation) {
  const int64_t best = validation.record().best_iteration;
  if (validation.best() != nullptr && best != best_) {
    save_model(folder_.best(best), *validation.best());
    best_ = best;
  }
  save_checkpoint(folder_.checkpoint(), state, options, json_text(config), validation.record());
  folder_.remove_best_but(best);
}

void RunWriter::write_model(const GaussianModel& model) {
  if (model.count() == 0)
    warn(
        "no Gaussians are left, density control has removed them all: images are the background; "
        "look at the poses (tessera doctor) and at --init-extent");
  save_model(folder_.model(), model);
}

}  // namespace tessera
