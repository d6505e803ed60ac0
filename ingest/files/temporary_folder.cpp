// Makes the folder below TMPDIR.
#include "ingest/files/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>

#include "ingest/files/write_failure.h"
#include "kernels/base/errors.h"

namespace tessera {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder(const std::string& purpose) {
  std::string name = (fs::temp_directory_path() / ("tessera_" + purpose + "_XXXXXX")).string();
  if (mkdtemp(name.data()) == nullptr) {
    if (!path_is_at_fault(errno)) fail_to_write(fs::temp_directory_path(), errno);
    throw InputError(name + ": cannot be made; set TMPDIR to a folder that can be written");
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace tessera
