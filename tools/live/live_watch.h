// The viewer's side of a training that is watched: its state, scores of its snapshots on held-out
// views, its curves, the request to stop, and the command that resumes it.
#pragma once
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "ingest/files/folders.h"
#include "ingest/scene.h"
#include "tools/live/live_folder.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"

namespace tessera {

/// Scores with the CPU, at the lowest priority and for 1 % of the cores at most: the training may
/// need them. All members may be called from any thread; none throws.
class LiveWatch {
 public:
  /// `served`: the folder that a server shows, in which the run folder lies or which it is.
  /// `resumed_by`: a command; "": that of the run.
  LiveWatch(const std::filesystem::path& run, const std::filesystem::path& served,
            std::string resumed_by);
  LiveWatch(const LiveWatch&) = delete;
  LiveWatch& operator=(const LiveWatch&) = delete;
  ~LiveWatch();

  /// Also renews the request to the training, at most twice a second. JSON: name, alive, state
  /// (as live_folder.h has it, or null), snapshot (address or ""), complete, page (address of
  /// the finished player or ""), stopped {step, total} (null where it runs, is complete or has no
  /// checkpoint), views (as tools/export/page_head.h has them), scores [[step, PSNR in dB]], resume
  /// (a command; "" where `stopped` is null).
  std::string state(int64_t seen);
  /// JSON: the run as report.json has it, by its log so far, with the scores of its snapshots; null
  /// where there is none yet.
  std::string report();
  /// PNG; "" where there is no such view.
  std::string truth(int64_t view) const;
  bool stop();
  /// Whether a page has stopped the training and does not know yet what resumes it.
  bool owes_resume();

 private:
  using Clock = std::chrono::steady_clock;

  void ask(int64_t seen);
  bool is_alive(bool has_state) const;
  void load_views();
  void score_snapshots();
  double score(const std::filesystem::path& file) const;

  const RunFolder run_;
  const LiveFolder folder_;
  const std::filesystem::path served_;
  const std::string name_;  // of that folder
  const TemporaryFolder truths_;

  mutable std::mutex mutex_;
  LiveRequest request_;
  const std::string resumed_by_;
  bool owes_resume_ = false;
  Clock::time_point asked_;
  std::optional<LiveState> last_;  // that the training wrote
  Clock::time_point counted_;
  Scene scene_;  // its held-out frames; not changed once views_ has them
  std::vector<std::string> views_;
  std::vector<std::pair<int64_t, double>> scores_;  // step, dB
  std::string report_ = "null";
  std::pair<uintmax_t, size_t> reported_;  // bytes of the log and scores that it has
  std::condition_variable wake_;
  bool leaves_ = false;
  std::thread thread_;
};

}  // namespace tessera
