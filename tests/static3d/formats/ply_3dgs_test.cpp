// The 3DGS .ply format: third-party files are read, written files are read back, and compressed
// .ply is read. Source: failure modes C1, C5, E2.
#include "static3d/formats/splat_file.h"

#include <fmt/format.h>

#include <array>

#include "ingest/files/ply.h"
#include "kernels/math/spherical_harmonics.h"
#include "recon4d/model/element_edits.h"
#include "static3d/transform/splat_quanta.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {
namespace {

/// One column per name, `rows` rows of small numbers; quaternions (1, 0, 0, 0).
PlyFile foreign_file(int rest, int64_t rows, PlyType type = PlyType::kFloat32) {
  PlyElement vertex{"vertex", rows, {}};
  const auto add = [&](const std::string& name, double value) {
    vertex.columns.push_back({name, type, std::vector<double>(size_t(rows), value)});
  };
  for (const char* name : {"opacity", "x", "y", "z", "scale_2", "scale_1", "scale_0"}) add(name, 1);
  for (int i = 0; i < rest; ++i) add(fmt::format("f_rest_{}", i), i);
  for (const char* name : {"f_dc_0", "f_dc_1", "f_dc_2"}) add(name, 2);
  for (const char* name : {"rot_0", "rot_1", "rot_2", "rot_3"}) add(name, name[4] == '0');
  return {{"by another program"}, {vertex}};
}

PlyColumn& column(PlyFile& file, const std::string& name) {
  for (PlyColumn& c : file.elements[0].columns)
    if (c.name == name) return c;
  throw std::logic_error(name);
}

// Bug put back: f_rest read coefficient-major; seen to fail.
TEST(Ply3dgs, TakesEveryDegreeAnyOrderAndAnyScalarType) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree)
    for (PlyType type : {PlyType::kFloat32, PlyType::kFloat64, PlyType::kInt16}) {
      const int K = sh_coefficients(degree), rest = K - 1;
      write_ply(folder / "a.ply", foreign_file(3 * rest, 2, type));
      const SplatFile read = load_splat_file(folder / "a.ply");
      EXPECT_TRUE(read.warnings.empty());
      EXPECT_EQ(read.drawing.sh_degree, degree);
      ASSERT_EQ(read.set.coefficients(), K);
      ASSERT_EQ(read.set.count(), 2);
      for (int k = 1; k < K; ++k)  // channel-major in the file, RGB innermost here
        for (int c = 0; c < 3; ++c)
          EXPECT_EQ(read.set.values().at(kSh, 1)[3 * k + c], float(c * rest + k - 1));
    }
}

// As `ns-export gaussian-splat --ply-color-mode rgb` of Nerfstudio writes them. Bug put back:
// bytes not divided by 255; seen to fail.
TEST(Ply3dgs, ColoursOfBytesAreHarmonicsOfDegreeZero) {
  const TemporaryFolder folder;
  PlyFile file = foreign_file(0, 1);
  for (int c = 0; c < 3; ++c) {
    PlyColumn& colour = column(file, fmt::format("f_dc_{}", c));
    colour = {std::array{"red", "green", "blue"}[size_t(c)], PlyType::kUint8, {100.0 * c}};
  }
  write_ply(folder / "a.ply", file);
  const SplatFile read = load_splat_file(folder / "a.ply");
  EXPECT_TRUE(read.warnings.empty());
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(0.5 + kSh0 * double(read.set.values().at(kSh, 0)[c]), 100.0 * c / 255, 1e-6);
  column(file, "green").type = PlyType::kFloat32;
  write_ply(folder / "a.ply", file);
  expect_input_error([&] { load_splat_file(folder / "a.ply"); }, {"a.ply", "vertex", "f_dc_1"});
}

TEST(Ply3dgs, NamesWhatIsMissingOrOdd) {
  const TemporaryFolder folder;
  for (const char* name : {"x", "opacity", "scale_2", "rot_3", "f_dc_1"}) {
    PlyFile file = foreign_file(0, 1);
    column(file, name).name = "something";
    write_ply(folder / "a.ply", file);
    expect_input_error([&] { load_splat_file(folder / "a.ply"); }, {"a.ply", "vertex", name});
  }
  write_ply(folder / "a.ply", foreign_file(12, 1));
  expect_input_error([&] { load_splat_file(folder / "a.ply"); },
                     {"a.ply", "12 f_rest", "0, 9, 24"});
  PlyFile faces = foreign_file(0, 1);
  faces.elements[0].name = "face";
  write_ply(folder / "a.ply", faces);
  expect_input_error([&] { load_splat_file(folder / "a.ply"); }, {"a.ply", "no element 'vertex'"});
}

// Failure mode C5. Bug put back: is_valid_element without the test for finite values; seen to fail.
TEST(Ply3dgs, DropsBrokenRowsNormalisesAndReportsIt) {
  const TemporaryFolder folder;
  PlyFile file = foreign_file(9, 6);
  column(file, "y").values[1] = NAN;
  column(file, "f_rest_7").values[2] = INFINITY;
  column(file, "rot_0").values[3] = 0;
  column(file, "rot_0").values[4] = 5;
  column(file, "x").values = {10, 11, 12, 13, 14, 15};
  file.elements[0].columns.push_back({"transform", PlyType::kFloat32, {0, 0, 0, 0, 0, 0}});
  write_ply(folder / "a.ply", file);
  const SplatFile read = load_splat_file(folder / "a.ply");
  ASSERT_EQ(read.set.count(), 3);
  EXPECT_EQ(read.set.values().at(kMean, 0)[0], 10);
  EXPECT_EQ(read.set.values().at(kMean, 1)[0], 14);
  EXPECT_EQ(read.set.values().at(kMean, 2)[0], 15);
  EXPECT_EQ(*read.set.values().at(kRotation, 1), 1);
  ASSERT_EQ(read.warnings.size(), 3u);
  EXPECT_NE(read.warnings[0].find("ignored: transform"), std::string::npos);
  EXPECT_NE(read.warnings[1].find("3 of 6 Gaussians dropped"), std::string::npos);
  EXPECT_NE(read.warnings[2].find("1 quaternions"), std::string::npos);
}

// Failure mode E2. Bug put back: quaternions normalised at each write; seen to fail.
TEST(Ply3dgs, WritesTheSameBytesAfterARoundTrip) {
  const TemporaryFolder folder;
  for (int degree = 0; degree <= 3; ++degree) {
    const GaussianModel model = random_model(500, 0, 40 + uint64_t(degree));
    EXPECT_EQ(save_splat_file(splat_format("ply"), folder / "a.ply", model.static_set, {degree}),
              0);
    const SplatFile read = load_splat_file(folder / "a.ply");
    EXPECT_TRUE(read.warnings.empty());
    EXPECT_EQ(read.drawing.sh_degree, degree);
    EXPECT_EQ(save_splat_file(splat_format("ply"), folder / "b.ply", read.set, {degree}), 0);
    EXPECT_EQ(read_bytes(folder / "a.ply"), read_bytes(folder / "b.ply"));
    GaussianModel cut = clone(model);
    cut.drawing.sh_degree = degree;
    expect_same_image(render_one(static_model(cut, read.set.clone_values()), three_views()[0]),
                      render_one(cut, three_views()[0]));
  }
}

TEST(Ply3dgs, HasTheLayoutOfTheReferenceCode) {
  const TemporaryFolder folder;
  GaussianModel model = random_model(3, 0);
  model.static_set.group(kLogScale).value[4] = NAN;
  EXPECT_EQ(save_splat_file(splat_format("ply"), folder / "a.ply", model.static_set, {1}), 1);
  const PlyFile file = read_ply(folder / "a.ply");
  ASSERT_EQ(file.elements.size(), 1u);
  EXPECT_EQ(file.elements[0].rows, 2);
  std::string names;
  for (const PlyColumn& c : file.elements[0].columns) {
    names += c.name + " ";
    EXPECT_EQ(c.type, PlyType::kFloat32);
  }
  EXPECT_EQ(names,
            "x y z nx ny nz f_dc_0 f_dc_1 f_dc_2 f_rest_0 f_rest_1 f_rest_2 f_rest_3 f_rest_4 "
            "f_rest_5 f_rest_6 f_rest_7 f_rest_8 opacity scale_0 scale_1 scale_2 rot_0 rot_1 "
            "rot_2 rot_3 ");
}

// Failure mode C1. Bug put back: write_splats checks that a set has rows; seen to fail.
TEST(Ply3dgs, AnEmptySetIsAFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(save_splat_file(splat_format("ply"), folder / "a.ply",
                            GaussianSet(SetForm::kStatic, 16), {3}),
            0);
  const SplatFile read = load_splat_file(folder / "a.ply");
  EXPECT_EQ(read.set.count(), 0);
  EXPECT_EQ(read.drawing.sh_degree, 3);
  EXPECT_TRUE(read.warnings.empty());
  EXPECT_EQ(coverage(render_one(static_model(random_model(0, 0), read.set.clone_values()),
                                three_views()[0])),
            0);
}

/// A camera that sees the middle of a set from three times its spread away.
View view_of(const GaussianSet& set) {
  glm::dvec3 sum(0);
  glm::dvec3 square(0);
  for (int64_t n = 0; n < set.count(); ++n) {
    const float* const m = set.values().at(kMean, n);
    const glm::dvec3 p(m[0], m[1], m[2]);
    sum += p / double(set.count());
    square += p * p / double(set.count());
  }
  const glm::dvec3 variance = square - sum * sum;
  const double spread = std::sqrt(variance.x + variance.y + variance.z);
  return {look_at(sum + glm::dvec3(0, 0, -3 * spread), sum, 96, 80, 90), 0};
}

void expect_foreign_file_renders(const std::filesystem::path& path, int64_t count,
                                 const std::vector<std::string>& warnings) {
  SplatFile read = load_splat_file(path);
  EXPECT_EQ(read.set.count(), count);
  ASSERT_EQ(read.warnings.size(), warnings.size());
  for (size_t i = 0; i < warnings.size(); ++i)
    EXPECT_NE(read.warnings[i].find(warnings[i]), std::string::npos) << read.warnings[i];
  GaussianModel model;
  model.drawing.sh_degree = read.drawing.sh_degree;
  model.drawing.near_plane = 1e-3;
  const View view = view_of(read.set);
  model.static_set = std::move(read.set);
  EXPECT_GT(coverage(render_one(model, view)), 0.02) << path;
}

TEST(Ply3dgs, ReadsSuperSplatsPlainFile) {
  TESSERA_NEED_DATA(path, "splats/fruit_drops_minimal.ply");
  expect_foreign_file_renders(path, 4721, {"ignored: transform", "quaternions"});
}

TEST(Ply3dgs, ReadsCompressedFiles) {
  TESSERA_NEED_DATA(small, "splats/test.ply");
  expect_foreign_file_renders(small, 64, {});
  TESSERA_NEED_DATA(large, "splats/biker.compressed.ply");
  expect_foreign_file_renders(large, 152746, {});
}

RenderedImage shown(const GaussianSet& set, int sh_degree, const View& view) {
  GaussianModel model;
  model.drawing.sh_degree = sh_degree;
  model.drawing.near_plane = 1e-3;
  model.static_set = set.clone_values();
  return render_one(model, view);
}

/// Of floats, dB: 8 bits would hide differences as small as these.
double exact_psnr(const RenderedImage& a, const RenderedImage& b) {
  double sum = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i) sum += std::pow(double(a.rgb[i]) - b.rgb[i], 2);
  return -10 * std::log10(sum / double(a.rgb.size()));
}

/// The largest difference of a value that two files round differently: uniform over both steps.
class Jitter {
 public:
  double operator()(double step, double other_step) {
    return random_.uniform(-0.5, 0.5) * step + random_.uniform(-0.5, 0.5) * other_step;
  }

 private:
  Random random_{1};
};

/// Smallest to largest of one scalar of a group in rows [begin, end).
double range_of(const GaussianSet& set, Group group, int k, int64_t begin, int64_t end) {
  float low = INFINITY, high = -INFINITY;
  for (int64_t n = begin; n < end; ++n) {
    const float x = set.values().at(group, n)[k];
    low = std::min(low, x);
    high = std::max(high, x);
  }
  return double(high) - double(low);
}

/// `set`, read from a compressed .ply and so in its chunks, as two files may differ that round one
/// object: this .ply's steps and those of .spz (docs/reference/splat-formats.md).
GaussianSet rounded_otherwise(const GaussianSet& set) {
  constexpr int64_t kChunk = 256;
  constexpr double kParts[] = {2047, 1023, 2047};
  GaussianSet other = set.clone_values();
  const GaussianSpans<float> to = other.values();
  Jitter jitter;
  for (int64_t begin = 0; begin < set.count(); begin += kChunk) {
    const int64_t end = std::min(begin + kChunk, set.count());
    for (int k = 0; k < 3; ++k) {
      const double mean = range_of(set, kMean, k, begin, end) / kParts[k];
      const double scale = range_of(set, kLogScale, k, begin, end) / kParts[k];
      const double colour = range_of(set, kSh, k, begin, end) / 255;
      for (int64_t n = begin; n < end; ++n) {
        to.at(kMean, n)[k] += float(jitter(mean, 1.0 / 4096));
        to.at(kLogScale, n)[k] += float(jitter(scale, 1.0 / 16));
        to.at(kSh, n)[k] += float(jitter(colour, 1 / (255 * 0.15)));
      }
    }
    for (int64_t n = begin; n < end; ++n) {
      for (int k = 0; k < 4; ++k)
        to.at(kRotation, n)[k] += float(jitter(std::sqrt(2) / 1023, std::sqrt(0.5) / 511));
      float& logit = *to.at(kOpacityLogit, n);
      const double opacity = 1 / (1 + std::exp(-double(logit))) + jitter(1.0 / 255, 1.0 / 255);
      logit = logit_of_byte(255 * opacity);
      for (int i = 3; i < 3 * set.coefficients(); ++i)
        to.at(kSh, n)[i] += float(jitter(1.0 / 32, i < 12 ? 1.0 / 16 : 1.0 / 8));
    }
  }
  return other;
}

// Two files of one object, each rounded: their images differ as much as those of one file whose
// values are moved within both formats' steps, not more.
// Bugs put back: the world of .spz taken as that of .ply; its quaternions as w, x, y, z; its
// opacities 2 % too small. Each seen to fail.
TEST(Ply3dgs, TheSameObjectInTwoFormatsLooksTheSame) {
  TESSERA_NEED_DATA(ply, "splats/biker.compressed.ply");
  TESSERA_NEED_DATA(spz, "splats/biker.spz");
  const SplatFile a = load_splat_file(ply), b = load_splat_file(spz);
  EXPECT_EQ(a.set.count(), b.set.count());
  EXPECT_EQ(a.drawing.sh_degree, b.drawing.sh_degree);
  EXPECT_TRUE(b.warnings.empty());
  const View view = view_of(a.set);
  const RenderedImage image = shown(a.set, a.drawing.sh_degree, view);
  const double expected =
      exact_psnr(image, shown(rounded_otherwise(a.set), a.drawing.sh_degree, view));
  const double actual = exact_psnr(image, shown(b.set, b.drawing.sh_degree, view));
  EXPECT_GT(expected, 40);
  EXPECT_GT(actual, expected - 0.5) << "by the formats' steps " << expected << " dB";
  RecordProperty("actual_db", std::to_string(actual));  // 60.6, by the steps 60.9
}

}  // namespace
}  // namespace tessera::testing
