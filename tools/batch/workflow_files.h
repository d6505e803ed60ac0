// What: the workflow that `tessera batch` gives to its engine, as the program carries it.
// Not: the workflow itself (Snakefile), nor running it (engine.h).
#pragma once
#include <filesystem>
#include <string_view>
#include <vector>

namespace tessera {

struct WorkflowFile {
  std::string_view path;  // below the workflow's folder: "Snakefile", "profiles/slurm/config.yaml"
  std::string_view bytes;
};
const std::vector<WorkflowFile>& workflow_files();

/// Writes them below `folder`; scripts (#!) may be executed. A file that is there with the same
/// bytes is left alone. Errors: InputError: the folder cannot be written.
void write_workflow(const std::filesystem::path& folder);

}  // namespace tessera
