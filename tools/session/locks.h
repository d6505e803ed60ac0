// Locks of folders. A run folder is written by one training at a time. A prepared scene may be read
// by many programs, and is replaced only while no other program uses it. A lock that another
// program has is an error; one that it holds only to ask for it is waited for.
#pragma once
#include <filesystem>

#include "tools/session/session_observer.h"

namespace tessera {

/// Holds an flock on FOLDER/lock, which names its holder: the kernel releases it when the program
/// ends in whatever way. Makes the folder where there is none; what it made and no program filled
/// goes with it.
class RunLock {
 public:
  /// Errors: InputError: another program has the lock (names it), the folder cannot be written.
  /// A file system without locks is a warning.
  RunLock(const std::filesystem::path& folder, SessionObserver& observer);
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  ~RunLock();

  /// Makes room for another result: the folder, with all that is in it, becomes FOLDER.1, or has
  /// the next number that is free. The lock is then that of a new, empty folder in its place.
  /// Returns the new name. Errors: InputError or WriteError: it cannot be renamed.
  std::filesystem::path make_room();

 private:
  void lock();
  bool take();

  SessionObserver& observer_;
  std::filesystem::path file_;
  bool made_folder_ = false;
  int descriptor_ = -1;
};

/// Whether a program has the lock of this folder, so that a training writes it now. Where the file
/// system has no locks nobody has, as RunLock goes on without.
bool is_run_locked(const std::filesystem::path& folder);

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
