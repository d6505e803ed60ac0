// The lock of a run folder, beside programs that ask whether it is taken.
#include "tools/session/locks.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "kernels/base/errors.h"
#include "tests/support/scratch_folder.h"

namespace tessera::testing {
namespace {

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

}  // namespace
}  // namespace tessera::testing
