// The thread that encodes a snapshot.
#include "tools/live/snapshot_writer.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <ctime>
#include <exception>
#include <utility>

#include "kernels/base/serial_section.h"

namespace tessera {
namespace {

constexpr int kNice = 10;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

}  // namespace

SnapshotWriter::SnapshotWriter(LiveFolder folder, TrainOptions options, Tessera4dOptions file)
    : folder_(std::move(folder)), options_(std::move(options)), file_(std::move(file)) {}

SnapshotWriter::~SnapshotWriter() {
  if (thread_.joinable()) thread_.join();
}

void SnapshotWriter::start(TrainState state, int64_t number) {
  if (thread_.joinable()) thread_.join();
  busy_ = true;
  thread_ = std::thread([this, number, held = std::move(state)]() mutable {
    // of this thread alone: Linux has a priority for each
    setpriority(PRIO_PROCESS, id_t(::syscall(SYS_gettid)), kNice);
    const double begin = thread_seconds();
    try {
      write(held, number);
      failure_.clear();
    } catch (const std::exception& error) {  // the training continues without it
      failure_ = error.what();
    }
    seconds_ = thread_seconds() - begin;
    busy_ = false;
  });
}

void SnapshotWriter::write(TrainState& state, int64_t number) {
  const SerialSection serial;
  const GaussianModel model = baked_model(std::move(state), options_);
  if (!folder_.write_snapshot(number, single_tessera4d(encode_tessera4d(model, file_)))) return;
  written_ = number;
  std::error_code absent;
  std::filesystem::remove(folder_.snapshot(number - 2), absent);
}

}  // namespace tessera
