#include "apps/wire/bus.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <exception>
#include <optional>
#include <span>
#include <utility>

namespace leadline::app {
namespace {

constexpr int kQueueCapacity = 10000;           // messages; LCM's own default is 30
constexpr int kAtOnce = 1000;                   // messages of one handle()
constexpr std::uint32_t kMaxLcmSize = 1 << 28;  // LCM refuses larger messages itself

/// Pattern of the channels that begin with @p prefix.
std::string pattern_of(const std::string& prefix) {
  constexpr std::string_view kSpecial = R"(\^$.|?*+()[]{})";
  std::string pattern;
  for (const char c : prefix) {
    if (kSpecial.find(c) != std::string_view::npos) pattern += '\\';
    pattern += c;
  }
  return pattern + ".*";
}

/// Address of a multicast network; empty for others and for what LCM will refuse.
std::optional<sockaddr_in> address_of(std::string_view url) {
  constexpr std::string_view kScheme = "udpm://", kDefault = "239.255.76.67:7667";
  if (!url.starts_with(kScheme)) return std::nullopt;
  url.remove_prefix(kScheme.size());
  const std::string_view network = url.substr(0, url.find('?'));
  const std::string text(network.empty() ? kDefault : network);
  const std::size_t colon = std::min(text.find(':'), text.size());
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);  // of no account: nothing is sent
  if (inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1) return std::nullopt;
  return address;
}

/// Why nothing can be sent to the network; empty if it can. LCM would find that out, too, but loses a file
/// descriptor each time.
std::string missing_route(const std::string& url) {
  const std::optional<sockaddr_in> address = address_of(url);
  if (!address) return {};
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const bool reachable =
      fd >= 0 && ::connect(fd, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0;
  std::string reason = reachable ? "" : std::strerror(errno);
  if (fd >= 0) ::close(fd);
  return reason;
}

}  // namespace

Bus::Bus(std::string url) : url_(std::move(url)), trouble_(fmt::format("{}: not opened yet", url_)) {}

Bus::Bus(std::unique_ptr<lcm::LCM> lcm) : lcm_(std::move(lcm)) {
  if (!lcm_->good()) fail("the LCM object given is not good");
}

void Bus::subscribe(const std::string& prefix, Handler handler) {
  subscriptions_.push_back({pattern_of(prefix), std::move(handler)});
  if (is_open()) listen(subscriptions_.back());
}

bool Bus::open() {
  if (is_open()) return true;
  if (url_.empty()) return false;
  lcm_.reset();
  failed_ = false;
  if (const std::string reason = missing_route(url_); !reason.empty()) {
    fail(fmt::format("{}: {}", url_, reason));
    return false;
  }
  lcm_ = std::make_unique<lcm::LCM>(url_);
  if (!lcm_->good()) {
    fail(fmt::format("{}: LCM cannot open it", url_));
    return false;
  }
  trouble_.clear();
  return std::ranges::all_of(subscriptions_, [this](Subscription& s) { return listen(s); });
}

bool Bus::publish(std::string_view channel, Bytes data) {
  if (!is_open()) return false;
  errno = 0;
  if (lcm_->publish(std::string(channel), data.data(), static_cast<unsigned int>(data.size())) == 0)
    return true;
  fail(fmt::format("{}: cannot send: {}", url_, std::strerror(errno)));
  return false;
}

int Bus::handle(std::chrono::milliseconds timeout) {
  const bool listening = is_open() && !subscriptions_.empty();
  pollfd incoming{listening ? lcm_->getFileno() : -1, POLLIN, 0};
  if (::poll(&incoming, 1, static_cast<int>(timeout.count())) <= 0) return 0;
  int handled = 0;
  while (handled < kAtOnce && is_open()) {
    const int status = lcm_->handleTimeout(0);
    if (status == 0) break;
    if (status < 0) {
      fail(fmt::format("{}: cannot receive", url_));
      break;
    }
    ++handled;
  }
  return handled;
}

// Nothing may be thrown through LCM, which is C.
void Bus::receive(const lcm_recv_buf_t* buffer, const char* channel, void* subscription) {
  try {
    // A datagram that ends inside its header has a size below 0, read as unsigned.
    const std::size_t size =
        buffer->data_size > kMaxLcmSize ? 0 : std::min<std::size_t>(buffer->data_size, kMaxMessageSize + 1);
    const std::span data(static_cast<const std::uint8_t*>(buffer->data), size);
    static_cast<Subscription*>(subscription)->handler(channel, std::as_bytes(data));
  } catch (const std::exception& error) {
    fmt::print(stderr, "leadline: a message on {} was not handled: {}\n", channel, error.what());
  }
}

bool Bus::listen(Subscription& subscription) {
  // Asking for the descriptor tests whether what is sent comes back; subscribing would not tell.
  if (lcm_->getFileno() < 0) {
    fail(fmt::format("{}: what is sent there does not come back; see routes and firewall", url_));
    return false;
  }
  lcm_subscription_t* added =
      lcm_subscribe(lcm_->getUnderlyingLCM(), subscription.pattern.c_str(), receive, &subscription);
  if (added == nullptr) {
    fail(fmt::format("{}: cannot subscribe to {}", url_, subscription.pattern));
    return false;
  }
  lcm_subscription_set_queue_capacity(added, kQueueCapacity);
  return true;
}

void Bus::fail(std::string trouble) {
  failed_ = true;
  trouble_ = std::move(trouble);
}

}  // namespace leadline::app
