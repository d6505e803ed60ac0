// Runs the network by OpenCV's dnn module.
#include <fmt/format.h>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tools/lpips/lpips.h"
#include "tools/lpips/onnx_inputs.h"

namespace tessera {
namespace {

/// OpenCV prints its errors on stderr, too; only the exception is used here.
int say_nothing(int, const char*, const char*, const char*, int, void*) {
  return 0;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const cv::Exception& error) {
  throw InputError(fmt::format(
      "{}: OpenCV {} cannot run this network ({}); export it with plain convolutions, fixed "
      "height and width and opset 11",
      file.string(), CV_VERSION, error.err.substr(0, error.err.find('\n'))));
}

/// [1, 3, height, width] in [−1, 1].
cv::Mat blob_of(const Image8& image) {
  const int sizes[] = {1, 3, image.height, image.width};
  cv::Mat blob(4, sizes, CV_32F);
  const size_t pixels = size_t(image.width) * size_t(image.height);
  auto* const to = blob.ptr<float>();
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < 3; ++c)
      to[c * pixels + p] = float(image.data[3 * p + c]) * (2.0f / 255.0f) - 1.0f;
  return blob;
}

Image8 resized(const Image8& image, int width, int height) {
  Image8 to{width, height, 3, std::vector<uint8_t>(size_t(3 * width * height))};
  const cv::Mat from(image.height, image.width, CV_8UC3,
                     const_cast<uint8_t*>(image.data.data()));  // only read
  cv::Mat out(height, width, CV_8UC3, to.data.data());
  cv::resize(from, out, out.size(), 0, 0, width < image.width ? cv::INTER_AREA : cv::INTER_LINEAR);
  return to;
}

}  // namespace

struct Lpips::Network {
  std::filesystem::path file;
  bool resize;
  std::vector<OnnxInput> inputs;
  cv::dnn::Net net;

  /// What the file fixes of a side (2: height, 3: width), or `otherwise`.
  int side(size_t which, int otherwise) const {
    const std::vector<int64_t>& shape = inputs[0].shape;
    return shape.size() == 4 && shape[which] > 0 ? int(shape[which]) : otherwise;
  }
};

Lpips::Lpips(const std::filesystem::path& file, bool resize) {
  const std::string bytes = read_text_file(file);
  network_ = std::make_unique<Network>(Network{file, resize, onnx_inputs(file, bytes), {}});
  if (network_->inputs.size() != 2)
    throw InputError(
        fmt::format("{}: the network has {} inputs, expected two images of "
                    "[1, 3, height, width]",
                    file.string(), network_->inputs.size()));
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::redirectError(say_nothing);
  try {
    network_->net = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
  } catch (const cv::Exception& error) {
    refuse(file, error);
  }
}

Lpips::~Lpips() = default;

double Lpips::distance(const Image8& drawn, const Image8& truth) {
  check(drawn.channels == 3 && truth.channels == 3 && drawn.width == truth.width &&
            drawn.height == truth.height,
        "Lpips: two RGB images of one size");
  Network& network = *network_;
  const int width = network.side(3, drawn.width), height = network.side(2, drawn.height);
  const bool fits = width == drawn.width && height == drawn.height;
  if (!fits && !network.resize)
    throw InputError(fmt::format(
        "{}: the network takes images of {} x {}, these have {} x {}; export it for any size, or "
        "pass --lpips-resize and say so beside the number",
        network.file.string(), width, height, drawn.width, drawn.height));
  try {
    const Image8* const images[] = {&drawn, &truth};
    for (size_t i = 0; i < 2; ++i)
      network.net.setInput(blob_of(fits ? *images[i] : resized(*images[i], width, height)),
                           network.inputs[i].name);
    const cv::Mat result = network.net.forward();
    if (result.total() != 1 || result.type() != CV_32F)
      throw InputError(fmt::format("{}: the network gives {} values, expected one",
                                   network.file.string(), result.total()));
    return double(*result.ptr<float>());
  } catch (const cv::Exception& error) {
    refuse(network.file, error);
  }
}

}  // namespace tessera
