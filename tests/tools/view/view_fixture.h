// A folder with a page, a scene and files that must not be served, and requests for its files.
#pragma once
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/scratch_folder.h"
#include "tools/view/answer.h"

namespace tessera::testing {

constexpr const char* kTestToken = "0123456789abcdef0123456789abcdef";
constexpr const char* kTestCookie = "tessera_view_8080=0123456789abcdef0123456789abcdef";

class ViewFolder : public ::testing::Test {
 protected:
  ViewFolder() {
    write("site/index.html", "<p>page</p>");
    write("site/scene.t4d", "0123456789");
    write("site/player/index.html", "<p>player</p>");
    write("site/a b.png", "image");
    write("site/checkpoint.ckpt", "secret");
    write("site/.hidden.html", "secret");
    write("secret.html", "secret");
    state.folder = OpenFile(::open((folder / "site").c_str(), O_RDONLY | O_DIRECTORY));
    state.token = kTestToken;
    state.port = 8080;
  }

  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name) << text;
  }

  /// A GET with the right cookie; `more` takes the place of headers of the same name.
  static ViewRequest request(const std::string& path, const HttpHeaders& more = {}) {
    ViewRequest made;
    made.method = "GET";
    made.path = path;
    made.headers = more;
    if (header_values(more, "Host").empty()) made.headers.emplace_back("Host", "localhost:8080");
    if (header_values(more, "Cookie").empty()) made.headers.emplace_back("Cookie", kTestCookie);
    return made;
  }
  ViewResponse get(const std::string& path, const HttpHeaders& more = {}) const {
    return answer(request(path, more), state);
  }
  int status(const std::string& path, const HttpHeaders& more = {}) const {
    return get(path, more).status;
  }

  static std::string header(const ViewResponse& response, const std::string& name) {
    const auto values = header_values(response.headers, name);
    return values.size() == 1 ? std::string(values[0]) : "";
  }
  /// The bytes that a client reads.
  static std::string body(const ViewResponse& response) {
    if (!response.file.is_open()) return response.body;
    std::string text(response.bytes, '\0');
    const ssize_t read =
        ::pread(response.file.descriptor(), text.data(), text.size(), off_t(response.offset));
    text.resize(read > 0 ? size_t(read) : 0);
    return text;
  }

  ScratchFolder folder;
  ViewState state;
};

}  // namespace tessera::testing
