// Access control of the server: tokens and cookies, names of the server, other pages, methods.
#include "tests/tools/view/view_fixture.h"
#include "tools/view/view_request.h"

namespace tessera::testing {
namespace {

class ViewAccess : public ViewFolder {};

// Bugs put back: has_cookie returns true; equal_in_constant_time compares the bytes that both have;
// cookies_have compares no names; each seen to fail.
TEST_F(ViewAccess, NothingWithoutTheToken) {
  EXPECT_EQ(status("/"), 200);
  const std::string name = "tessera_view_8080=", token = kTestToken;
  for (const std::string& cookie :
       {std::string(), name, name + token.substr(0, 31), name + token + "0",
        name + "1123456789abcdef0123456789abcdef", "tessera_view_8081=" + token,
        "tessera_view_8080 =" + token, "x" + name + token, token}) {
    EXPECT_EQ(status("/", {{"Cookie", cookie}}), 403) << cookie;
    EXPECT_EQ(status("/scene.t4d", {{"Cookie", cookie}}), 403) << cookie;
    EXPECT_EQ(status("/api/run", {{"Cookie", cookie}}), 403) << cookie;
    EXPECT_EQ(status("/nowhere", {{"Cookie", cookie}}), 403) << cookie;
  }
  EXPECT_EQ(status("/", {{"Cookie", "a=1; " + name + token + "; b=2"}}), 200);
  EXPECT_EQ(status("/", {{"cookie", name + "old"}, {"cookie", name + token}}), 200);
}

// Bugs put back: the cookie without HttpOnly; a redirection that keeps the token; a wrong token
// beside a right cookie accepted; each seen to fail.
TEST_F(ViewAccess, TheTokenOfTheAddressBecomesACookie) {
  ViewRequest first = request("/", {{"Cookie", "a=1"}});
  first.query = "t=1.5&token=" + state.token + "&paused";
  const ViewResponse response = answer(first, state);
  EXPECT_EQ(response.status, 303);
  EXPECT_EQ(header(response, "Location"), "/?t=1.5&paused");
  EXPECT_EQ(header(response, "Set-Cookie"),
            std::string(kTestCookie) + "; Path=/; HttpOnly; SameSite=Lax");
  for (const std::string& token : {std::string(), state.token.substr(1), state.token + "0"}) {
    ViewRequest wrong = request("/");
    wrong.query = "token=" + token;
    const ViewResponse refused = answer(wrong, state);
    EXPECT_EQ(refused.status, 403) << token;
    EXPECT_EQ(header(refused, "Set-Cookie"), "");
  }
}

TEST_F(ViewAccess, TokensAreRandom) {
  const std::string one = make_view_token(), other = make_view_token();
  EXPECT_NE(one, other);
  EXPECT_EQ(one.size(), 32u);
  EXPECT_EQ(one.find_first_not_of("0123456789abcdef"), std::string::npos) << one;
}

// Bugs put back: is_host_allowed returns true; the first of two headers decides; the text behind
// the address in brackets is left out; each seen to fail.
TEST_F(ViewAccess, OnlyNamesOfThisMachine) {
  for (const char* host : {"localhost", "localhost:1", "127.0.0.1:8080", "[::1]:65535", "[::1]",
                           "LocalHost:8080", "127.0.0.1", "localhost:"})
    EXPECT_EQ(status("/", {{"Host", host}}), 200) << host;
  for (const char* host :
       {"evil.example", "evil.example:8080", "localhost.evil.example", "", ":80", "localhost:80x",
        "[::1].evil.example", "[::1", "127.0.0.2", "localhost@evil.example", "localhost:123456"})
    EXPECT_EQ(status("/", {{"Host", host}}), 421) << host;
  EXPECT_EQ(status("/", {{"Host", "localhost"}, {"Host", "evil.example"}}), 421);
  ViewRequest without = request("/");
  std::erase_if(without.headers, [](const auto& header) { return header.first == "Host"; });
  EXPECT_EQ(answer(without, state).status, 421);
  state.allowed_hosts = {"Login.Example"};
  EXPECT_EQ(status("/", {{"Host", "login.example:80"}}), 200);
  EXPECT_EQ(status("/", {{"Host", "other.example:80"}}), 421);
}

// Bugs put back: is_origin_allowed returns true; "null" passes; a POST without Origin passes; each
// seen to fail.
TEST_F(ViewAccess, OnlyItsOwnPages) {
  EXPECT_EQ(status("/", {{"Origin", "http://localhost:8080"}}), 200);
  for (const char* origin :
       {"null", "", "http://evil.example", "http://localhost:8081", "http://localhost",
        "http://localhost:8080.evil.example", "ftp://localhost:8080"})
    EXPECT_EQ(status("/", {{"Origin", origin}}), 403) << origin;
  EXPECT_EQ(status("/", {{"Origin", "http://localhost:8080"}, {"Origin", "null"}}), 403);
  ViewRequest post = request("/");
  post.method = "POST";
  EXPECT_EQ(answer(post, state).status, 403);
  post.headers.emplace_back("Origin", "http://localhost:8080");
  EXPECT_EQ(answer(post, state).status, 405);
}

// Bugs put back: each method is read as GET; a body of any size passes; each seen to fail.
TEST_F(ViewAccess, OnlyReading) {
  ViewRequest made = request("/", {{"Origin", "http://localhost:8080"}});
  for (const char* method : {"OPTIONS", "PUT", "DELETE", "TRACE", "CONNECT", "PATCH", "get", ""}) {
    made.method = method;
    const ViewResponse response = answer(made, state);
    EXPECT_EQ(response.status, 405) << method;
    EXPECT_EQ(header(response, "Allow"), "GET, HEAD") << method;
  }
  made.method = "HEAD";
  EXPECT_EQ(answer(made, state).bytes, 11u);
  made.method = "POST";
  made.body_bytes = kMostBodyBytes;
  EXPECT_EQ(answer(made, state).status, 405);
  made.body_bytes = kMostBodyBytes + 1;
  EXPECT_EQ(answer(made, state).status, 413);
}

// Bug put back: refusals without these headers; seen to fail.
TEST_F(ViewAccess, EachAnswerHasTheHeadersOfSecurity) {
  const ViewResponse answers[] = {get("/"), get("/nowhere"), get("/", {{"Host", "evil.example"}}),
                                  get("/scene.t4d", {{"Range", "bytes=9-1"}})};
  for (const ViewResponse& response : answers) {
    EXPECT_EQ(header(response, "X-Content-Type-Options"), "nosniff") << response.status;
    EXPECT_EQ(header(response, "Referrer-Policy"), "no-referrer") << response.status;
    const std::string policy = header(response, "Content-Security-Policy");
    EXPECT_NE(policy.find("default-src 'none'"), std::string::npos) << policy;
    EXPECT_NE(policy.find("connect-src 'self' data: blob:;"), std::string::npos) << policy;
    EXPECT_EQ(policy.find("http"), std::string::npos) << policy;
    EXPECT_NE(header(response, "Content-Type"), "") << response.status;
  }
}

// Bug put back: a line end in the query reaches the Location header; seen to fail.
TEST_F(ViewAccess, HeadersCannotBeInserted) {
  ViewRequest made = request("/");
  made.query = "token=" + state.token + "&a\r\nX-Evil: 1";
  const ViewResponse response = answer(made, state);
  EXPECT_EQ(response.status, 404);
  EXPECT_EQ(header(response, "Location"), "");
}

}  // namespace
}  // namespace tessera::testing
