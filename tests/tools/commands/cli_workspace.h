// A scratch folder with a tiny synthetic capture, and the program run in it.
#pragma once
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"
#include "tests/tools/commands/child_process.h"

namespace tessera::testing {

/// At the beginning of a test that prepares captures.
#define TESSERA_SKIP_WITHOUT_INGEST() \
  if (!TESSERA_HAS_INGEST) GTEST_SKIP() << "the trainer-only build prepares no captures"

/// Files by when they were written.
using WrittenFiles = std::map<std::string, std::filesystem::file_time_type>;

class CliWorkspace {
 public:
  /// Makes `capture`: two training views and one in each of val and test, 32 × 32 RGBA.
  CliWorkspace();

  std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  const std::filesystem::path& path() const { return folder_.path(); }

  ChildResult run(const std::vector<std::string>& arguments, const ChildLimits& limits = {}) const;
  /// The one JSON object on stdout; fails the test when the command does or when there is more.
  nlohmann::json run_json(std::vector<std::string> arguments) const;
  /// `tessera train capture -o run` with the options of a tiny training in front of `more`, whose
  /// bytes are the same on every call.
  std::vector<std::string> train_arguments(const std::string& run,
                                           const std::vector<std::string>& more = {}) const;
  ChildResult train(const std::string& run, const std::vector<std::string>& more = {}) const;

  /// `tessera synth object -o name`: a capture of `frames` training views and one held out.
  void film_object(const std::string& name, int frames, int size) const;

  /// `exit_code`, nothing on stdout, one line on stderr that contains every part.
  void expect_refused(const std::vector<std::string>& arguments,
                      const std::vector<std::string>& parts, int exit_code = 2) const;
  /// Changes a JSON file of the workspace.
  void edit_json(const std::string& name, const std::function<void(nlohmann::json&)>& change) const;
  void write(const std::string& name, const std::string& bytes) const;
  std::string read(const std::string& name) const;
  /// All files of that name below a folder; none where there is no such folder.
  WrittenFiles written(const std::string& folder, const std::string& name) const;

 private:
  ScratchFolder folder_;
};

}  // namespace tessera::testing
