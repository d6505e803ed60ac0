// Curves become tables of the 256 codes; a profile that changes no colour by more than a level is
// that of sRGB.
#include "ingest/images/colour_profile.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/matrix.hpp>
#include <map>
#include <vector>

namespace tessera {
namespace {

using std::string_view;

/// Numbers of a profile, big-endian; 0 beyond its end.
class Bytes {
 public:
  explicit Bytes(string_view text) : text_(text) {}
  uint32_t word(size_t place) const { return number(place, 4); }
  uint32_t half(size_t place) const { return number(place, 2); }
  double fixed(size_t place) const { return int32_t(word(place)) / 65536.0; }
  string_view part(size_t place, size_t size) const {
    return place < text_.size() ? text_.substr(place, size) : string_view();
  }

 private:
  uint32_t number(size_t place, size_t size) const {
    uint32_t value = 0;
    for (size_t i = 0; i < size; ++i)
      value = value << 8 | (place + i < text_.size() ? uint8_t(text_[place + i]) : 0);
    return value;
  }
  string_view text_;
};

/// sRGB's primaries in the profile connection space, XYZ of D50 (IEC 61966-2-1, adapted).
constexpr double kSrgb[3][3] = {
    {0.43607, 0.38515, 0.14307}, {0.22249, 0.71687, 0.06061}, {0.01392, 0.09708, 0.71410}};

double srgb_code(double light) {
  light = std::clamp(light, 0.0, 1.0);
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

using Curve = std::function<double(double)>;

/// `parametricCurveType`, ICC.1 10.18.
Curve parametric(const Bytes& tag) {
  const uint32_t type = tag.half(8);
  const auto value = [&](size_t i) { return tag.fixed(12 + 4 * i); };
  const double g = value(0), a = type > 0 ? value(1) : 1, b = type > 0 ? value(2) : 0;
  const double c = type > 1 ? value(3) : 0;
  if (type > 4) return {};
  return [=, d = type > 2 ? value(4) : 0, e = type == 4 ? value(5) : 0,
          f = type == 4 ? value(6) : 0](double x) {
    const double power = std::pow(std::max(0.0, a * x + b), g);
    if (type <= 2) return x >= (a != 0 ? -b / a : 0) ? power + c : c;
    return x >= d ? power + e : c * x + f;
  };
}

/// `curveType` (10.6) or the one above; nothing of others.
Curve curve_of(const Bytes& tag) {
  if (tag.part(0, 4) == "para") return parametric(tag);
  if (tag.part(0, 4) != "curv") return {};
  const uint32_t count = tag.word(8);
  if (count == 0) return [](double x) { return x; };
  if (count == 1) return [g = tag.half(12) / 256.0](double x) { return std::pow(x, g); };
  if (count > 4096) return {};
  std::vector<double> table;
  for (uint32_t i = 0; i < count; ++i) table.push_back(tag.half(12 + 2 * size_t(i)) / 65535.0);
  return [table](double x) {
    const double place = x * double(table.size() - 1);
    const size_t i = std::min(size_t(place), table.size() - 2);
    return table[i] + (place - double(i)) * (table[i + 1] - table[i]);
  };
}

/// Of `mluc` (10.15) the first text, of `desc` its ASCII; what is no ASCII is left out.
std::string text_of(const Bytes& tag) {
  const bool is_wide = tag.part(0, 4) == "mluc";
  const string_view stored = is_wide ? tag.part(tag.word(24), std::min(tag.word(20), 200u))
                                     : tag.part(12, std::min(tag.word(8), 100u));
  std::string text;
  for (const char c : stored)
    if (c >= ' ' && c <= '~') text += c;
  return text.empty() ? "without name" : text;
}

std::map<string_view, Bytes> tags_of(string_view icc) {
  const Bytes whole(icc);
  std::map<string_view, Bytes> tags;
  for (size_t i = 0; i < std::min(whole.word(128), 100u); ++i) {
    const size_t entry = 132 + 12 * i;
    const size_t begin = whole.word(entry + 4), size = whole.word(entry + 8);
    if (begin + size <= icc.size())
      tags.emplace(whole.part(entry, 4), Bytes(icc.substr(begin, size)));
  }
  return tags;
}

/// Whether no colour changes by more than one level.
bool is_srgb(const ColourProfile& profile) {
  for (int r = 0; r < 256; r += 51)
    for (int g = 0; g < 256; g += 51)
      for (int b = 0; b < 256; b += 51) {
        Image8 pixel{1, 1, 3, {uint8_t(r), uint8_t(g), uint8_t(b)}};
        convert_to_srgb(profile, pixel);
        if (std::abs(pixel.data[0] - r) > 1 || std::abs(pixel.data[1] - g) > 1 ||
            std::abs(pixel.data[2] - b) > 1)
          return false;
      }
  return true;
}

StatedColour unless_srgb(ColourProfile profile) {
  for (const auto& curve : profile.light)
    for (const double value : curve)
      if (!std::isfinite(value)) return {{}, profile.name};
  if (is_srgb(profile)) return {};
  return {std::move(profile), ""};
}

std::string inflated(string_view deflated) {
  constexpr size_t kMost = size_t{4} << 20;
  std::string bytes(4096, '\0');
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(deflated.data()));
  stream.avail_in = uInt(deflated.size());
  size_t size = 0;
  int state = Z_OK;
  while (state == Z_OK && size < kMost) {
    bytes.resize(std::max(bytes.size(), 2 * size));
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data() + size);
    stream.avail_out = uInt(bytes.size() - size);
    state = inflate(&stream, Z_NO_FLUSH);
    size = bytes.size() - stream.avail_out;
  }
  inflateEnd(&stream);
  bytes.resize(state == Z_STREAM_END ? size : 0);
  return bytes;
}

StatedColour colour_of_png(string_view png) {
  const Bytes bytes(png);
  std::optional<double> gamma;
  for (size_t place = 8; place + 8 <= png.size();) {
    const size_t length = bytes.word(place);
    const string_view type = bytes.part(place + 4, 4), data = bytes.part(place + 8, length);
    if (type == "sRGB") return {};
    if (type == "IDAT") break;
    if (type == "iCCP")
      if (const size_t end = data.find('\0'); end != string_view::npos && end + 2 < data.size())
        return colour_of_icc(inflated(data.substr(end + 2)));
    if (type == "gAMA") gamma = bytes.word(place + 8) / 100000.0;
    place += 12 + length;
  }
  constexpr double kUsual = 1 / 2.2, kNear = 0.02;
  if (!gamma || !(*gamma > 0) || std::abs(*gamma - kUsual) < kNear) return {};
  ColourProfile profile{"gamma " + std::to_string(1 / *gamma).substr(0, 4), {}, glm::dmat3(1)};
  for (auto& curve : profile.light)
    for (size_t code = 0; code < 256; ++code)
      curve[code] = std::pow(double(code) / 255, 1 / *gamma);
  return unless_srgb(std::move(profile));
}

StatedColour colour_of_jpeg(string_view jpeg) {
  const Bytes bytes(jpeg);
  std::map<uint32_t, std::string> parts;  // by their number
  for (size_t place = 2; place + 4 <= jpeg.size() && bytes.half(place) != 0xffda;) {
    const size_t length = bytes.half(place + 2);
    const string_view data = bytes.part(place + 4, length < 2 ? 0 : length - 2);
    constexpr string_view kName("ICC_PROFILE\0", 12);
    if (bytes.half(place) == 0xffe2 && data.starts_with(kName) && data.size() > 14)
      parts[uint8_t(data[12])] = data.substr(14);
    place += 2 + std::max<size_t>(length, 2);
  }
  std::string icc;
  for (const auto& [number, part] : parts) icc += part;
  return icc.empty() ? StatedColour{} : colour_of_icc(icc);
}

}  // namespace

StatedColour colour_of_icc(string_view icc) {
  const auto tags = tags_of(icc);
  const auto tag = [&](const char* name) {
    const auto found = tags.find(name);
    return found == tags.end() ? Bytes("") : found->second;
  };
  ColourProfile profile{text_of(tag("desc")), {}, glm::dmat3(1)};
  if (Bytes(icc).part(16, 4) != "RGB " || Bytes(icc).part(20, 4) != "XYZ ")
    return {{}, profile.name};
  glm::dmat3 to_xyz(0), srgb(0);
  const std::pair<const char*, const char*> names[] = {
      {"rXYZ", "rTRC"}, {"gXYZ", "gTRC"}, {"bXYZ", "bTRC"}};
  for (int channel = 0; channel < 3; ++channel) {
    const Bytes colour = tag(names[channel].first);
    const Curve curve = curve_of(tag(names[channel].second));
    if (colour.part(0, 4) != "XYZ " || !curve) return {{}, profile.name};
    for (int row = 0; row < 3; ++row) {
      to_xyz[channel][row] = colour.fixed(8 + 4 * size_t(row));
      srgb[channel][row] = kSrgb[row][channel];
    }
    for (size_t code = 0; code < 256; ++code)
      profile.light[size_t(channel)][code] = curve(double(code) / 255);
  }
  profile.to_srgb = glm::inverse(srgb) * to_xyz;
  return unless_srgb(std::move(profile));
}

StatedColour colour_of_file(string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return colour_of_png(bytes);
  if (bytes.starts_with("\xff\xd8")) return colour_of_jpeg(bytes);
  return {};
}

void convert_to_srgb(const ColourProfile& profile, Image8& image) {
  const auto channels = size_t(image.channels);
  for (size_t p = 0; p + channels <= image.data.size(); p += channels) {
    uint8_t* const pixel = image.data.data() + p;
    glm::dvec3 light;
    for (int c = 0; c < 3; ++c)
      light[c] = profile.light[size_t(c)][pixel[channels < 3 ? 0 : size_t(c)]];
    light = profile.to_srgb * light;
    for (size_t c = 0; c < std::min<size_t>(channels, 3); ++c)
      pixel[c] = uint8_t(std::lround(255 * srgb_code(light[int(c)])));
  }
}

}  // namespace tessera
