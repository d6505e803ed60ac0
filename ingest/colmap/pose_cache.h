// Results of COLMAP that are kept beyond the output they were made for, so that a preparation of
// the same images, as by `run` after `doctor`, need not run it again.
#pragma once
#include <filesystem>
#include <string>

#include "ingest/colmap/colmap_workspace.h"

namespace tessera {

class PoseCache {
 public:
  static constexpr size_t kMost = 10;  // results that are kept; the least recently used ones go

  /// `folder`: one sub-folder for each result; empty: nothing is kept and nothing is found.
  explicit PoseCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Puts the result that is kept under `key` into `work`, which is empty but for its log; false
  /// where there is none, or where it cannot be read: `work` is empty then.
  bool fetch(const std::string& key, const ColmapWorkspace& work) const;
  /// Keeps models and keys of `work`, without images and database. Errors: none: a cache that
  /// cannot be written is no reason to fail.
  void keep(const std::string& key, const ColmapWorkspace& work) const;

 private:
  void remove_oldest() const;

  std::filesystem::path folder_;
};

}  // namespace tessera
