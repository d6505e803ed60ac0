// Projection, images and gradients against the stored output of a third party's rasteriser. The
// data is optional, and tests are skipped without it.
// Conventions found in the files: `scales` are logarithms (−3.7 … 0.83), `quats` are w x y z and
// not normalised, `opacities` are logits (0.5 … 1), `coeffs` are [N, 16, 3], `conics` are (xx, xy,
// yy), `out_img` is RGB and 1 − transmittance; gradients are by these stored values.
#include "kernels/load_gaussian.h"
#include "tests/support/data_folder.h"
#include "tests/support/render.h"
#include "tests/support/safetensors.h"

namespace tessera::testing {
namespace {

using Tensors = std::map<std::string, Tensor>;

/// The files of a folder; skips the test where the data is absent.
std::vector<std::filesystem::path> files_in(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path root = data_folder("raster_reference");
  if (root.empty()) return files;
  for (const auto& entry : std::filesystem::directory_iterator(root / folder))
    files.push_back(entry.path());
  return files;
}

constexpr const char* kAbsent = "raster_reference not found beside the project (TESSERA_DATA)";
// Shares of the largest element. The third party computes in float: positions of 100 pixels are
// rounded to 8e-6, an image sums several α, a gradient some thousand pixels with both signs. Its
// own tests allow 1e-5 or 1 % per element.
constexpr double kProjection = 5e-7, kPicture = 5e-6, kGradient = 3e-5;

/// Centre (0.123, 0.456, −8), no rotation, focal W/2 both ways, principal point in the middle.
View reference_view(const Tensors& t) {
  View view;
  Camera& c = view.camera;
  c.height = int(t.at("out_img").shape[0]);
  c.width = int(t.at("out_img").shape[1]);
  c.fl_x = c.fl_y = 0.5 * c.width;
  c.cx = 0.5 * c.width;
  c.cy = 0.5 * c.height;
  c.translation = {-0.123, -0.456, 8};
  return view;
}

TestScene<double> reference_scene(const Tensors& t) {
  TestScene<double> scene;
  const auto fill = [&](Group g, const char* name) {
    const std::vector<float>& values = t.at(name).values;
    scene.fixed.group[g].assign(values.begin(), values.end());
  };
  scene.fixed = TestGaussians<double>(SetForm::kStatic, t.at("means").shape[0]);
  fill(kMean, "means");
  fill(kLogScale, "scales");
  fill(kRotation, "quats");
  fill(kSh, "coeffs");
  fill(kOpacityLogit, "opacities");
  scene.views = {reference_view(t)};
  return scene;
}

/// Every element within `share` of the largest element.
void expect_close(const std::vector<double>& actual, const std::vector<float>& expected,
                  double share, const std::string& what) {
  ASSERT_EQ(actual.size(), expected.size()) << what;
  double largest = 0, worst = 0;
  for (const float e : expected) largest = std::max(largest, double(std::abs(e)));
  for (size_t i = 0; i < actual.size(); ++i)
    worst = std::max(worst, std::abs(actual[i] - double(expected[i])));
  EXPECT_LE(worst, share * largest) << what;
}

/// Planar RGB and transmittance to the file's [H, W, 4].
template <class Real>
std::vector<double> as_rgba(const Rendered<Real>& r) {
  const size_t pixels = r.transmittance.size();
  std::vector<double> out;
  for (size_t p = 0; p < pixels; ++p) {
    for (size_t c = 0; c < 3; ++c) out.push_back(double(r.colour[c * pixels + p]));
    out.push_back(1 - double(r.transmittance[p]));
  }
  return out;
}

/// These two hold images in which tiles are missing: zeros where the file of the same inputs
/// beside them, and both of 2025, have splats.
constexpr const char* kIncomplete[] = {"basic_case_b8290f04.safetensors",
                                       "tiny_case_e378cca7.safetensors"};

bool incomplete(const std::string& name) {
  return std::find(std::begin(kIncomplete), std::end(kIncomplete), name) != std::end(kIncomplete);
}

TEST(RasterReference, ImagesAgree) {
  int files = 0;
  for (const char* folder : {"forward_only_2026", "with_gradients_2025"})
    for (const auto& path : files_in(folder)) {
      const std::string name = path.filename().string();
      if (incomplete(name)) continue;
      const Tensors t = read_safetensors(path);
      const TestScene<double> scene = reference_scene(t);
      const std::vector<float>& expected = t.at("out_img").values;
      expect_close(as_rgba(render(scene)), expected, kPicture, name + " out_img, double");
      expect_close(as_rgba(render(scene.as<float>())), expected, kPicture,
                   name + " out_img, float");
      ++files;
    }
  if (files == 0) GTEST_SKIP() << kAbsent;
  EXPECT_EQ(files, 6);
}

TEST(RasterReference, IncompleteFilesContradictAFileOfTheSameInputs) {
  const auto files = files_in("forward_only_2026");
  if (files.empty()) GTEST_SKIP() << kAbsent;
  int contradicted = 0;
  for (const auto& path : files)
    for (const auto& other : files) {
      if (!incomplete(path.filename().string()) || incomplete(other.filename().string())) continue;
      const Tensors a = read_safetensors(path), b = read_safetensors(other);
      bool same = true;
      for (const char* input : {"means", "scales", "quats", "opacities", "coeffs"})
        same = same && a.at(input).values == b.at(input).values;
      if (same) contradicted += a.at("out_img").values != b.at("out_img").values;
    }
  EXPECT_EQ(contradicted, 2);
}

TEST(RasterReference, ProjectionAgrees) {
  int files = 0;
  for (const auto& path : files_in("with_gradients_2025")) {
    const Tensors t = read_safetensors(path);
    const TestScene<double> scene = reference_scene(t);
    const ViewArgs<double> view = make_view_batch<double>(scene.views).views[0];
    std::vector<double> xys, conics, depths;
    for (int64_t n = 0; n < scene.fixed.count; ++n) {
      GaussianState<double> g;
      ASSERT_TRUE(load_gaussian<SetForm::kStatic>(scene.fixed.view(), n, g));
      Projection<double> p;
      ASSERT_TRUE(project_ewa(view, to_camera(view, g.mean), g.spacetime.covariance, 0.3, p));
      xys.insert(xys.end(), {p.mean2d[0], p.mean2d[1]});
      conics.insert(conics.end(), {p.conic.xx, p.conic.xy, p.conic.yy});
      depths.push_back(p.in_cam[2]);
    }
    expect_close(xys, t.at("xys").values, kProjection, path.filename().string() + " xys");
    expect_close(conics, t.at("conics").values, kProjection, path.filename().string() + " conics");
    expect_close(depths, t.at("depths").values, kProjection, path.filename().string() + " depths");
    ++files;
  }
  if (files == 0) GTEST_SKIP() << kAbsent;
}

using SplatSums = std::vector<SplatMoments<double>>;

/// Sums over the pixels of a scene's splats for dL/d out_img. The alpha channel is a second image,
/// of the same splats all white on black, whose value is 1 − transmittance: blending is linear in
/// the colours, so the sums of both images add.
SplatSums splat_sums(const TestScene<double>& scene, const std::vector<float>& v_out_img,
                     Splats<double>& splats) {
  CpuBackend<double> backend;
  const ViewBatch<double> batch = make_view_batch<double>(scene.views);
  TileInstances<double> instances;
  Images<double> images;
  backend.project({&batch, {scene.fixed.view(), scene.moving.view()}, scene.options, true}, splats);
  backend.bin({&batch, &splats, scene.options, true}, instances);
  const size_t pixels = size_t(batch.pixels);
  const auto gradients = [&](const std::vector<double>& d_colour) {
    const BlendArgs<double> blend{&batch, &splats, &instances, scene.options, true};
    backend.blend(blend, images);
    SplatSums out(size_t(splats.count));
    backend.blend_backward({blend, &images, {d_colour.data(), int64_t(d_colour.size())}},
                           {out.data(), splats.count});
    return out;
  };
  std::vector<double> d_rgb(3 * pixels);
  std::vector<double> d_alpha(3 * pixels, 0);
  for (size_t p = 0; p < pixels; ++p) {
    for (size_t c = 0; c < 3; ++c) d_rgb[c * pixels + p] = v_out_img[4 * p + c];
    d_alpha[p] = v_out_img[4 * p + 3];
  }
  SplatSums sum = gradients(d_rgb);
  for (Splat<double>& splat : splats.splat) splat.colour = Vec3<double>(1.0);
  const SplatSums alpha = gradients(d_alpha);
  for (size_t s = 0; s < sum.size(); ++s) {
    sum[s].f += alpha[s].f;
    sum[s].f_d += alpha[s].f_d;
    sum[s].f_dd += alpha[s].f_dd;
  }
  return sum;
}

/// Parameter gradients for given splat gradients.
TestGaussians<double> parameter_gradients(const TestScene<double>& scene,
                                          const Splats<double>& splats, SplatSums d_splats) {
  const ViewBatch<double> batch = make_view_batch<double>(scene.views);
  TestGaussians<double> out(SetForm::kStatic, scene.fixed.count);
  TestGaussians<double> none(SetForm::kPair);
  ProjectBackwardArgs<double> args;
  args.forward = {&batch, {scene.fixed.view(), scene.moving.view()}, scene.options};
  args.splats = &splats;
  args.d_splats = {d_splats.data(), splats.count};
  args.sinks[0].gradient = out.spans();
  args.sinks[1].gradient = none.spans();
  CpuBackend<double> backend;
  backend.project_backward(args);
  EXPECT_EQ(backend.outcome().bad_groups, 0u);
  return out;
}

/// Without the colours' part, whose viewing direction the files leave out of the means.
SplatSums without_colour(SplatSums d) {
  for (SplatMoments<double>& g : d) g.colour = Vec3<double>(0.0);
  return d;
}

TEST(RasterReference, GradientsAgree) {
  int files = 0;
  for (const auto& path : files_in("with_gradients_2025")) {
    const Tensors t = read_safetensors(path);
    const TestScene<double> scene = reference_scene(t);
    const std::string name = path.filename().string() + " ";
    Splats<double> splats;
    const SplatSums sums = splat_sums(scene, t.at("v_out_img").values, splats);
    const size_t count = size_t(scene.fixed.count);
    std::vector<double> v_xy(2 * count, 0);
    std::vector<double> v_conics(3 * count, 0);
    for (size_t n = 0; n < count; ++n) {
      if (splats.first_of[int64_t(n)] == splats.first_of[int64_t(n) + 1]) continue;  // not drawn
      const size_t s = size_t(splats.first_of[int64_t(n)]);
      const Splat<double>& splat = splats.splat[int64_t(s)];
      const SplatGradient<double> d = splat_gradient(splat.conic, splat.opacity, sums[s]);
      for (size_t i = 0; i < 2; ++i) v_xy[2 * n + i] = d.mean2d[int(i)];
      v_conics[3 * n] = d.conic.xx;
      v_conics[3 * n + 2] = d.conic.yy;
      v_conics[3 * n + 1] = 2 * d.conic.xy;  // the file counts both equal entries
    }
    expect_close(v_xy, t.at("v_xy").values, kGradient, name + "v_xy");
    expect_close(v_conics, t.at("v_conics").values, kGradient, name + "v_conics");
    const auto colour = parameter_gradients(scene, splats, sums);
    const auto shape = parameter_gradients(scene, splats, without_colour(sums));
    expect_close(colour.group[kSh], t.at("v_coeffs").values, kGradient, name + "v_coeffs");
    expect_close(shape.group[kMean], t.at("v_means").values, kGradient, name + "v_means");
    expect_close(shape.group[kLogScale], t.at("v_scales").values, kGradient, name + "v_scales");
    expect_close(shape.group[kRotation], t.at("v_quats").values, kGradient, name + "v_quats");
    expect_close(shape.group[kOpacityLogit], t.at("v_opacities").values, kGradient,
                 name + "v_opacities");
    ++files;
  }
  if (files == 0) GTEST_SKIP() << kAbsent;
}

}  // namespace
}  // namespace tessera::testing
