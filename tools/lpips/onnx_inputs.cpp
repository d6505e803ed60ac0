// Parses only the fields of protocol buffers that describe inputs.
#include "tools/lpips/onnx_inputs.h"

#include <fmt/format.h>

#include <optional>
#include <set>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

struct Malformed {};

/// One field of a message: a number, or bytes that may be a message.
struct Field {
  uint64_t number = 0, value = 0;
  std::string_view bytes;
};

/// Fields of a message, one after another.
class Fields {
 public:
  explicit Fields(std::string_view message) : rest_(message) {}

  std::optional<Field> next() {
    if (rest_.empty()) return std::nullopt;
    const uint64_t tag = varint();
    Field field{tag >> 3, 0, {}};
    switch (tag & 7) {
      case 0:
        field.value = varint();
        break;
      case 1:
        take(8);
        break;
      case 2:
        field.bytes = take(varint());
        break;
      case 5:
        take(4);
        break;
      default:
        throw Malformed();
    }
    return field;
  }

 private:
  uint64_t varint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = uint8_t(take(1)[0]);
      value |= uint64_t(byte & 0x7f) << shift;
      if (byte < 0x80) return value;
    }
    throw Malformed();
  }
  std::string_view take(uint64_t count) {
    if (count > rest_.size()) throw Malformed();
    const std::string_view bytes = rest_.substr(0, size_t(count));
    rest_.remove_prefix(size_t(count));
    return bytes;
  }

  std::string_view rest_;
};

/// Calls visit(bytes) for every field of that number.
template <class Visit>
void each(std::string_view message, uint64_t number, Visit&& visit) {
  Fields fields(message);
  while (const std::optional<Field> field = fields.next())
    if (field->number == number) visit(*field);
}

std::string text_of(std::string_view message, uint64_t number) {
  std::string text;
  each(message, number, [&](const Field& field) { text = field.bytes; });
  return text;
}

OnnxInput read_input(std::string_view value_info) {
  OnnxInput input{text_of(value_info, 1), {}};
  // ValueInfoProto.type → TypeProto.tensor_type → shape → dim → dim_value
  each(value_info, 2, [&](const Field& type) {
    each(type.bytes, 1, [&](const Field& tensor) {
      each(tensor.bytes, 2, [&](const Field& shape) {
        each(shape.bytes, 1, [&](const Field& dim) {
          int64_t size = -1;
          each(dim.bytes, 1, [&](const Field& value) { size = int64_t(value.value); });
          input.shape.push_back(size > 0 ? size : -1);
        });
      });
    });
  });
  return input;
}

}  // namespace

std::vector<OnnxInput> onnx_inputs(const std::filesystem::path& path, std::string_view bytes) {
  std::vector<OnnxInput> inputs;
  bool has_graph = false;
  try {
    each(bytes, 7, [&](const Field& graph) {
      has_graph = true;
      std::set<std::string> weights;
      each(graph.bytes, 5, [&](const Field& tensor) { weights.insert(text_of(tensor.bytes, 8)); });
      each(graph.bytes, 11, [&](const Field& value_info) {
        OnnxInput input = read_input(value_info.bytes);
        if (weights.count(input.name) == 0) inputs.push_back(std::move(input));
      });
    });
  } catch (const Malformed&) {
    has_graph = false;
  }
  if (!has_graph)
    throw InputError(
        fmt::format("{}: not an ONNX model; export the network to ONNX with its "
                    "weights inside",
                    path.string()));
  return inputs;
}

}  // namespace tessera
