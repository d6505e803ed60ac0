// An empty folder of this process among the temporary files, removed with all in it.
#pragma once
#include <filesystem>
#include <string>

namespace tessera {

class TemporaryFolder {
 public:
  /// Only its owner can enter it; `purpose` is a part of its name. Errors: InputError or WriteError
  /// where there is no place for it.
  explicit TemporaryFolder(const std::string& purpose);
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace tessera
