// Reads the float tensors (F32) of a safetensors file: 8 bytes of length, a JSON header, raw data.
#pragma once
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace tessera::testing {

struct Tensor {
  std::vector<int64_t> shape;
  std::vector<float> values;  // row-major
};

/// Every tensor by name. Errors: std::runtime_error with the path.
inline std::map<std::string, Tensor> read_safetensors(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(file)), {});
  uint64_t header = 0;
  if (bytes.size() >= 8) std::memcpy(&header, bytes.data(), 8);
  if (bytes.size() < 8 || header > bytes.size() - 8)
    throw std::runtime_error(path.string() + ": not a safetensors file");
  const nlohmann::json json = nlohmann::json::parse(bytes.substr(8, header));
  std::map<std::string, Tensor> tensors;
  for (const auto& [name, entry] : json.items()) {
    if (name == "__metadata__") continue;
    const size_t begin = entry.at("data_offsets").at(0), end = entry.at("data_offsets").at(1);
    if (entry.at("dtype") != "F32" || end > bytes.size() - 8 - header || begin > end)
      throw std::runtime_error(path.string() + ": tensor " + name + " is not readable as F32");
    Tensor tensor;
    tensor.shape = entry.at("shape").get<std::vector<int64_t>>();
    tensor.values.resize((end - begin) / sizeof(float));
    std::memcpy(tensor.values.data(), bytes.data() + 8 + header + begin, end - begin);
    tensors[name] = std::move(tensor);
  }
  return tensors;
}

}  // namespace tessera::testing
