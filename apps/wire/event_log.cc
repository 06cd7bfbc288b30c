#include "apps/wire/event_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <type_traits>

namespace leadline::app {
namespace {

constexpr std::uint32_t kSyncWord = 0xeda1da01;
constexpr std::size_t kHeaderSize = 28;
constexpr std::size_t kMaxChannelLength = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH

template <class Integer>
void append(Integer value, std::vector<std::byte>& bytes) {
  for (int shift = 8 * (static_cast<int>(sizeof value) - 1); shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::byte>(value >> shift & 0xff));
  }
}

template <class Integer>
Integer take(Bytes& bytes) {
  std::make_unsigned_t<Integer> value = 0;
  for (const std::byte byte : bytes.first(sizeof value))
    value = value << 8 | std::to_integer<decltype(value)>(byte);
  bytes = bytes.subspan(sizeof value);
  return static_cast<Integer>(value);
}

}  // namespace

void EventLogWriter::write(std::int64_t timestamp, std::string_view channel, Bytes data) {
  if (channel.empty() || channel.size() > kMaxChannelLength) {
    throw std::invalid_argument(fmt::format("channel '{}' has {} bytes, allowed is 1 to {}", channel,
                                            channel.size(), kMaxChannelLength));
  }
  std::vector<std::byte> header;
  header.reserve(kHeaderSize);
  append(kSyncWord, header);
  append(number_++, header);
  append(timestamp, header);
  append(static_cast<std::int32_t>(channel.size()), header);
  append(static_cast<std::int32_t>(data.size()), header);
  file_.write(header);
  file_.write(std::as_bytes(std::span(channel)));
  file_.write(data);
}

EventLogReader::EventLogReader(const std::filesystem::path& path) : path_(path.string()) {
  const auto refuse = [this](std::string_view why) {
    throw std::runtime_error(fmt::format("{}: {}", path_, why));
  };
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error) refuse("cannot read: " + error.message());
  if (!std::filesystem::is_regular_file(status)) refuse("is not a file");
  size_ = std::filesystem::file_size(path);
  if (size_ == 0) refuse("is empty, must be an LCM log");
  file_.open(path, std::ios::binary);
  if (!file_) refuse(std::string("cannot read: ") + std::strerror(errno));
}

bool EventLogReader::next() {
  position_ = end_;
  if (position_ == size_) return false;
  const std::uintmax_t rest = size_ - position_;
  if (rest < kHeaderSize)
    fail("the file ends inside the header of an event ({} of {} bytes)", rest, kHeaderSize);
  if (cursor_ != position_) file_.seekg(static_cast<std::streamoff>(position_));
  cursor_ = position_;

  std::byte buffer[kHeaderSize];
  read(buffer);
  Bytes header = buffer;
  const auto sync_word = take<std::uint32_t>(header);
  if (sync_word != kSyncWord) {
    fail("no event begins here: the sync word is 0x{:08x}, must be 0x{:08x}", sync_word, kSyncWord);
  }
  take<std::int64_t>(header);  // number
  take<std::int64_t>(header);  // timestamp
  const auto channel_length = take<std::int32_t>(header), data_length = take<std::int32_t>(header);
  if (channel_length < 1 || channel_length > static_cast<std::int32_t>(kMaxChannelLength)) {
    fail("the length of the channel is {}, allowed is 1 to {}", channel_length, kMaxChannelLength);
  }
  if (data_length < 0) fail("the length of the data is {}, must not be negative", data_length);
  const std::uintmax_t size =
      kHeaderSize + static_cast<std::uintmax_t>(channel_length) + static_cast<std::uintmax_t>(data_length);
  if (size > rest) fail("an event of {} bytes begins here, but only {} are left in the file", size, rest);

  channel_.resize(static_cast<std::size_t>(channel_length));
  read(std::as_writable_bytes(std::span(channel_)));
  end_ = position_ + size;
  return true;
}

Bytes EventLogReader::data() {
  data_.resize(std::min<std::uintmax_t>(end_ - cursor_, kMaxMessageSize + 1));
  read(data_);
  return data_;
}

void EventLogReader::read(std::span<std::byte> bytes) {
  file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file_) fail("cannot read: {}", std::strerror(errno));
  cursor_ += bytes.size();
}

template <class... Args>
void EventLogReader::fail(std::string_view format, const Args&... args) const {
  throw std::runtime_error(
      fmt::format("{}: byte {}: {}", path_, position_, fmt::format(fmt::runtime(format), args...)));
}

}  // namespace leadline::app
