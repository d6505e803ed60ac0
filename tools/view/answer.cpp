// The checks of a request in their order, and the response of a request that passes them.
#include "tools/view/answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "tools/view/served_file.h"
#include "tools/view/view_request.h"

namespace tessera {
namespace {

/// The player is one page with its script and style inside, decodes in a worker that it makes of a
/// blob, and has its WebAssembly in a data: address. Nothing is fetched from another server.
constexpr const char* kContentSecurityPolicy =
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval' blob:; "
    "worker-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; media-src 'self' data: blob:; "
    "connect-src 'self' data: blob:; frame-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'";

ViewResponse with_headers(int status) {
  ViewResponse response;
  response.status = status;
  response.headers = {{"X-Content-Type-Options", "nosniff"},
                      {"Referrer-Policy", "no-referrer"},
                      {"Content-Security-Policy", kContentSecurityPolicy},
                      {"Cache-Control", "no-store"}};
  return response;
}

ViewResponse with_text(int status, const char* type, std::string body) {
  ViewResponse response = with_headers(status);
  response.headers.emplace_back("Content-Type", type);
  response.body = std::move(body);
  return response;
}

ViewResponse refusal(int status, const char* reason) {
  return with_text(status, "text/plain; charset=utf-8", fmt::format("{}\n", reason));
}

ViewResponse not_allowed() {
  ViewResponse response = refusal(405, "only GET and HEAD are answered here");
  response.headers.emplace_back("Allow", "GET, HEAD");
  return response;
}

ViewResponse redirection(const std::string& path, const std::string& query) {
  ViewResponse response = with_headers(303);
  response.headers.emplace_back("Location", query.empty() ? path : path + "?" + query);
  return response;
}

bool is_printable(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

/// The value of `token` in the query, and the query without it.
struct TokenQuery {
  std::optional<std::string> token;
  std::string rest;
};

TokenQuery split_query(std::string_view query) {
  constexpr std::string_view kName = "token=";
  TokenQuery result;
  while (!query.empty()) {
    const std::string_view part = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), part.size() + 1));
    if (part.starts_with(kName))
      result.token = part.substr(kName.size());
    else
      result.rest += (result.rest.empty() ? "" : "&") + std::string(part);
  }
  return result;
}

bool has_cookie(const ViewRequest& request, const ViewState& state) {
  const std::string name = view_cookie_name(state.port);
  bool found = false;
  for (const std::string_view header : header_values(request.headers, "Cookie"))
    found |= cookies_have(header, name, state.token);
  return found;
}

/// Behind the token in the query; `rest` is the query without it. Lax, not Strict: a browser that
/// another page leads here must send the cookie where this answer leads to. It sends none with a
/// POST from elsewhere, which Origin refuses besides.
ViewResponse with_cookie(const ViewState& state, const std::string& rest) {
  ViewResponse response = redirection("/", rest);
  response.headers.emplace_back("Set-Cookie",
                                fmt::format("{}={}; Path=/; HttpOnly; SameSite=Lax",
                                            view_cookie_name(state.port), state.token));
  return response;
}

/// One range of a GET; several Range headers are several ranges. No answer of this server has a
/// validator, so that none can match If-Range, which requests the whole file then.
ViewResponse file_answer(const ViewRequest& request, std::string_view type, ServedFile served) {
  ViewResponse response = with_headers(200);
  response.headers.emplace_back("Accept-Ranges", "bytes");
  response.bytes = served.size;
  const std::vector<std::string_view> ranges = header_values(request.headers, "Range");
  const bool is_part = request.method == "GET" && !ranges.empty() && is_byte_range(ranges[0]) &&
                       header_values(request.headers, "If-Range").empty();
  if (is_part) {
    const std::optional<ByteRange> range =
        ranges.size() == 1 ? parse_byte_range(ranges[0], served.size) : std::nullopt;
    if (!range) {
      response = refusal(416, "one range of bytes within the file is answered");
      response.headers.emplace_back("Content-Range", fmt::format("bytes */{}", served.size));
      return response;
    }
    response.status = 206;
    response.offset = range->offset;
    response.bytes = range->bytes;
    response.headers.emplace_back("Content-Range",
                                  fmt::format("bytes {}-{}/{}", range->offset,
                                              range->offset + range->bytes - 1, served.size));
  }
  response.headers.emplace_back("Content-Type", type);
  response.file = std::move(served.file);
  return response;
}

/// The number after `name=` in the query; none where it is no number of at most 15 digits.
std::optional<int64_t> number_in(std::string_view query, std::string_view name) {
  constexpr size_t kMostDigits = 15;
  while (!query.empty()) {
    std::string_view part = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), part.size() + 1));
    if (!part.starts_with(name) || part.size() == name.size() || part[name.size()] != '=') continue;
    part.remove_prefix(name.size() + 1);
    const bool digits =
        std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (part.empty() || part.size() > kMostDigits || !digits) return std::nullopt;
    return std::stoll(std::string(part));
  }
  return std::nullopt;
}

/// None: the address is none of these.
std::optional<ViewResponse> live_answer(const ViewRequest& request, const ViewState& state) {
  if (!state.live) return std::nullopt;
  if (request.path == "/live") return with_text(200, "text/html; charset=utf-8", state.live_page);
  if (request.path == "/api/player")
    return with_text(200, "text/html; charset=utf-8", state.player_page);
  const std::string_view query = request.query;
  if (request.path == "/api/state")
    return with_text(200, "application/json",
                     state.live->state(number_in(query, "seen").value_or(0)));
  if (request.path == "/api/report")
    return with_text(200, "application/json", state.live->report());
  if (request.path == "/api/truth")
    if (std::string png = state.live->truth(number_in(query, "view").value_or(-1)); !png.empty())
      return with_text(200, "image/png", std::move(png));
  return std::nullopt;
}

/// Of a request that changes something; none: the address is none of these.
std::optional<ViewResponse> posted(const ViewRequest& request, const ViewState& state) {
  if (!state.live || request.path != "/api/stop") return std::nullopt;
  return state.live->stop() ? with_text(202, "text/plain; charset=utf-8", "it will stop\n")
                            : refusal(409, "no training is running");
}

ViewResponse resource(const ViewRequest& request, const ViewState& state) {
  if (request.path == "/" && state.start != "/") return redirection(state.start, request.query);
  if (request.path == "/api/run") return with_text(200, "application/json", state.run);
  if (std::optional<ViewResponse> live = live_answer(request, state)) return *std::move(live);
  const std::optional<std::vector<std::string>> components = path_components(request.path);
  if (components)
    if (const std::optional<std::string_view> type = media_type(components->back()))
      if (std::optional<ServedFile> served = open_served_file(state.folder, *components))
        return file_answer(request, *type, *std::move(served));
  return refusal(404, "no such file, or none that tessera view serves");
}

}  // namespace

ViewResponse answer(const ViewRequest& request, const ViewState& state) {
  if (!is_host_allowed(request, state.allowed_hosts))
    return refusal(421, "this name of the server is not allowed; pass --allow-host NAME");
  const bool is_read = request.method == "GET" || request.method == "HEAD";
  if (!is_read && request.method != "POST") return not_allowed();
  if (!is_origin_allowed(request)) return refusal(403, "requests of other pages are refused");
  if (request.body_bytes > kMostBodyBytes) return refusal(413, "the body is too large");
  const TokenQuery query = split_query(request.query);
  const bool is_authorised =
      query.token ? equal_in_constant_time(*query.token, state.token) : has_cookie(request, state);
  if (!is_authorised)
    return refusal(403, "no valid token; open the address that tessera view has printed");
  if (!is_read) return posted(request, state).value_or(not_allowed());
  if (!is_printable(request.path) || !is_printable(request.query))
    return refusal(404, "no such file");
  if (query.token && request.path == "/") return with_cookie(state, query.rest);
  return resource(request, state);
}

}  // namespace tessera
