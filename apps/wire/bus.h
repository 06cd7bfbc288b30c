/// @file
/// The LCM network: raw bytes in and out.
#pragma once

#include <chrono>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <list>
#include <memory>
#include <string>
#include <string_view>

#include "apps/wire/wire.h"

namespace leadline::app {

/// The one owner of an LCM object, for one thread. Not open until the network is there; a network that goes
/// away closes it, and open() tries again.
class Bus {
 public:
  using Handler = std::function<void(std::string_view channel, Bytes data)>;

  /// Not open yet. @param url of the network, as "udpm://239.255.76.67:7667?ttl=0".
  explicit Bus(std::string url);
  /// Open, if @p lcm is good; once closed it stays closed. For tests: "memq://".
  explicit Bus(std::unique_ptr<lcm::LCM> lcm);
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// From now on @p handler gets every message on a channel that begins with @p prefix, also after the bus
  /// was closed and opened again. The data hold while it runs; of messages that are too large to be used they
  /// are only the beginning, or nothing. What it throws is printed to stderr. It may publish, but not open.
  void subscribe(const std::string& prefix, Handler handler);

  /// Opens the bus unless it is open. @return false with the reason in trouble() if that is not possible now.
  bool open();
  bool is_open() const { return lcm_ && !failed_; }

  /// @return false if the message was not sent, because the bus is closed or is so from now on.
  bool publish(std::string_view channel, Bytes data);

  /// Waits for a message, at most @p timeout or until a signal comes, then hands out those that are there, up
  /// to a number that takes no long time. While closed it only waits. @return how many messages were handled.
  int handle(std::chrono::milliseconds timeout);

  /// Why the bus is not open; empty while it is.
  const std::string& trouble() const { return trouble_; }

 private:
  struct Subscription {
    std::string pattern;
    Handler handler;
  };

  static void receive(const lcm_recv_buf_t* buffer, const char* channel, void* subscription);
  bool listen(Subscription& subscription);
  void fail(std::string trouble);

  std::string url_;                        // empty: the LCM object was given
  std::list<Subscription> subscriptions_;  // LCM holds their addresses
  std::unique_ptr<lcm::LCM> lcm_;
  bool failed_ = false;  // to be closed; not at once, for a handler may be running
  std::string trouble_;
};

}  // namespace leadline::app
