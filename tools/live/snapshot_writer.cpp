// The thread that encodes a snapshot.
#include "tools/live/snapshot_writer.h"

#include <exception>
#include <utility>

#include "kernels/base/parallel.h"
#include "tools/live/low_priority.h"

namespace tessera {
namespace {

constexpr int kNiceOfSnapshots = 10;

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
    lower_priority(kNiceOfSnapshots);
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
