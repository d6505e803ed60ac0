// What: open, flock, and who holds it, from /proc/locks.
// Not: waiting: who comes second leaves.
#include "tools/session/scene_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "ingest/files/folders.h"
#include "kernels/base/errors.h"
#include "tools/session/locked_file.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The file that makes the folder a scene; empty where there is none.
fs::path description_of(const fs::path& scene) {
  for (const char* name : {"transforms.json", "transforms_train.json"})
    if (std::error_code absent; fs::is_regular_file(scene / name, absent)) return scene / name;
  return {};
}

/// For writing where that is allowed: NFS grants exclusive locks on such descriptors only.
int open_description(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  return descriptor >= 0 ? descriptor : ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
}

/// "process 12 on HOST"; programs of other machines are not known by number.
std::string holders_of(int descriptor) {
  struct stat locked {};
  if (::fstat(descriptor, &locked) != 0) return "another program";
  const std::string inode = fmt::format(":{}", locked.st_ino);
  std::vector<std::string> processes;
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, advisory, access, process, file;
    words >> number >> kind >> advisory >> access >> process >> file;
    if (kind == "FLOCK" && file.ends_with(inode)) processes.push_back(process);
  }
  if (processes.empty()) return "a program on another machine";
  return fmt::format("process {} on {}", fmt::join(processes, ", "), host_name());
}

[[noreturn]] void refuse(const fs::path& scene, SceneLock::Use use, const std::string& who) {
  if (use == SceneLock::Use::kRead)
    throw InputError(fmt::format("{}: {} is replacing this scene; wait until it has ended",
                                 scene.string(), who));
  throw InputError(
      fmt::format("{}: {} has this scene in use; wait until it has ended or stop it, or choose "
                  "another folder with -o",
                  scene.string(), who));
}

}  // namespace

SceneLock::SceneLock(const fs::path& scene, Use use) {
  const int kind = (use == Use::kRead ? LOCK_SH : LOCK_EX) | LOCK_NB;
  for (fs::path file; !(file = description_of(scene)).empty();) {
    descriptor_ = open_description(file);
    if (descriptor_ < 0) return;  // the scene's reader says why
    if (::flock(descriptor_, kind) != 0) {
      if (errno != EWOULDBLOCK) return;  // no locks here
      const std::string who = holders_of(descriptor_);
      ::close(descriptor_);
      refuse(scene, use, who);
    }
    if (is_file_of_name(descriptor_, file)) return;
    ::close(std::exchange(descriptor_, -1));
  }
}

SceneLock::~SceneLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace tessera
