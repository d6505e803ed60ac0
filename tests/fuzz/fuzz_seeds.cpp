// Writes the seed files of each fuzzed reader with the project's writers: fuzz_seeds FOLDER writes
// FOLDER/READER/NAME.
#ifdef TESSERA_HAS_ZSTD
#include <zstd.h>
#endif

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "ingest/files/gzip.h"
#include "ingest/files/ply.h"
#include "ingest/files/png.h"
#include "recon4d/model/model_file.h"
#include "static3d/formats/splat_file.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/tessera4d/block.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

/// Values of a fixed series in [−1, 1); quaternions are of length 1.
GaussianSet some_set(SetForm form, int64_t count, int coefficients, int time_levels = 0) {
  GaussianSet set(form, coefficients, host_memory(), time_levels);
  set.resize(count);
  uint64_t state = 1;
  for (int g = 0; g < set.groups(); ++g)
    for (float& value : set.group(Group(g)).value.span()) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      value = float(double(state >> 40) / double(1 << 23) - 1);
    }
  const GaussianSpans<float> values = set.values();
  for (int64_t n = 0; n < count; ++n)
    for (int k = 0; k < 4; ++k) values.at(kRotation, n)[k] = k == n % 4 ? 1.0f : 0.0f;
  return set;
}

GaussianModel some_model(SetForm form, int coefficients) {
  GaussianModel model;
  model.static_set = some_set(SetForm::kStatic, 3, coefficients);
  model.dynamic_set = some_set(form, 3, coefficients);
  model.drawing.sh_degree = coefficients == 1 ? 0 : 3;
  return model;
}

GaussianModel model_with_nodes() {
  GaussianModel model = some_model(SetForm::kPair, 1);
  model.static_set = some_set(SetForm::kCanonical, 3, 1);
  for (float& node : model.static_set.group(kNode).value.span()) node = node > 0 ? 1.0f : -1.0f;
  model.nodes.resize(2, kSplineOrder);
  std::fill(model.nodes.position.begin(), model.nodes.position.end(), 0.5f);
  for (ParameterGroup* const group : model.nodes.groups())
    std::fill(group->value.begin(), group->value.end(), 0.25f);
  return model;
}

void write_splats(const fs::path& folder) {
  for (const SplatFormat& format : splat_formats()) {
#ifndef TESSERA_HAS_WEBP
    if (std::string(format.name) == "sog") continue;
#endif
    const bool is_ply = std::string(format.extension).ends_with(".ply");
    const fs::path place = folder / (is_ply ? "ply" : format.name);
    for (const int degree : {0, 1, 3})
      save_splat_file(format, place / (std::string(format.name) + std::to_string(degree)),
                      some_set(SetForm::kStatic, degree == 3 ? 5 : 2, 16), {degree});
  }
  write_text_file(folder / "ply/ascii",
                  "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 1\n"
                  "property float x\nproperty float y\nproperty double z\nproperty float f_dc_0\n"
                  "property float f_dc_1\nproperty float f_dc_2\nproperty float opacity\n"
                  "property float scale_0\nproperty float scale_1\nproperty float scale_2\n"
                  "property float rot_0\nproperty float rot_1\nproperty float rot_2\n"
                  "property float rot_3\nelement face 1\nproperty list uchar int vertex_indices\n"
                  "end_header\n0 1 2 .1 .2 .3 1 -1 -2 -3 1 0 0 0\n3 0 0 0\n");
}

void write_lines(const fs::path& folder) {
  for (const LineFormat& format : line_formats()) {
    if (!format.is_read) continue;
#ifndef TESSERA_HAS_WEBP
    if (!std::string(format.extension).ends_with(".ply")) continue;
#endif
    for (const int coefficients : {1, 16}) {
      const GaussianModel model = some_model(SetForm::kVelocity, coefficients);
      format.save(folder / (std::string(format.name) + std::to_string(coefficients)), model, 0);
    }
  }
}

/// Of SpacetimeGaussians, which this program does not write.
void write_spacetime(const fs::path& file) {
  PlyElement vertex{"vertex", 3, {}};
  const auto add = [&](const std::string& name, int count) {
    for (int i = 0; i < count; ++i)
      vertex.columns.push_back({count > 1 ? name + "_" + std::to_string(i) : name,
                                PlyType::kFloat32,
                                {0.5 + 0.1 * i, 0.25, -0.5}});
  };
  for (const char* name : {"x", "y", "z", "trbf_center", "trbf_scale", "opacity"}) add(name, 1);
  for (const auto& [name, count] :
       {std::pair{"motion", 9}, {"f_dc", 3}, {"scale", 3}, {"rot", 4}, {"omega", 4}})
    add(name, count);
  write_ply(file, {{}, {vertex}});
}

/// Versions 2 and 4 and what gzip hides, from a file of version 3.
void write_spz_versions(const fs::path& folder) {
  const std::string plain = gunzip(read_text_file(folder / "spz0"), 1 << 20, "spz0");
  write_text_file(folder / "bare", plain);
  std::string two = plain;
  two[4] = 2;
  two.resize(two.size() - 2);  // three bytes a quaternion, two splats, no SH
  write_text_file(folder / "two", two);
#ifdef TESSERA_HAS_ZSTD
  constexpr size_t kHead = 16;
  std::string four = plain.substr(0, kHead), columns = plain.substr(kHead), packed(1 << 12, '\0');
  four[4] = 4;
  four[15] = 1;
  packed.resize(ZSTD_compress(packed.data(), packed.size(), columns.data(), columns.size(), 1));
  append(four, uint32_t{32});
  four.append(12, '\0');
  append(four, uint64_t(packed.size()));
  append(four, uint64_t(columns.size()));
  write_text_file(folder / "four", four + packed);
#endif
}

/// One block of each kind behind a manifest; `windows`: of the second of two.
std::string tessera4d(bool lossless, bool windows = false) {
  const GaussianModel model = some_model(SetForm::kVelocity, 16);
  const BlockRules rules{lossless, 3, model.cutoff<double>()};
  Tessera4dManifest manifest;
  manifest.lossless = lossless;
  if (windows) manifest.windows = {{{0, 0.6}, {0, 0.5}}, {{0.4, 1}, {0.5, 1}}};
  std::string bytes, blocks;
  for (const GaussianSet* set : {&model.static_set, &model.dynamic_set}) {
    Block block = encode_block(*set, rules);
    if (windows) block = with_head(std::move(block));
    if (windows && block.info.moving) block.info.window = 1;
    manifest.blocks.push_back(block.info);
    manifest.blocks.back().offset = blocks.size();
    blocks += block.bytes;
  }
  const std::string text = to_json(manifest, model).dump();
  append(bytes, std::array<char, 4>{'T', 'E', 'S', '4'});
  append(bytes, manifest.version());
  append(bytes, uint32_t(text.size()));
  return bytes + text + blocks;
}

void write_models(const fs::path& folder) {
  save_model(folder / "model/pair", some_model(SetForm::kPair, 16));
  save_model(folder / "model/velocity", some_model(SetForm::kVelocity, 1));
  GaussianModel all = some_model(SetForm::kPair, 1);
  all.dynamic_set = some_set(SetForm::kPair, 2, 1, 2);
  all.drawing.sh_time_degree = 2;
  all.environment.height = 2;
  all.environment.map.value.resize(2 * 4 * 3);
  for (float& value : all.environment.map.value.span()) value = 0.5f;
  save_model(folder / "model/all", all);
  save_model(folder / "model/nodes", model_with_nodes());
  for (const bool lossless : {false, true})
    write_text_file(folder / "tessera4d" / (lossless ? "exact" : "rounded"), tessera4d(lossless));
  write_text_file(folder / "tessera4d/windows", tessera4d(false, true));
}

void write_transforms(const fs::path& folder) {
  const std::string pose = R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]])";
  write_text_file(folder / "transforms/nerf", R"({"camera_angle_x": 0.7, "frames": [
{"file_path": "./a", "time": 0, )" + pose + R"(}, {"file_path": "b", "time": 0.5, )" +
                                                  pose + "}]}");
  write_text_file(
      folder / "transforms/prepared",
      R"({"fl_x": 50, "fl_y": 51, "cx": 16, "cy": 16, "w": 32, "h": 32, "ply_file_path": "p.ply",
"tessera": {"format_version": 1, "time": {"origin": 0, "duration": 2, "static": false},
"applied": {"world_transform": [[2,0,0,0],[0,0,2,0],[0,-2,0,1],[0,0,0,1]]}},
"frames": [{"file_path": "c/0", "split": "test", "mask_path": "m/0.png", "time": 1,
"tessera": {"camera": "c", "frame": 3}, )" +
          pose + "}]}");
}

void write_images(const fs::path& folder) {
  constexpr int kWidth = 7, kHeight = 5;
  for (const int channels : {1, 3, 4}) {
    Image8 image{kWidth, kHeight, channels, {}};
    for (int n = 0; n < kWidth * kHeight * channels; ++n) image.data.push_back(uint8_t(n * n));
    write_png(folder / std::to_string(channels), image);
  }
}

void write_calibrations(const fs::path& folder) {
  const std::string k = R"("K": [[50,0,16],[0,51,12],[0,0,1]], "D": [0.1,0,0,0,0])";
  write_text_file(folder / "list", R"({"cameras": [{"name": "a", )" + k +
                                       R"(, "rvec": [0,0,1], "tvec": [[1],[2],[3]], "w": 32,
"h": 24}, {"name": "b", )" + k + R"(, "R": [1,0,0,0,1,0,0,0,1], "T": [1,2,3]}]})");
  write_text_file(folder / "named", R"({"names": ["01"], "K_01": {"rows": 3, "cols": 3, "data":
[50,0,16,0,51,12,0,0,1]}, "Rot_01": [1,0,0,0,1,0,0,0,1], "T_01": [0,0,4], "dist_01": [0,0,0,0]})");
  write_text_file(folder / "one", "{" + k + R"(, "c2w": [[1,0,0,0],[0,1,0,0],[0,0,1,4]],
"imgsize": [32, 24]})");
}

/// RGB by a matrix, with each kind of curve: ICC.1 is big-endian.
void write_profiles(const fs::path& folder) {
  const auto word = [](uint32_t value) {
    return std::string{char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
  };
  const std::string curves[] = {"curv" + word(0) + word(0), "curv" + word(0) + word(1) + "\2\2",
                                "curv" + word(0) + word(3) + std::string("\0\0\x40\0\xff\xff", 6),
                                "para" + word(0) + word(3u << 16) + word(0x26666) + word(0xf2a7) +
                                    word(0xd59) + word(0x13d0) + word(0xa5b)};
  for (const std::string& curve : curves) {
    std::string icc(128, '\0'), data;
    icc.replace(16, 8, "RGB XYZ ");
    icc += word(6);
    for (const char channel : {'r', 'g', 'b'})
      for (const char* kind : {"XYZ", "TRC"}) {
        const std::string tag = kind[0] == 'X' ? "XYZ " + word(0) + word(0x8000) + word(0x4000) +
                                                     word(channel == 'b' ? 0x9000 : 0x1000)
                                               : curve;
        icc += channel + std::string(kind) + word(uint32_t(132 + 72 + data.size())) +
               word(uint32_t(tag.size()));
        data += tag;
      }
    write_text_file(folder / std::to_string(&curve - curves), icc + data);
  }
}

void write_requests(const fs::path& folder) {
  const std::string host = "Host: localhost\n",
                    cookie = host + "Cookie: tessera_view_80=0123456789abcdef0123456789abcdef\n";
  write_text_file(folder / "page", "GET /a/\n" + cookie);
  write_text_file(folder / "part", "GET /a/index.html t=1\n" + cookie + "Range: bytes=2-4\n");
  write_text_file(folder / "first", "GET / token=0123456789abcdef0123456789abcdef&t=1\n" + host);
  write_text_file(folder / "link", "GET /d/secret.html\n" + cookie);
  write_text_file(folder / "up", "GET /a/%2e%2e/%2e%2e/secret.html\n" + cookie);
  const std::string own_page = cookie + "Origin: http://localhost\n";
  write_text_file(folder / "post", "POST /api/run\n" + own_page);
  write_text_file(folder / "stop", "POST /api/stop\n" + own_page);
  write_text_file(folder / "state", "GET /api/state a=1&seen=7\n" + cookie);
  write_text_file(folder / "truth", "GET /api/truth view=3\n" + cookie);
  write_text_file(folder / "report", "GET /api/report\n" + cookie);
}

}  // namespace
}  // namespace tessera::testing

int main(int argc, char** argv) {
  using namespace tessera::testing;
  if (argc != 2) return 2;
  const fs::path folder = argv[1];
  write_splats(folder);
  write_spz_versions(folder / "spz");
  write_lines(folder / "lines");
  write_spacetime(folder / "lines/spacetime");
  write_models(folder);
  write_transforms(folder);
  write_images(folder / "png");
  write_calibrations(folder / "calibration");
  write_profiles(folder / "profile");
  write_requests(folder / "view");
  return 0;
}
