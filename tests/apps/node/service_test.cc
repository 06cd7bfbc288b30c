#include "apps/node/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

// Listens as systemd does.
class ServiceTest : public testing::Test {
 protected:
  void SetUp() override {
    const std::string path = folder_ / "notify";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::ranges::copy(path, address.sun_path);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::close(socket_);
  }

  std::string heard() const {
    std::array<char, 256> text{};
    const ssize_t size = ::recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "";
  }

 private:
  ScratchFolder folder_;
  int socket_ = ::socket(AF_UNIX, SOCK_DGRAM, 0);
};

TEST_F(ServiceTest, TellsSystemd) {
  service::ready();
  EXPECT_EQ(heard(), "READY=1");
  service::alive();
  EXPECT_EQ(heard(), "WATCHDOG=1");
  service::status("port is silent\nfor 3 s");
  EXPECT_EQ(heard(), "STATUS=port is silent for 3 s");
  service::stopping();
  EXPECT_EQ(heard(), "STOPPING=1");
}

TEST(Service, IsSilentWhereNobodyListens) {
  ::unsetenv("NOTIFY_SOCKET");
  service::ready();
  service::alive();
  service::status("fine");
  service::stopping();
}

}  // namespace
}  // namespace leadline::app
