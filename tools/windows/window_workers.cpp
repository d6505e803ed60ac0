// Each worker is a child process that a thread waits for.
#include "tools/windows/window_workers.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>

#include "ingest/files/child_process.h"
#include "kernels/base/errors.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/session/device_choice.h"

namespace tessera {
namespace {

/// As an option of the command line has it.
std::string with_dashes(std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  return "--" + key;
}

}  // namespace

std::vector<std::string> words_of(const TrainArguments& arguments) {
  std::vector<std::string> words{"--preset", arguments.preset};
  const auto add = [&](const std::string& option, const std::string& value) {
    words.insert(words.end(), {option, value});
  };
  if (!arguments.ablation.empty()) add("--ablation", arguments.ablation);
  if (!arguments.config.empty()) add("--config", arguments.config);
  for (const auto& [key, value] : arguments.given) add(with_dashes(key), value);
  if (arguments.threads > 0) add("--threads", fmt::format("{}", arguments.threads));
  if (arguments.evaluate_every != 0)
    add("--evaluate-every", arguments.evaluate_every == kNeverEvaluate
                                ? kNever
                                : fmt::format("{}", arguments.evaluate_every));
  if (arguments.checkpoint_every)
    add("--checkpoint-every", fmt::format("{}", *arguments.checkpoint_every));
  return words;
}

void add_gpus_option(CLI::App& command, int64_t& gpus) {
  command.add_option("--gpus", gpus, "cards that train windows at once")
      ->capture_default_str()
      ->check(CLI::Range(int64_t{1}, int64_t{64}));
}

void check_gpus(int64_t gpus, const std::string& backend) {
  const BackendWish wish = parse_backend(backend);
  if (gpus < 2 || (wish.name != "cpu" && !wish.gpu)) return;
  throw InputError(fmt::format(
      "--gpus {} is for the CUDA cards from 0 on, and {}; drop one of the two", gpus,
      wish.gpu ? fmt::format("--gpu {} names one", *wish.gpu) : std::string("--backend is cpu")));
}

WindowWorkers::WindowWorkers(const std::vector<std::string>& words, int64_t count,
                             const std::filesystem::path& root) {
  for (int64_t card = 1; card <= count; ++card) {
    ChildCommand command;
    command.arguments = {std::filesystem::read_symlink("/proc/self/exe").string()};
    command.arguments.insert(command.arguments.end(), words.begin(), words.end());
    command.arguments.insert(command.arguments.end(),
                             {"--backend", "cuda", "--gpu", fmt::format("{}", card)});
    command.log = root / fmt::format("gpu{}.log", card);
    Worker& worker = *workers_.emplace_back(std::make_unique<Worker>());
    worker.log = command.log;
    worker.thread = std::thread([this, &worker, command] {
      try {
        const ChildResult result = run_child(command, [&](std::string_view) {
          if (stops_ || interrupted()) throw Interrupted();
        });
        if (result.exit_code != 0) worker.failure = result.last_line;
      } catch (const Interrupted&) {
        worker.failure.clear();  // it was ended
      } catch (const std::exception& error) {
        worker.failure = error.what();
      }
      worker.ended = true;
    });
  }
}

WindowWorkers::~WindowWorkers() {
  stops_ = true;
  for (const std::unique_ptr<Worker>& worker : workers_) worker->thread.join();
}

std::vector<std::string> WindowWorkers::failures() const {
  std::vector<std::string> lines;
  for (const std::unique_ptr<Worker>& worker : workers_)
    if (worker->ended && !worker->failure.empty())
      lines.push_back(fmt::format("{}: {}", worker->log.string(), worker->failure));
  return lines;
}

}  // namespace tessera
