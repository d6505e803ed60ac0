// Failure modes of every format that is written: the values that a player reads, a second export,
// values that are never written, names, and interrupted writes. Source: failure modes E1, E2, E3,
// E4, E6, E7.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "recon4d/model/model_file.h"
#include "static3d/formats/frame_sequence.h"
#include "static3d/formats/splat_file.h"
#include "static3d/tessera4d/tessera4d.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"
#include "tests/static3d/formats/splat_comparison.h"
#include "tests/support/lift.h"
#include "tests/support/tessera4d_input.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

struct NamedFormat {
  std::string name;
  SplatFormat format;
};

/// All of frames, .spz in both versions.
std::vector<NamedFormat> all_formats() {
  std::vector<NamedFormat> formats;
  for (const SplatFormat& format : splat_formats())
    if (is_built(format)) formats.push_back({format.name, format});
  formats.push_back({"spz 4", spz_format(4)});
  return formats;
}

/// Quaternions of length 1, colours that every format can hold.
GaussianModel plain_model(int64_t fixed, int64_t moving) {
  GaussianModel model = random_model(fixed, moving);
  for (GaussianSet* set : {&model.static_set, &model.dynamic_set}) {
    const GaussianSpans<float> values = set->values();
    for (int64_t n = 0; n < set->count(); ++n) {
      for (int i = 0; i < 48; ++i)
        values.at(kSh, n)[i] = std::clamp(values.at(kSh, n)[i], -0.9f, 0.9f);
      for (const Group group : {kRotation, kRotationRight}) {
        if (group == kRotationRight && set == &model.static_set) continue;
        float* const q = values.at(group, n);
        const float norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (int k = 0; k < 4; ++k) q[k] /= norm;
      }
    }
  }
  return model;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

nlohmann::json manifest_of(const fs::path& folder) {
  return nlohmann::json::parse(read_text_file(folder / "manifest.json"));
}

double largest_difference(const RenderedImage& a, const RenderedImage& b) {
  double worst = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i)
    worst = std::max(worst, std::abs(double(a.rgb[i]) - double(b.rgb[i])));
  return worst;
}

View view_at(double time) {
  View view = three_views()[0];
  view.time = time;
  return view;
}

/// Largest difference of a channel of an image, of 1: about 1.5 × what is measured here (ply 0,
/// compressed 0.0169, spz 0.0652, sog 0.189, splat 0.0033, 4D 0.0157, lossless 0), and what causes
/// it.
const std::map<std::string, double> kRoundTrip = {
    {"ply", 1e-4},
    {"compressed", 0.03},  // SH in 1/32
    {"spz", 0.1},          // SH in 1/8
    {"spz 4", 0.1},
    {"sog", 0.3},  // SH of random Gaussians, some of which share an entry of the palette
    {"glb", 1e-4},
    {"splat", 0.005},  // quaternions in 1/128; compared without view-dependent colour
    {"4d", 0.025},
};

// Failure mode E1: the trainer's render at t against that of the exported frame t. Bug put back:
// frames sliced at index/T instead of their time; seen to fail for each.
TEST(FormatModes, E1FramesLookLikeTheModel) {
  const TemporaryFolder folder;
  GaussianModel model = plain_model(40, 60);
  const std::vector<double> times = {0, 0.35, 1};
  for (const auto& [name, format] : all_formats()) {
    SCOPED_TRACE(name);
    model.drawing.sh_degree = name == "splat" ? 0 : 3;
    export_sequence(model, folder / name, times, format);
    double worst = 0;
    for (size_t i = 0; i < times.size(); ++i) {
      SplatFile frame = load_splat_file(folder / name / sequence_file_name(int64_t(i), 3, format));
      EXPECT_TRUE(frame.warnings.empty()) << frame.warnings.front();
      const RenderedImage shown =
          render_one(static_model(model, std::move(frame.set)), view_at(times[i]));
      worst = std::max(worst, largest_difference(shown, render_one(model, view_at(times[i]))));
    }
    EXPECT_LE(worst, kRoundTrip.at(name));
  }
}

// The same for the file that holds time. Bug put back: means of the clip's beginning taken for
// those of each Gaussian's own timestep; seen to fail.
TEST(FormatModes, E1TheFileThatHoldsTimeLooksLikeTheModel) {
  const TemporaryFolder folder;
  GaussianModel model = plain_model(40, 60);
  for (int64_t n = 0; n < 60; n += 3) {  // drawn in the clip, at their own timestep out of it
    model.dynamic_set.group(kMeanTime).value[n] = n % 2 == 0 ? -0.3f : 1.3f;
    model.dynamic_set.group(kLogScaleTime).value[n] = std::log(0.5f);
  }
  for (const bool lossless : {true, false}) {
    Tessera4dOptions options;
    options.lossless = lossless;
    write_tessera4d_folder(folder / "4d", encode_tessera4d(model, options));
    const GaussianModel read = load_tessera4d(folder / "4d").model;
    double worst = 0;
    for (const double time : {0.0, 0.35, 1.0})
      worst = std::max(worst, largest_difference(render_one(read, view_at(time)),
                                                 render_one(model, view_at(time))));
    EXPECT_LE(worst, lossless ? 1e-4 : kRoundTrip.at("4d"));
  }
}

// Failure mode E2: files that were read and written again. Exact formats stay as they are; rounded
// ones do not drift: the sixth looks as much like the model as the first must. Bugs put back, each
// seen to fail: quaternions normalised that are of length 1 already (ply); colours rounded down
// (compressed, spz).
TEST(FormatModes, E2ASecondExportIsTheSame) {
  constexpr int kGenerations = 6;
  const TemporaryFolder folder;
  GaussianModel model = plain_model(700, 0);  // three chunks of the compressed file
  const View view = view_at(0);
  for (const auto& [name, format] : all_formats()) {
    SCOPED_TRACE(name);
    model.drawing.sh_degree = name == "splat" ? 0 : 3;
    const RenderedImage expected = render_one(model, view);
    save_splat_file(format, folder / fmt::format("0{}", format.extension), model.static_set, {3});
    std::string before = read_text_file(folder / fmt::format("0{}", format.extension));
    double worst = 0;
    for (int i = 1; i < kGenerations; ++i) {
      SplatFile read = load_splat_file(folder / fmt::format("{}{}", i - 1, format.extension));
      EXPECT_TRUE(read.warnings.empty());
      const fs::path path = folder / fmt::format("{}{}", i, format.extension);
      save_splat_file(format, path, read.set, read.drawing);
      const std::string bytes = read_text_file(path);
      if (name == "ply" || (name == "splat" && i > 1)) {
        EXPECT_TRUE(bytes == before) << "generation " << i;
      }
      EXPECT_EQ(read.set.count(), 700);
      before = bytes;
      read.set = load_splat_file(path).set;
      worst = std::max(
          worst,
          largest_difference(render_one(static_model(model, std::move(read.set)), view), expected));
    }
    EXPECT_LE(worst, kRoundTrip.at(name));
  }
}

/// A model with one row of each kind that must not be written, and one far away.
GaussianModel spoilt_model() {
  GaussianModel model = plain_model(40, 40);
  model.static_set.group(kMean).value[0] = NAN;
  model.static_set.group(kSh).value[48 + 7] = INFINITY;
  model.dynamic_set.group(kLogScale).value[3] = -INFINITY;
  model.static_set.group(kMean).value[3 * 3] = 1000;  // far outside
  for (int64_t n = 0; n < 40; ++n) {
    model.dynamic_set.group(kMeanTime).value[n] = 0.5f;
    model.dynamic_set.group(kOpacityLogit).value[n] = 2;
  }
  for (int64_t n = 0; n < 40; ++n) model.static_set.group(kOpacityLogit).value[n] = 2;
  return model;
}

// Failure mode E3. Bug put back: is_valid_element always true; seen to fail for each.
TEST(FormatModes, E3NothingBrokenIsWritten) {
  const TemporaryFolder folder;
  const GaussianModel model = spoilt_model();
  for (const auto& [name, format] : all_formats()) {
    SCOPED_TRACE(name);
    const SequenceReport report = export_sequence(model, folder / name, {0.5}, format);
    const nlohmann::json manifest = manifest_of(folder / name);
    EXPECT_EQ(report.non_finite, 3);
    EXPECT_EQ(manifest["counters"]["non_finite"], 3);
    EXPECT_EQ(manifest["counters"]["far_outliers"], 1);
    EXPECT_LT(double(manifest["bounds"]["max"][0]), 10);
    const fs::path file = folder / name / sequence_file_name(0, 1, format);
    const SplatFile read = load_splat_file(file);
    EXPECT_TRUE(read.warnings.empty()) << "the reader left something out";
    EXPECT_EQ(read.set.count(), report.frames[0].gaussians);
    EXPECT_EQ(read.set.count(), 77 - report.out_of_range);
    EXPECT_EQ(report.out_of_range, name == "compressed" ? 1 : 0);
  }
  const Tessera4dFile file = encode_tessera4d(model, {});
  EXPECT_EQ(file.non_finite, 3);
  EXPECT_EQ(nlohmann::json::parse(file.manifest)["dropped"]["non_finite"], 3);
  EXPECT_EQ(file.far_outliers, 1);
}

// Failure modes E4 and E7. Bugs put back, each seen to fail: names without padding; constant_ids
// left out of the manifest.
TEST(FormatModes, E4NamesSortByTimeAndE7IdsAreNotPromised) {
  const TemporaryFolder folder;
  const GaussianModel model = plain_model(2, 2);
  for (const auto& [name, format] : all_formats())
    for (const int64_t count : {12, 3}) {  // the shorter one replaces the longer
      SCOPED_TRACE(name);
      std::vector<double> times;
      for (int64_t i = 0; i < count; ++i) times.push_back(double(i) / double(count - 1));
      export_sequence(model, folder / name, times, format);
      const std::vector<std::string> files = names_in(folder / name);
      const nlohmann::json manifest = manifest_of(folder / name);
      ASSERT_EQ(files.size(), size_t(count) + 1);
      ASSERT_EQ(manifest["frames"].size(), size_t(count));
      EXPECT_EQ(manifest["count"], count);
      EXPECT_EQ(manifest["constant_ids"], false);
      for (size_t i = 0; i < size_t(count); ++i) {
        EXPECT_EQ(files[i], fmt::format("frame_{:04}{}", i, format.extension));
        EXPECT_EQ(manifest["frames"][i]["file"], files[i]);
        EXPECT_EQ(manifest["frames"][i]["time"], times[i]);
      }
    }
}

enum class End { kDone, kRefused, kKilled, kOther };

/// `write` in a child whose files may have `limit` bytes. With `kill` the system ends it in the
/// middle of the write that passes the limit; else that write fails as on a full disk.
End write_limited(const std::function<void()>& write, rlim_t limit, bool kill) {
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit none{0, 0}, limits{limit, limit};
    ::setrlimit(RLIMIT_CORE, &none);
    std::signal(SIGXFSZ, kill ? SIG_DFL : SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &limits);
    int status = 0;
    try {
      write();
    } catch (const WriteError&) {
      status = 3;
    }
    ::_exit(status);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) return End::kKilled;
  return WEXITSTATUS(status) == 0   ? End::kDone
         : WEXITSTATUS(status) == 3 ? End::kRefused
                                    : End::kOther;
}

using Writer = std::function<void(const fs::path&, const GaussianModel&)>;

/// All that write models; each makes the one file at the path that is checked.
std::vector<std::pair<std::string, Writer>> all_writers() {
  std::vector<std::pair<std::string, Writer>> writers;
  for (const auto& [name, format] : all_formats())
    writers.emplace_back(name, [format = format](const fs::path& path, const GaussianModel& model) {
      save_splat_file(format, path, model.static_set, {3});
    });
  writers.emplace_back("model", save_model);
  writers.emplace_back("tessera-4d", [](const fs::path& path, const GaussianModel& model) {
    write_text_file(path, single_tessera4d(encode_tessera4d(model, {})));
  });
  return writers;
}

// Failure mode E6. Bug put back: AtomicFile writes to the target itself; seen to fail for each.
TEST(FormatModes, E6AnInterruptedWriteLeavesTheFileBefore) {
  const GaussianModel first = plain_model(3, 3), larger = plain_model(300, 300);
  for (const auto& [name, write] : all_writers()) {
    SCOPED_TRACE(name);
    const TemporaryFolder folder;
    const fs::path path = folder / "file";
    write(path, first);
    const std::string before = read_text_file(path);
    const auto again = [&, &write = write] { write(path, larger); };
    EXPECT_EQ(write_limited(again, 4000, false), End::kRefused);
    EXPECT_TRUE(read_text_file(path) == before);
    EXPECT_EQ(names_in(folder.path()).size(), 1u) << "a temporary file stayed";
    EXPECT_EQ(write_limited(again, 4000, true), End::kKilled);
    EXPECT_TRUE(read_text_file(path) == before);
    EXPECT_EQ(write_limited(again, 1 << 24, false), End::kDone);
    EXPECT_FALSE(read_text_file(path) == before);
  }
}

}  // namespace
}  // namespace tessera::testing
