// Prints a line for every finished run and every failure of a batch while the engine works.
#pragma once
#include <chrono>
#include <filesystem>
#include <set>
#include <string>

#include "tools/batch/batch_folder.h"

namespace tessera {

class BatchWatch {
 public:
  /// Results that exist already are not printed.
  explicit BatchWatch(std::filesystem::path out);
  /// Looks every two seconds, or less often where that takes long, however often it is called.
  void tick();
  /// Looks now.
  void look();

 private:
  void tell_runs(const BatchFolder& batch);
  void tell_failures(const BatchFolder& batch);

  std::filesystem::path out_;
  std::set<std::filesystem::path> done_;
  std::set<std::string> failures_;
  std::chrono::steady_clock::time_point looked_;
  std::chrono::steady_clock::duration between_{};
  bool silent_ = true;
};

}  // namespace tessera
