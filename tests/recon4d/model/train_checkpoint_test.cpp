// A checkpoint restores every bit, and a damaged or foreign file is refused with its name and the
// reason. Source: failure modes E5, E6.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/options/train_options_json.h"
#include "tests/support/checkpoint_bytes.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/tiny_capture.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

class CheckpointFile : public ::testing::Test {
 protected:
  CheckpointFile() : scene_(small_scene()), training_(scene_, options()) {
    training_.run(3);
    save_checkpoint(path(), training_.state(), options(), R"({"device":"cpu"})");
    bytes_ = read_text_file(path());
  }

  static Scene small_scene() {
    Scene scene = tiny_capture({.cameras = 2, .timesteps = 2, .size = 10});
    scene.time_axis = {12.1, 0.3};
    return scene;
  }
  static TrainOptions options() {
    TrainOptions options = tiny_options();
    options.init_points = 12;
    options.sh_degree = 1;
    options.lr_mean = 0.1 + 0.2;
    options.far_plane = 1.0 / 3 + 50;
    return options;
  }
  std::filesystem::path path() const { return folder_ / "run.ckpt"; }

  /// The error of loading such a file; "" when it loads, which the caller reports as a failure.
  std::string refusal(const std::string& bytes) const {
    const std::filesystem::path damaged = folder_ / "damaged.ckpt";
    std::ofstream(damaged, std::ios::binary) << bytes;  // no fsync: thousands of these
    try {
      load_checkpoint(damaged);
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("damaged.ckpt: "), std::string::npos) << message;
      return message;
    }
    return "";
  }

  json header() const { return header_of(bytes_); }
  std::string with_header(const json& changed) const {
    return testing::with_header(bytes_, changed);
  }

  ScratchFolder folder_;
  Scene scene_;
  Training training_;
  std::string bytes_;
};

void expect_says(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' in: " << message;
}

// Bug put back: the statistics are not written; seen to fail.
TEST_F(CheckpointFile, BringsBackEveryBit) {
  const Checkpoint loaded = load_checkpoint(path());
  EXPECT_TRUE(state_bits(loaded.state) == state_bits(training_.state()));
  EXPECT_EQ(loaded.state.seconds, training_.state().seconds);
  EXPECT_EQ(to_json(loaded.options), to_json(options()));
  EXPECT_EQ(loaded.options.lr_mean, 0.1 + 0.2);
  EXPECT_EQ(loaded.provenance, R"({"device":"cpu"})");
  EXPECT_GT(loaded.state.model.static_set.count(), 0);
  EXPECT_GT(loaded.state.model.dynamic_set.count(), 0);

  save_checkpoint(folder_ / "again.ckpt", loaded.state, loaded.options, loaded.provenance);
  EXPECT_TRUE(read_text_file(folder_ / "again.ckpt") == bytes_) << "and writes the same file";
}

// Bug put back: one of for_each_rule left out; seen to fail.
TEST_F(CheckpointFile, KeepsTheDrawingRules) {
  TrainOptions unusual = options();
  unusual.near_plane = 0.125;
  unusual.far_plane = 77.5;
  unusual.sliced_direction = false;
  unusual.truncation_sigma = 2.75;
  unusual.truncation_by_falloff = true;
  unusual.filter_2d = true;
  unusual.time_filter = 0.0375;
  Training training(scene_, unusual);
  training.run(1);
  save_checkpoint(path(), training.state(), unusual, {});
  const DrawingRules loaded = load_checkpoint(path()).state.model.drawing;
  EXPECT_TRUE(loaded == training.model().drawing);
  EXPECT_EQ(loaded.time_filter, 0.0375);
  EXPECT_EQ(loaded.far_plane, 77.5);
}

TEST_F(CheckpointFile, HeaderAlone) {
  const json read = read_checkpoint_header(path());
  EXPECT_EQ(read, header());
  EXPECT_EQ(read["iteration"], 3);
  EXPECT_EQ(read["num_static"], training_.model().static_set.count());
  EXPECT_EQ(read["options"], to_json(options()));
}

/// Every byte of the preamble, some of the header, a few of the arrays.
size_t stride(size_t position) {
  return position < 30 ? 1 : position < 2500 ? 13 : 211;
}

TEST_F(CheckpointFile, TruncatedAnywhere) {
  for (size_t length = 0; length < bytes_.size(); length += stride(length)) {
    const std::string message = refusal(bytes_.substr(0, length));
    ASSERT_NE(message, "") << "loads with " << length << " of " << bytes_.size() << " bytes";
    if (length >= kHeaderAt) expect_says(message, "truncated");
  }
  expect_says(refusal(bytes_ + "x"), "its header promises");
}

// Bugs put back, each seen to fail: no checksum of the header; none of the arrays.
TEST_F(CheckpointFile, FlippedByteAnywhere) {
  for (size_t position = 0; position < bytes_.size(); position += stride(position)) {
    std::string damaged = bytes_;
    damaged[position] = char(damaged[position] ^ 0x04);
    ASSERT_NE(refusal(damaged), "") << "loads with byte " << position << " flipped";
  }
}

TEST_F(CheckpointFile, ForeignFiles) {
  expect_says(refusal(""), "not a Tessera checkpoint");
  expect_says(refusal("ply\nformat ascii 1.0\nelement vertex 0\n"), "not a Tessera checkpoint");
  std::string newer = bytes_;
  newer[8] = 8;
  expect_says(refusal(newer), "checkpoint version 8, this program reads version 7");
  std::string older = bytes_;
  older[8] = 4;
  expect_says(refusal(older), "checkpoint version 4, this program reads version 7; resume it");
  std::string endless = bytes_;
  for (size_t i = 0; i < 8; ++i) endless[kHeaderBytesAt + i] = char(0xff);
  expect_says(refusal(endless), "header incomplete");
  EXPECT_THROW(load_checkpoint(folder_ / "absent.ckpt"), InputError);
  EXPECT_THROW(load_checkpoint(folder_.path()), InputError);
}

// Bug put back: the numbers of the header are used unchecked; seen to fail.
TEST_F(CheckpointFile, ImpossibleHeaders) {
  ASSERT_EQ(refusal(with_header(header())), "") << "the helper itself makes a good file";
  const json numbers[] = {-1, int64_t{1} << 50, int64_t{1} << 39, INT64_MAX, 1e30, "12", nullptr};
  for (const json& number : numbers)
    for (const char* key : {"num_static", "num_dynamic", "sh_coefficients", "exposures"}) {
      json changed = header();
      changed[key] = number;
      EXPECT_NE(refusal(with_header(changed)), "") << key << " = " << number;
    }
  const json whole = header();
  for (const auto& [key, value] : whole.items()) {
    json without = whole;
    without.erase(key);
    expect_says(refusal(with_header(without)), "damaged checkpoint");
  }
  json other = header();
  other["options"]["batches"] = 3;
  expect_says(refusal(with_header(other)), "unknown option 'batches'");
  for (const json& strange : {json::array(), json(5), json("text"), json(nullptr)})
    EXPECT_NE(refusal(with_header(strange)), "") << strange;
  const std::pair<const char*, json> pairs[] = {{"iteration", -1},
                                                {"sampler", {{"epoch", -1}, {"position", 0}}},
                                                {"sampler", {{"epoch", 0}, {"position", -1}}},
                                                {"sh_time_levels", 3},
                                                {"sh_time_levels", 1}};
  for (const auto& [key, value] : pairs) {
    json changed = header();
    changed[key] = value;
    EXPECT_NE(refusal(with_header(changed)), "") << key << " = " << value;
  }
  json drawing = header();
  drawing["drawing"]["sh_degree"] = 4;
  expect_says(refusal(with_header(drawing)), "sh_degree");
  drawing["drawing"].erase("sh_degree");
  expect_says(refusal(with_header(drawing)), "damaged checkpoint");
}

/// Limits the size of files to `bytes` during its lifetime, like a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

// Bug put back: the file is written under its own name; seen to fail. (E6)
TEST_F(CheckpointFile, FailedWriteLeavesThePreviousIntact) {
  training_.run(6);
  std::string message;
  {
    const FullDisk full(2000);
    try {
      save_checkpoint(path(), training_.state(), options(), {});
    } catch (const WriteError& error) {
      message = error.what();
    }
  }
  expect_says(message, "run.ckpt");
  EXPECT_TRUE(read_text_file(path()) == bytes_);
  EXPECT_EQ(load_checkpoint(path()).state.iteration, 3);
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    ++files;
  EXPECT_EQ(files, 1u) << "nothing half-written stays behind";
  save_checkpoint(path(), training_.state(), options(), {});
  EXPECT_EQ(load_checkpoint(path()).state.iteration, 6);
}

TEST_F(CheckpointFile, UnwritablePlacesAreNamed) {
  for (const auto& place : {path() / "below_a_file.ckpt", folder_.path()}) {
    try {
      save_checkpoint(place, training_.state(), options(), {});
      ADD_FAILURE() << place << " was written";
    } catch (const InputError& error) {
      expect_says(error.what(), folder_.path().filename().string());
    }
  }
  EXPECT_TRUE(read_text_file(path()) == bytes_);
}

TEST_F(CheckpointFile, BeforeTheFirstStep) {
  save_checkpoint(path(), first_state(scene_, options()), options(), {});
  Checkpoint loaded = load_checkpoint(path());
  Training a(scene_, options(), std::move(loaded.state));
  Training b(scene_, options());
  a.run(2);
  b.run(2);
  EXPECT_TRUE(state_bits(a.state()) == state_bits(b.state()));
}

}  // namespace
}  // namespace tessera::testing
