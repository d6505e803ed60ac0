// Lists the inputs of a network in an ONNX file. Source: onnx.proto3 (ModelProto, GraphProto,
// ValueInfoProto) and the wire format of protocol buffers.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

struct OnnxInput {
  std::string name;
  std::vector<int64_t> shape;  // −1: any
};

/// The graph's inputs that are no weights, in the order of the file. `path` for messages. Errors:
/// InputError: the bytes are no ONNX model.
std::vector<OnnxInput> onnx_inputs(const std::filesystem::path& path, std::string_view bytes);

}  // namespace tessera
