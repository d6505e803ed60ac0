// What: a scene that is being read is not replaced, and one that is being replaced is not read.
// Not: a file in the scene: the lock is an flock on the scene's own description, which a capture
//      that may not be written to has as well.
#pragma once
#include <filesystem>

namespace tessera {

/// The kernel gives the lock back when the program ends in whatever way.
class SceneLock {
 public:
  enum class Use { kRead, kReplace };

  /// Locks nothing where `scene` is no scene, or lies on a file system without locks. Errors:
  /// InputError: another program replaces the scene, or for kReplace has it in use (names it).
  SceneLock(const std::filesystem::path& scene, Use use);
  SceneLock(const SceneLock&) = delete;
  SceneLock& operator=(const SceneLock&) = delete;
  ~SceneLock();

 private:
  int descriptor_ = -1;
};

}  // namespace tessera
