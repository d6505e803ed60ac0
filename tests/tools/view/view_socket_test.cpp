// The server over a real socket: responses equal those of answer(), and limits hold.
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>
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

// Bug put back: connections are closed in the middle of an answer, such as that by which a page
// learns what resumes its training; seen to fail.
TEST_F(ViewSocket, AnAnswerInProgressIsSentBeforeTheServerEnds) {
  const std::string model(50'000'000, 'x');
  write("site/scene.t4d", model);
  std::atomic<bool> has_begun = false;
  std::string read;
  std::thread page([&] {
    const HttpClient client(port);
    client.send("GET /scene.t4d HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + cookie() +
                "\r\n");
    read = client.read_some();
    has_begun = true;
    read += client.read_all();
  });
  while (!has_begun) std::this_thread::yield();
  server.reset();
  page.join();
  EXPECT_EQ(read.size() - read.find("\r\n\r\n") - 4, model.size());
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
  const HttpClient next(port, 1000);
  next.send("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + cookie() + "\r\n");
  EXPECT_EQ(next.read_all(), "");
  waiting.clear();
  EXPECT_TRUE(begins(next.read_all(), "HTTP/1.1 200 "));
}

/// Bytes of a request with some of them replaced, inserted, doubled or cut off.
std::string spoiled(std::string text, std::mt19937& random) {
  const auto below = [&](size_t count) { return size_t(random() % count); };
  const size_t changes = below(6);
  for (size_t i = 0; i < changes && !text.empty(); ++i) {
    const size_t place = below(text.size());
    switch (below(5)) {
      case 0:
        text[place] = char(below(256));
        break;
      case 1:
        text.insert(place, 1, char(below(256)));
        break;
      case 2:
        text.insert(place, text.substr(below(text.size()), below(40)));
        break;
      case 3:
        text.erase(place, below(20));
        break;
      default:
        text.resize(place);
    }
  }
  return text;
}

/// TESSERA_FUZZ_REQUESTS: how many. Nothing but the page and the scene is ever sent, and
/// nothing without the token, and the server answers in the end. Bugs put back: answers without a
/// token; hidden files are served; each seen to fail.
TEST_F(ViewSocket, SpoiledRequestsGetNothing) {
  const char* const asked = std::getenv("TESSERA_FUZZ_REQUESTS");
  const int count = asked != nullptr ? std::atoi(asked) : 1000;
  const std::string end = " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n", line = "\r\n";
  const std::vector<std::string> seeds = {
      "GET /" + end + cookie() + line,
      "GET /scene.t4d" + end + cookie() + "Range: bytes=2-4\r\n" + line,
      "GET /.hidden.html" + end + cookie() + line,
      "GET /../secret.html" + end + cookie() + line,
      "GET /?token=" + std::string(kTestToken) + "&t=1" + end + line,
      "POST /api/stop" + end + cookie() +
          "Origin: http://localhost\r\nContent-Length: 4\r\n\r\nabcd",
      "POST /" + end + cookie() + "Transfer-Encoding: chunked\r\n\r\n4\r\nabcd\r\n0\r\n\r\n",
      "GET /" + end + line};
  std::mt19937 random(7);
  for (int i = 0; i < count; ++i) {
    const std::string sent = spoiled(seeds[random() % seeds.size()], random);
    const HttpClient client(port, 5);  // a request that was cut off is waited for by the server
    client.send(sent);
    const std::string got = client.read_all();
    ASSERT_TRUE(got.empty() || begins(got, "HTTP/1.")) << sent << "\n" << got;
    ASSERT_EQ(got.find("secret"), std::string::npos) << sent;
    if (sent.find(kTestToken) == std::string::npos) {
      ASSERT_EQ(got.find("<p>page"), std::string::npos) << sent;
    }
  }
  EXPECT_TRUE(begins(exchange("GET /", cookie()), "HTTP/1.1 200 "));
}

TEST_F(ViewSocket, EndsAtOnce) {
  const HttpClient idle(port), half(port);
  half.send("GET / HTTP/1.1\r\n");
  const auto begin = Clock::now();
  server.reset();
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(10)) << "idle connections have 20 s";
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
