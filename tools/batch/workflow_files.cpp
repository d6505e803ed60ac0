// What: the files of tools/batch, read by the assembler into the program.
// Not: which files these are (CMakeLists.txt).
#include "tools/batch/workflow_files.h"

#include "ingest/files/atomic_file.h"

#define WORKFLOW_FILE(number, path, source)                  \
  asm(".pushsection .rodata\n"                               \
      ".global tessera_workflow_" #number                    \
      "_begin\n"                                             \
      ".global tessera_workflow_" #number                    \
      "_end\n"                                               \
      "tessera_workflow_" #number                            \
      "_begin:\n"                                            \
      ".incbin \"" source                                    \
      "\"\n"                                                 \
      "tessera_workflow_" #number                            \
      "_end:\n"                                              \
      ".byte 0\n"                                            \
      ".popsection\n");                                      \
  extern "C" const char tessera_workflow_##number##_begin[]; \
  extern "C" const char tessera_workflow_##number##_end[];
#include "tools/batch/workflow_table.inc"
#undef WORKFLOW_FILE

namespace tessera {

namespace fs = std::filesystem;

const std::vector<WorkflowFile>& workflow_files() {
#define WORKFLOW_FILE(number, path, source) \
  {path,                                    \
   {tessera_workflow_##number##_begin,      \
    size_t(tessera_workflow_##number##_end - tessera_workflow_##number##_begin)}},
  static const std::vector<WorkflowFile> files = {
#include "tools/batch/workflow_table.inc"
  };
#undef WORKFLOW_FILE
  return files;
}

void write_workflow(const fs::path& folder) {
  for (const WorkflowFile& file : workflow_files()) {
    const fs::path target = folder / file.path;
    if (!fs::is_regular_file(target) || read_text_file(target) != file.bytes)
      write_text_file(target, file.bytes);
    if (file.bytes.starts_with("#!"))
      fs::permissions(target,
                      fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                      fs::perm_options::add);
  }
}

}  // namespace tessera
