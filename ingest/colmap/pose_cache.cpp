// Copies folders. A result appears under its key by a renaming, and the file that makes a workspace
// known, key.txt, is copied last, so that no part of a result is taken for one.
#include "ingest/colmap/pose_cache.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "ingest/files/folders.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// What the readers of a known workspace look at.
void copy_result(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  for (const char* name : {"sparse", "refined/chosen", "points", "key.txt"}) {
    if (!fs::exists(from / name)) continue;
    fs::create_directories((to / name).parent_path());
    fs::copy(from / name, to / name,
             fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
}

}  // namespace

bool PoseCache::fetch(const std::string& key, const ColmapWorkspace& work) const {
  if (folder_.empty() || !fs::exists(folder_ / key / "key.txt")) return false;
  try {
    copy_result(folder_ / key, work.folder);
    fs::last_write_time(folder_ / key, fs::file_time_type::clock::now());
    return true;
  } catch (const fs::filesystem_error&) {
    work.clear();
    return false;
  }
}

void PoseCache::keep(const std::string& key, const ColmapWorkspace& work) const {
  if (folder_.empty() || fs::exists(folder_ / key)) return;
  const fs::path staging = folder_ / staging_name(key);
  std::error_code ignored;
  try {
    copy_result(work.folder, staging);
    fs::rename(staging, folder_ / key);
    remove_oldest();
  } catch (const fs::filesystem_error&) {
    fs::remove_all(staging, ignored);
  }
}

void PoseCache::remove_oldest() const {
  std::vector<std::pair<fs::file_time_type, fs::path>> kept;
  for (const auto& entry : fs::directory_iterator(folder_))
    if (entry.is_directory() && !entry.path().filename().string().starts_with('.'))
      kept.emplace_back(entry.last_write_time(), entry.path());
  std::sort(kept.begin(), kept.end());
  for (size_t i = 0; i + kMost < kept.size(); ++i) fs::remove_all(kept[i].second);
}

}  // namespace tessera
