// The lock of a run folder, beside programs that ask whether it is taken.
#include "tools/session/locks.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

// Bug put back: the lock is tried once, while a program that asks may hold it; seen to fail.
TEST(Locks, AreTakenBesideProgramsThatAskForThem) {
  const ScratchFolder scratch;
  SessionObserver silent;
  std::atomic<bool> ends = false;
  std::thread asking([&] {
    while (!ends) is_run_locked(scratch.path());
  });
  for (int i = 0; i < 3000 && !HasFailure(); ++i)
    EXPECT_NO_THROW(RunLock(scratch.path(), silent)) << i;
  ends = true;
  asking.join();
}

TEST(Locks, AreRefusedWhereAnotherTrains) {
  const ScratchFolder scratch;
  SessionObserver silent;
  EXPECT_FALSE(is_run_locked(scratch.path()));
  const RunLock lock(scratch.path(), silent);
  EXPECT_TRUE(is_run_locked(scratch.path()));
  EXPECT_THROW(RunLock(scratch.path(), silent), InputError);
}

// Bugs put back, each seen to fail: a name that is taken; a lock file that stays in what is kept.
TEST(Locks, OfAFolderThatMakesRoomAreThoseOfTheNewOne) {
  const ScratchFolder scratch;
  SessionObserver silent;
  const fs::path run = scratch / "run";
  fs::create_directories(scratch / "run.1");
  {
    RunLock lock(run, silent);
    write_text_file(run / "model.ply", "hours");
    EXPECT_EQ(lock.make_room(), scratch / "run.2");
    EXPECT_TRUE(is_run_locked(run));
    EXPECT_FALSE(is_run_locked(scratch / "run.2"));
    EXPECT_EQ(read_text_file(scratch / "run.2/model.ply"), "hours");
    EXPECT_FALSE(fs::exists(scratch / "run.2/lock"));
    EXPECT_THROW(RunLock(run, silent), InputError);
  }
  EXPECT_FALSE(fs::exists(run)) << "nothing was written";
}

}  // namespace
}  // namespace tessera::testing
