// LPIPS by a network that the user provides as an ONNX file; none is shipped. The file has two
// inputs, float [1, 3, height, width], RGB in [−1, 1], the rendered image first, and one output of
// a single value. Names do not matter, and sides may be fixed. Source: method 0.25, A.15; failure
// mode D1.
#pragma once
#include <filesystem>
#include <memory>

#include "ingest/scene.h"

namespace tessera {

class Lpips {
 public:
  /// `resize`: images are brought to the sides that the file fixes. Errors: InputError: no such
  /// file, not an ONNX model, other inputs than two, layers that OpenCV cannot run, a program built
  /// without OpenCV.
  Lpips(const std::filesystem::path& file, bool resize);
  Lpips(const Lpips&) = delete;
  ~Lpips();

  /// Of two RGB images of one size. Errors: InputError: the file fixes other sides and `resize`
  /// is off; the network's result is not one number.
  double distance(const Image8& drawn, const Image8& truth);

 private:
  struct Network;
  std::unique_ptr<Network> network_;
};

}  // namespace tessera
