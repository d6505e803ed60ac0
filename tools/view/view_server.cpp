// The transport: libmicrohttpd parses requests and sends the responses that answer.cpp makes.
#include "tools/view/view_server.h"

#include <microhttpd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <exception>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

namespace tessera {
namespace {

constexpr unsigned kMostConnections = 32, kIdleSeconds = 20;
constexpr size_t kConnectionBytes = 32768;
constexpr std::chrono::milliseconds kLongestAnswer{2000}, kPoll{5};  // once the server ends

/// One request until its response is sent.
struct Exchange {
  Exchange(std::string request, std::atomic<int>& all) : target(std::move(request)), count(all) {
    ++count;
  }
  ~Exchange() { --count; }

  std::string target;  // as it was received
  std::atomic<int>& count;
  bool has_begun = false;
  uint64_t body_bytes = 0;
};

/// Called with the target before anything in it is decoded; what it returns belongs to the request
/// until `end_exchange`.
void* begin_exchange(void* exchanges, const char* target, MHD_Connection*) {
  return new (std::nothrow) Exchange(target, *static_cast<std::atomic<int>*>(exchanges));
}

void end_exchange(void*, MHD_Connection*, void** exchange, MHD_RequestTerminationCode) {
  delete static_cast<Exchange*>(*exchange);
  *exchange = nullptr;
}

MHD_Result add_header(void* headers, MHD_ValueKind, const char* name, const char* value) {
  static_cast<HttpHeaders*>(headers)->emplace_back(name, value != nullptr ? value : "");
  return MHD_YES;
}

ViewRequest request_of(MHD_Connection* connection, const char* method, const Exchange& exchange) {
  const size_t mark = exchange.target.find('?');
  ViewRequest request;
  request.method = method;
  request.path = exchange.target.substr(0, mark);
  if (mark != std::string::npos) request.query = exchange.target.substr(mark + 1);
  MHD_get_connection_values(connection, MHD_HEADER_KIND, &add_header, &request.headers);
  request.body_bytes = exchange.body_bytes;
  return request;
}

/// An MHD_Response that is released with its scope.
struct Release {
  void operator()(MHD_Response* response) const { MHD_destroy_response(response); }
};
using ResponsePointer = std::unique_ptr<MHD_Response, Release>;

ResponsePointer body_of(ViewResponse& response) {
  if (response.file.is_open() && response.bytes > 0)
    return ResponsePointer(MHD_create_response_from_fd_at_offset64(
        response.bytes, response.file.release(), response.offset));
  return ResponsePointer(MHD_create_response_from_buffer(response.body.size(), response.body.data(),
                                                         MHD_RESPMEM_MUST_COPY));
}

MHD_Result send(MHD_Connection* connection, ViewResponse response) {
  const ResponsePointer message = body_of(response);
  if (!message) return MHD_NO;
  for (const auto& [name, value] : response.headers)
    if (MHD_add_response_header(message.get(), name.c_str(), value.c_str()) != MHD_YES)
      return MHD_NO;
  return MHD_queue_response(connection, static_cast<unsigned>(response.status), message.get());
}

/// The body that the client announces, in bytes; 0 where it does not.
uint64_t announced_bytes(MHD_Connection* connection) {
  const char* const length =
      MHD_lookup_connection_value(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_CONTENT_LENGTH);
  return length != nullptr ? std::strtoull(length, nullptr, 10) : 0;
}

/// Called when the headers are complete, with each part of a body, and at the end. A large body is
/// refused before it is read where it is announced; else its connection is closed.
MHD_Result handle(void* state, MHD_Connection* connection, const char*, const char* method,
                  const char*, const char*, size_t* upload_bytes, void** context) {
  if (*context == nullptr) return MHD_NO;
  Exchange& exchange = *static_cast<Exchange*>(*context);
  try {
    const auto& view = *static_cast<const ViewState*>(state);
    if (!std::exchange(exchange.has_begun, true)) {
      exchange.body_bytes = announced_bytes(connection);
      if (exchange.body_bytes > kMostBodyBytes)
        return send(connection, answer(request_of(connection, method, exchange), view));
      exchange.body_bytes = 0;
      return MHD_YES;
    }
    exchange.body_bytes += *upload_bytes;
    if (*upload_bytes == 0)
      return send(connection, answer(request_of(connection, method, exchange), view));
    *upload_bytes = 0;  // all has been taken
    return exchange.body_bytes > kMostBodyBytes ? MHD_NO : MHD_YES;
  } catch (const std::exception&) {  // out of memory: the connection is closed
    return MHD_NO;
  }
}

}  // namespace

struct ViewServer::Daemon {
  ViewState state;
  std::atomic<int> exchanges = 0;
  MHD_Daemon* daemon = nullptr;
};

void require_view_server() {}

ViewServer::ViewServer(ViewState state, ListeningSocket socket)
    : daemon_(std::make_unique<Daemon>()) {
  state.port = socket.port;
  daemon_->state = std::move(state);
  const unsigned ipv6 = socket.is_ipv6 ? unsigned(MHD_USE_IPv6) : 0;
  daemon_->daemon = MHD_start_daemon(
      unsigned(MHD_USE_EPOLL_INTERNAL_THREAD) | ipv6, socket.port, nullptr, nullptr, &handle,
      &daemon_->state, MHD_OPTION_LISTEN_SOCKET, socket.socket.release(),
      MHD_OPTION_CONNECTION_LIMIT, kMostConnections, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
      kConnectionBytes, MHD_OPTION_CONNECTION_TIMEOUT, kIdleSeconds, MHD_OPTION_STRICT_FOR_CLIENT,
      1, MHD_OPTION_URI_LOG_CALLBACK, &begin_exchange, &daemon_->exchanges,
      MHD_OPTION_NOTIFY_COMPLETED, &end_exchange, nullptr, MHD_OPTION_END);
  if (daemon_->daemon == nullptr)
    throw std::runtime_error("view: libmicrohttpd starts no server; it needs threads and epoll");
}

ViewServer::~ViewServer() {
  for (auto left = kLongestAnswer; daemon_->exchanges > 0 && left.count() > 0; left -= kPoll)
    std::this_thread::sleep_for(kPoll);
  MHD_stop_daemon(daemon_->daemon);
}

}  // namespace tessera
