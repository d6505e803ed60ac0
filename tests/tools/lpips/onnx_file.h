// Tiny networks as ONNX files, written field by field: factor · mean |a − b| of two images, one
// that depends on positions and colours, and files that differ from these in one field. Source:
// onnx.proto3, protocol buffers' wire format.
#pragma once
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

namespace tessera::testing {

struct OnnxNetwork {
  std::vector<std::string> inputs{"rendered", "truth"};
  int64_t height = 0, width = 0;  // 0: any
  bool reduces = true;            // else the output is an image
  float factor = 2;               // a weight, listed among the inputs as old exporters do
};

inline std::string varint(uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes.push_back(char(value | 0x80));
  bytes.push_back(char(value));
  return bytes;
}
inline std::string number_field(int field, uint64_t value) {
  return varint(uint64_t(field) << 3) + varint(value);
}
inline std::string bytes_field(int field, const std::string& bytes) {
  return varint(uint64_t(field) << 3 | 2) + varint(bytes.size()) + bytes;
}

/// NodeProto: inputs, output, operator, attributes.
inline std::string onnx_node(const std::vector<std::string>& inputs, const std::string& output,
                             const std::string& kind, const std::string& attributes = "") {
  std::string node;
  for (const std::string& input : inputs) node += bytes_field(1, input);
  node += bytes_field(2, output) + bytes_field(3, "node_" + output) + bytes_field(4, kind);
  return node + attributes;
}

/// AttributeProto of whole numbers.
inline std::string onnx_numbers(const std::string& name, const std::vector<uint64_t>& values) {
  std::string attribute = bytes_field(1, name);
  for (uint64_t value : values) attribute += number_field(8, value);
  return bytes_field(5, attribute + number_field(20, 7));
}

/// ValueInfoProto of floats; size 0: a dimension with a name.
inline std::string onnx_value(const std::string& name, const std::vector<int64_t>& sizes) {
  std::string shape;
  for (size_t i = 0; i < sizes.size(); ++i)
    shape += bytes_field(1, sizes[i] > 0 ? number_field(1, uint64_t(sizes[i]))
                                         : bytes_field(2, "side" + std::to_string(i)));
  const std::string tensor = number_field(1, 1) + bytes_field(2, shape);
  return bytes_field(1, name) + bytes_field(2, bytes_field(1, tensor));
}

/// TensorProto of floats, "weights".
inline std::string onnx_weights(const std::vector<uint64_t>& sizes,
                                const std::vector<float>& values) {
  std::string tensor, raw;
  for (uint64_t size : sizes) tensor += number_field(1, size);
  for (float value : values)
    for (int byte = 0; byte < 4; ++byte)
      raw.push_back(char(std::bit_cast<uint32_t>(value) >> 8 * byte));
  return tensor + number_field(2, 1) + bytes_field(8, "weights") + bytes_field(9, raw);
}

inline std::string onnx_model(const std::string& graph) {
  const std::string opset = number_field(2, 11);
  return number_field(1, 6) + bytes_field(7, graph) + bytes_field(8, opset);
}

/// A ModelProto.
inline std::string onnx_file(const OnnxNetwork& network = {}) {
  const std::string& second = network.inputs.back();
  std::string graph = bytes_field(1, onnx_node({network.inputs[0], second}, "difference", "Sub"));
  graph += bytes_field(1, onnx_node({"difference"}, "distance", "Abs"));
  std::string last = "distance";
  if (network.reduces) {
    graph += bytes_field(1, onnx_node({"distance"}, "mean", "GlobalAveragePool"));
    // three channels become one by a 1 × 1 convolution
    graph += bytes_field(
        1, onnx_node({"mean", "weights"}, "result", "Conv", onnx_numbers("kernel_shape", {1, 1})));
    const float share = network.factor / 3;
    graph += bytes_field(5, onnx_weights({1, 3, 1, 1}, {share, share, share}));
    last = "result";
  }
  graph += bytes_field(2, "tiny");
  for (const std::string& input : network.inputs)
    graph += bytes_field(11, onnx_value(input, {1, 3, network.height, network.width}));
  if (network.reduces) graph += bytes_field(11, onnx_value("weights", {1, 3, 1, 1}));
  graph += bytes_field(12, onnx_value(last, {1, 1, 1, 1}));
  return onnx_model(graph);
}

/// Mean over pixels of |Σ_c (c + 1)·(d_c(x + 1) − d_c(x))|, d = a − b: another number where sides,
/// rows or colours are exchanged.
inline std::string onnx_edges() {
  std::string graph = bytes_field(1, onnx_node({"a", "b"}, "difference", "Sub"));
  graph += bytes_field(1, onnx_node({"difference", "weights"}, "edges", "Conv",
                                    onnx_numbers("kernel_shape", {1, 2})));
  graph += bytes_field(1, onnx_node({"edges"}, "distance", "Abs"));
  graph += bytes_field(1, onnx_node({"distance"}, "result", "GlobalAveragePool"));
  graph += bytes_field(2, "edges");
  graph += bytes_field(5, onnx_weights({1, 3, 1, 2}, {-1, 1, -2, 2, -3, 3}));
  for (const char* input : {"a", "b"}) graph += bytes_field(11, onnx_value(input, {1, 3, 0, 0}));
  graph += bytes_field(12, onnx_value("result", {1, 1, 1, 1}));
  return onnx_model(graph);
}

}  // namespace tessera::testing
