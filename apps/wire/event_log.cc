#include "apps/wire/event_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error) fail("cannot read: " + error.message());
  if (!std::filesystem::is_regular_file(status)) fail("is not a file");
  size_ = std::filesystem::file_size(path);
  if (size_ == 0) fail("is empty, must be an LCM log");
  file_.open(path, std::ios::binary);
  if (!file_) fail(std::string("cannot read: ") + std::strerror(errno));
}

bool EventLogReader::next() {
  const std::uintmax_t begin = end_;
  for (std::uintmax_t at = begin; at < size_; at = find_sync_word(at + 1)) {
    const std::string fault = open(at);
    if (fault.empty()) {
      damage_.bytes += at - begin;
      return any_ = true;
    }
    if (damage_.first.empty()) damage_.first = fmt::format("byte {}: {}", at, fault);
  }
  if (!any_) fail(damage_.first);
  damage_.bytes += size_ - begin;
  end_ = size_;
  return false;
}

std::string EventLogReader::open(std::uintmax_t position) {
  const std::uintmax_t rest = size_ - position;
  if (rest < kHeaderSize)
    return fmt::format("the file ends inside the header of an event ({} of {} bytes)", rest, kHeaderSize);
  seek(position);
  std::byte buffer[kHeaderSize];
  read(buffer);
  Bytes header = buffer;
  const auto sync_word = take<std::uint32_t>(header);
  if (sync_word != kSyncWord)
    return fmt::format("no event begins here: the sync word is 0x{:08x}, must be 0x{:08x}", sync_word,
                       kSyncWord);
  take<std::int64_t>(header);  // number
  const auto timestamp = take<std::int64_t>(header);
  const auto channel_length = take<std::int32_t>(header), data_length = take<std::int32_t>(header);
  if (channel_length < 1 || channel_length > static_cast<std::int32_t>(kMaxChannelLength))
    return fmt::format("the length of the channel is {}, allowed is 1 to {}", channel_length,
                       kMaxChannelLength);
  if (data_length < 0) return fmt::format("the length of the data is {}, must not be negative", data_length);
  const std::uintmax_t size =
      kHeaderSize + static_cast<std::uintmax_t>(channel_length) + static_cast<std::uintmax_t>(data_length);
  if (size > rest)
    return fmt::format("an event of {} bytes begins here, but only {} are left in the file", size, rest);

  channel_.resize(static_cast<std::size_t>(channel_length));
  read(std::as_writable_bytes(std::span(channel_)));
  if (std::ranges::any_of(channel_, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
    return "the channel's name has control characters";
  timestamp_ = timestamp;
  position_ = position;
  end_ = position + size;
  return {};
}

std::uintmax_t EventLogReader::find_sync_word(std::uintmax_t position) {
  constexpr std::array kPattern{std::byte{0xed}, std::byte{0xa1}, std::byte{0xda}, std::byte{0x01}};
  std::array<std::byte, 65536> buffer;
  while (size_ - position >= kPattern.size()) {
    const auto block = std::span(buffer).first(std::min<std::uintmax_t>(buffer.size(), size_ - position));
    seek(position);
    read(block);
    const auto found = std::search(block.begin(), block.end(), kPattern.begin(), kPattern.end());
    if (found != block.end()) return position + static_cast<std::uintmax_t>(found - block.begin());
    position += block.size() - (kPattern.size() - 1);  // it may lie across two blocks
  }
  return size_;
}

Bytes EventLogReader::data() {
  data_.resize(std::min<std::uintmax_t>(end_ - cursor_, kMaxMessageSize + 1));
  read(data_);
  return data_;
}

void EventLogReader::seek(std::uintmax_t position) {
  constexpr std::uintmax_t kNear = 4096;  // a seek throws away what the stream has read ahead
  if (position > cursor_ && position - cursor_ <= kNear)
    file_.ignore(static_cast<std::streamsize>(position - cursor_));
  else if (cursor_ != position)
    file_.seekg(static_cast<std::streamoff>(position));
  cursor_ = position;
}

void EventLogReader::read(std::span<std::byte> bytes) {
  file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file_) fail(fmt::format("byte {}: cannot read: {}", cursor_, std::strerror(errno)));
  cursor_ += bytes.size();
}

void EventLogReader::fail(std::string_view why) const {
  throw std::runtime_error(fmt::format("{}: {}", path_, why));
}

}  // namespace leadline::app
