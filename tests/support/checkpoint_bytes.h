// Reads and replaces the header of a checkpoint in its bytes. The layout is described in
// recon4d/model/checkpoint_file.h, whose reader is not used here.
#pragma once
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera::testing {

// after "TESSCKPT" and the version
inline constexpr size_t kHeaderSumAt = 12, kHeaderBytesAt = 16, kHeaderAt = 24;

inline uint64_t header_bytes_of(const std::string& checkpoint) {
  uint64_t length = 0;
  std::memcpy(&length, checkpoint.data() + kHeaderBytesAt, sizeof(length));
  return length;
}

inline nlohmann::json header_of(const std::string& checkpoint) {
  return nlohmann::json::parse(checkpoint.substr(kHeaderAt, header_bytes_of(checkpoint)));
}

/// The same file with another header, whose checksum fits.
inline std::string with_header(const std::string& checkpoint, const nlohmann::json& header) {
  const std::string text = header.dump();
  const uint64_t length = text.size();
  const auto sum = uint32_t(crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size()));
  std::string file = checkpoint.substr(0, kHeaderSumAt);
  file.append(reinterpret_cast<const char*>(&sum), sizeof(sum));
  file.append(reinterpret_cast<const char*>(&length), sizeof(length));
  return file + text + checkpoint.substr(kHeaderAt + header_bytes_of(checkpoint));
}

}  // namespace tessera::testing
