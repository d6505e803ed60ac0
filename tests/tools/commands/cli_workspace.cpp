// Calls of the program and the expectations that all tests share.
#include "tests/tools/commands/cli_workspace.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"

namespace tessera::testing {

namespace {

/// `tessera synth object`: a capture of `frames` training views and one in each other split.
/// Made once by each process of tests; its bytes depend on these numbers alone.
std::filesystem::path filmed_object(int frames, int size) {
  static const ScratchFolder made;
  const std::string side = std::to_string(size), name = fmt::format("{}_{}", frames, size);
  if (std::filesystem::exists(made / name)) return made / name;
  const ChildResult result =
      ChildProcess({"synth", "object", "-o", made / name, "--layout", "dnerf", "--frames",
                    std::to_string(frames), "--held-out-frames", "1", "--width", side, "--height",
                    side, "--supersampling", "1", "--points", "50"},
                   made.path())
          .wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return made / name;
}

}  // namespace

CliWorkspace::CliWorkspace() {
  ::setenv("XDG_CACHE_HOME", at("cache").c_str(), 1);  // nothing from other tests, nothing left
  film_object("capture", 2, 32);
}

ChildResult CliWorkspace::run(const std::vector<std::string>& arguments,
                              const ChildLimits& limits) const {
  return ChildProcess(arguments, path(), limits).wait();
}

nlohmann::json CliWorkspace::run_json(std::vector<std::string> arguments) const {
  arguments.push_back("--json");
  const ChildResult result = run(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out, nullptr, false);
  EXPECT_TRUE(json.is_object()) << "stdout is not one JSON object: " << result.out;
  return json;
}

std::vector<std::string> CliWorkspace::train_arguments(const std::string& run,
                                                       const std::vector<std::string>& more) const {
  std::vector<std::string> arguments{"train", at("capture"), "-o", at(run)};
  const std::pair<const char*, const char*> tiny[] = {{"--iterations", "20"},
                                                      {"--init-points", "300"},
                                                      {"--batch", "2"},
                                                      {"--deterministic", "true"}};
  for (const auto& [option, value] : tiny)
    if (std::find(more.begin(), more.end(), option) == more.end())
      arguments.insert(arguments.end(), {option, value});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

ChildResult CliWorkspace::train(const std::string& run_name,
                                const std::vector<std::string>& more) const {
  return run(train_arguments(run_name, more));
}

void CliWorkspace::film_object(const std::string& name, int frames, int size) const {
  std::filesystem::copy(filmed_object(frames, size), folder_ / name,
                        std::filesystem::copy_options::recursive);
}

void CliWorkspace::expect_refused(const std::vector<std::string>& arguments,
                                  const std::vector<std::string>& parts, int exit_code) const {
  const ChildResult result = run(arguments);
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  for (const std::string& part : parts)
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err << "lacks " << part;
}

void CliWorkspace::edit_json(const std::string& name,
                             const std::function<void(nlohmann::json&)>& change) const {
  nlohmann::json json = nlohmann::json::parse(read(name));
  change(json);
  write(name, json.dump());
}

void CliWorkspace::write(const std::string& name, const std::string& bytes) const {
  std::filesystem::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name, std::ios::binary) << bytes;
}

std::string CliWorkspace::read(const std::string& name) const {
  return read_text_file(folder_ / name);
}

WrittenFiles CliWorkspace::written(const std::string& folder, const std::string& name) const {
  WrittenFiles files;
  if (!std::filesystem::exists(folder_ / folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / folder))
    if (entry.path().filename() == name) files[entry.path().string()] = entry.last_write_time();
  return files;
}

}  // namespace tessera::testing
