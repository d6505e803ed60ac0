// LPIPS by networks made here, with known answers, and invalid network files. The published network
// is not used. Source: method 0.25; failure mode D1.
#include "tools/lpips/lpips.h"
#include "tests/support/random_image.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tests/support/random.h"
#include "tests/support/scratch_folder.h"
#include "tests/tools/lpips/onnx_file.h"
#include "tools/lpips/onnx_inputs.h"

namespace tessera::testing {
namespace {

/// Of values in [−1, 1].
double mean_distance(const Image8& a, const Image8& b) {
  double sum = 0;
  for (size_t i = 0; i < a.data.size(); ++i) sum += std::abs(int(a.data[i]) - int(b.data[i]));
  return 2 * sum / (255.0 * double(a.data.size()));
}

class LpipsFile : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& bytes) const {
    write_text_file(folder_ / "net.onnx", bytes);
    return folder_ / "net.onnx";
  }
  void expect_refused(const std::string& bytes, const std::vector<std::string>& parts) const {
    const std::filesystem::path file = write(bytes);
    const Image8 image = random_image(20, 16, 1);
    try {
      Lpips(file, false).distance(image, image);
      ADD_FAILURE() << "was taken";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      for (const std::string& part : parts)
        EXPECT_NE(message.find(part), std::string::npos) << message << " lacks " << part;
    }
  }
  ScratchFolder folder_;
};

// Bugs put back, each seen to fail: images in [0, 1]; the truth given to both inputs.
TEST_F(LpipsFile, GivesTheNetworksNumber) {
  for (const auto& [width, height] : {std::pair{20, 16}, {33, 7}}) {
    const Image8 a = random_image(width, height, 1), b = random_image(width, height, 2);
    Lpips any(write(onnx_file()), false);
    EXPECT_NEAR(any.distance(a, b), 2 * mean_distance(a, b), 1e-5);
    EXPECT_NEAR(any.distance(a, a), 0, 1e-7);
    OnnxNetwork fixed;
    fixed.width = width;
    fixed.height = height;
    Lpips exact(write(onnx_file(fixed)), false);
    EXPECT_NEAR(exact.distance(a, b), 2 * mean_distance(a, b), 1e-5);
  }
}

// Bugs put back, each seen to fail: height and width exchanged; blue first; interleaved values.
TEST_F(LpipsFile, PlacesAndColoursAreTheNetworks) {
  const int width = 9, height = 5;
  const Image8 a = random_image(width, height, 3), b = random_image(width, height, 4);
  const auto difference = [&](int x, int y, int c) {
    const size_t i = size_t((y * width + x) * 3 + c);
    return (double(a.data[i]) - double(b.data[i])) * 2 / 255;
  };
  double sum = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x + 1 < width; ++x) {
      double edge = 0;
      for (int c = 0; c < 3; ++c) edge += (c + 1) * (difference(x + 1, y, c) - difference(x, y, c));
      sum += std::abs(edge) / double(height * (width - 1));
    }
  EXPECT_NEAR(Lpips(write(onnx_edges()), false).distance(a, b), sum, 1e-5);
}

// Bug put back: fixed sides ignored; seen to fail.
TEST_F(LpipsFile, OtherSidesAreRefusedOrResized) {
  OnnxNetwork fixed;
  fixed.width = 10;
  fixed.height = 8;
  expect_refused(onnx_file(fixed), {"net.onnx", "10 x 8", "20 x 16", "--lpips-resize"});
  Image8 a = random_image(20, 16, 1), b = a;
  for (size_t i = 0; i < a.data.size(); ++i) {
    a.data[i] = 10;
    b.data[i] = 61;
  }
  Lpips resized(write(onnx_file(fixed)), true);
  EXPECT_NEAR(resized.distance(a, b), 2 * 2 * 51 / 255.0, 1e-5);
}

// Bugs put back, each seen to fail: weights counted as inputs; no look at how many values come out.
TEST_F(LpipsFile, FilesThatAreNotWhatIsAskedFor) {
  EXPECT_EQ(onnx_inputs("net.onnx", onnx_file()).size(), 2u);
  EXPECT_EQ(onnx_inputs("net.onnx", onnx_file())[1].name, "truth");
  EXPECT_EQ(onnx_inputs("net.onnx", onnx_file())[0].shape, (std::vector<int64_t>{1, 3, -1, -1}));
  OnnxNetwork one, image;
  one.inputs = {"rendered"};
  image.reduces = false;
  expect_refused(onnx_file(one), {"net.onnx", "1 inputs", "expected two images"});
  expect_refused(onnx_file(image), {"net.onnx", "960 values, expected one"});
  expect_refused("", {"net.onnx", "not an ONNX model"});
  expect_refused("this is no network", {"net.onnx", "not an ONNX model"});
  const std::string whole = onnx_file();
  expect_refused(whole.substr(0, whole.size() / 2), {"net.onnx", "not an ONNX model"});
  std::string unknown = whole;
  unknown.replace(unknown.find("GlobalAveragePool"), 17, "GlobalAveragePaul");
  expect_refused(unknown, {"net.onnx", "cannot run this network"});
  EXPECT_THROW(Lpips(folder_ / "absent.onnx", false), InputError);
}

}  // namespace
}  // namespace tessera::testing
