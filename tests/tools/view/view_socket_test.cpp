// The server over a real socket: what arrives is what answer() decides, and limits hold.
#include <chrono>
#include <vector>

#include "kernels/base/errors.h"
#include "tests/tools/view/http_client.h"
#include "tests/tools/view/view_fixture.h"
#include "tools/view/view_server.h"

namespace tessera::testing {
namespace {

using Clock = std::chrono::steady_clock;

class ViewSocket : public ViewFolder {
 protected:
  void SetUp() override {
#if !TESSERA_HAS_VIEW
    EXPECT_THROW(require_view_server(), InputError);
    GTEST_SKIP() << "built without libmicrohttpd";
#endif
    ListeningSocket socket = listen_on("127.0.0.1", 0);
    port = socket.port;
    EXPECT_TRUE(socket.is_loopback);
    server = std::make_unique<ViewServer>(std::move(state), std::move(socket));
  }

  std::string cookie() const {
    return "Cookie: tessera_view_" + std::to_string(port) + "=" + kTestToken + "\r\n";
  }
  /// The answer to one request with the right Host header.
  std::string exchange(const std::string& first_line, const std::string& headers,
                       const std::string& sent_body = {}) const {
    const HttpClient client(port);
    client.send(first_line + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + headers +
                "\r\n" + sent_body);
    return client.read_all();
  }

  uint16_t port = 0;
  std::unique_ptr<ViewServer> server;
};

bool begins(const std::string& text, const std::string& start) {
  return text.starts_with(start);
}

// Bugs put back: the path as libmicrohttpd decodes it; the query is lost; each seen to fail.
TEST_F(ViewSocket, AnswersAsTheFunctionDoes) {
  const std::string page = exchange("GET /", cookie());
  EXPECT_TRUE(begins(page, "HTTP/1.1 200 ")) << page;
  EXPECT_TRUE(page.ends_with("\r\n\r\n<p>page</p>")) << page;
  EXPECT_NE(page.find("Content-Length: 11\r\n"), std::string::npos) << page;
  const std::string part = exchange("GET /scene.t4d", cookie() + "Range: bytes=2-4\r\n");
  EXPECT_TRUE(begins(part, "HTTP/1.1 206 ") && part.ends_with("\r\n\r\n234")) << part;
  EXPECT_TRUE(exchange("HEAD /", cookie()).ends_with("\r\n\r\n"));
  EXPECT_TRUE(begins(exchange("GET /", ""), "HTTP/1.1 403 "));
  const std::string first = exchange(std::string("GET /?token=") + kTestToken + "&t=1", "");
  EXPECT_TRUE(begins(first, "HTTP/1.1 303 ")) << first;
  EXPECT_NE(first.find("Location: /?t=1\r\n"), std::string::npos) << first;
  EXPECT_NE(first.find("tessera_view_" + std::to_string(port) + "="), std::string::npos) << first;
  for (const char* path : {"/../secret.html", "/%2e%2e/secret.html", "/%252e%252e/secret.html",
                           "/player%2findex.html", "//index.html", "/..\\secret.html"})
    EXPECT_TRUE(begins(exchange(std::string("GET ") + path, cookie()), "HTTP/1.1 404 ")) << path;
  EXPECT_TRUE(begins(exchange("OPTIONS /", cookie()), "HTTP/1.1 405 "));
}

// Bug put back: bodies are read without a limit; seen to fail.
TEST_F(ViewSocket, LargeRequestsAreRefused) {
  const std::string same_origin = cookie() + "Origin: http://localhost\r\n";
  const std::string five = exchange("POST /", same_origin + "Content-Length: 5\r\n", "12345");
  EXPECT_TRUE(begins(five, "HTTP/1.1 405 ")) << five;
  const std::string large = exchange("POST /", same_origin + "Content-Length: 5000\r\n");
  EXPECT_TRUE(begins(large, "HTTP/1.1 413 ")) << large;
  const std::string chunk = "1000\r\n" + std::string(4096, 'x') + "\r\n";
  const std::string chunks = exchange("POST /", same_origin + "Transfer-Encoding: chunked\r\n",
                                      chunk + chunk + "0\r\n\r\n");
  EXPECT_EQ(chunks, "");
  const std::string headers = exchange("GET /", "A: " + std::string(40000, 'x') + "\r\n");
  EXPECT_TRUE(begins(headers, "HTTP/1.1 431 ")) << headers.substr(0, 200);
}

/// One more waits until another ends. Bug put back: a limit of 1000 connections; seen to fail.
TEST_F(ViewSocket, ThirtyTwoConnections) {
  std::vector<std::unique_ptr<HttpClient>> waiting;
  for (int i = 0; i < 32; ++i) {
    waiting.push_back(std::make_unique<HttpClient>(port));
    waiting.back()->send("GET / HTTP/1.1\r\n");
  }
  const HttpClient next(port, 1);
  next.send("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + cookie() + "\r\n");
  EXPECT_EQ(next.read_all(), "");
  waiting.clear();
  EXPECT_TRUE(begins(next.read_all(), "HTTP/1.1 200 "));
}

TEST_F(ViewSocket, EndsAtOnce) {
  const HttpClient idle(port), half(port);
  half.send("GET / HTTP/1.1\r\n");
  const auto begin = Clock::now();
  server.reset();
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(2));
  EXPECT_EQ(idle.read_all() + half.read_all(), "");
}

TEST(ViewAddress, IsChosenAndRefused) {
  const ListeningSocket any = listen_on("0.0.0.0", 0);
  EXPECT_TRUE(any.is_any && !any.is_loopback && any.port != 0);
  EXPECT_THROW(listen_on("127.0.0.1", any.port), InputError);
  EXPECT_THROW(listen_on("no address", 0), InputError);
}

}  // namespace
}  // namespace tessera::testing
