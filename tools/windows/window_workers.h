// Further programs that train windows of the same folder, one for each further card.
#pragma once
#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tools/cli/train_arguments.h"

namespace tessera {

/// The words of `tessera train` for these arguments, without scene, folder and device.
std::vector<std::string> words_of(const TrainArguments& arguments);

/// --gpus.
void add_gpus_option(CLI::App& command, int64_t& gpus);
/// Errors: InputError: several cards for a training on the CPU, or on one card that is named.
void check_gpus(int64_t gpus, const std::string& backend);

class WindowWorkers {
 public:
  /// Starts `count` of them on the cards 1 to `count`; this program has card 0. `words`: their
  /// command from "train" on. Their output goes to gpu1.log, … in `root`.
  WindowWorkers(const std::vector<std::string>& words, int64_t count,
                const std::filesystem::path& root);
  WindowWorkers(const WindowWorkers&) = delete;
  WindowWorkers& operator=(const WindowWorkers&) = delete;
  /// Ends those that still work; they leave checkpoints.
  ~WindowWorkers();

  /// One line on each that has ended with an error; call it when all windows are trained.
  std::vector<std::string> failures() const;

 private:
  struct Worker {
    std::thread thread;
    std::filesystem::path log;
    std::atomic<bool> ended{false};
    std::string failure;  // once it has ended
  };
  std::vector<std::unique_ptr<Worker>> workers_;
  std::atomic<bool> stops_{false};
};

}  // namespace tessera
