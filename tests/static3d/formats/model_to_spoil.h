// A model's file, and copies of it in which one text is replaced by another.
#pragma once
#include "recon4d/model/model_file.h"
#include "tests/ingest/layouts/capture_fixture.h"

namespace tessera::testing {

class ModelToSpoil {
 public:
  explicit ModelToSpoil(const GaussianModel& model) {
    save_model(folder_ / "model.ply", model);
    bytes_ = read_bytes(folder_ / "model.ply");
  }
  const std::string& bytes() const { return bytes_; }
  /// changed.ply with these bytes.
  std::filesystem::path written(const std::string& bytes) const {
    write_bytes(folder_ / "changed.ply", bytes);
    return folder_ / "changed.ply";
  }
  /// changed.ply with the first `from` replaced.
  std::filesystem::path with(const std::string& from, const std::string& to) const {
    std::string changed = bytes_;
    return written(changed.replace(changed.find(from), from.size(), to));
  }

 private:
  TemporaryFolder folder_;
  std::string bytes_;
};

}  // namespace tessera::testing
