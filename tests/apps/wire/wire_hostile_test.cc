#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "apps/wire/messages.h"
#include "tests/apps/wire/sample_messages.h"

namespace leadline::app {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::int32_t kIntMin = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kIntMax = std::numeric_limits<std::int32_t>::max();

// Puts bytes together by hand, as a hostile sender would.
class Payload {
 public:
  explicit Payload(std::int64_t fingerprint) { put(fingerprint); }

  // A sound message without its last bytes.
  template <class T>
  static Payload cut(const T& message, std::size_t last) {
    Payload payload(0);
    payload.bytes_ = encode(message);
    payload.bytes_.resize(payload.bytes_.size() - last);
    return payload;
  }

  template <class Value>
  Payload& put(Value value) {
    if constexpr (std::is_same_v<Value, double>) {
      return put(std::bit_cast<std::int64_t>(value));
    } else {
      for (int shift = 8 * (static_cast<int>(sizeof value) - 1); shift >= 0; shift -= 8) {
        bytes_.push_back(static_cast<std::byte>(value >> shift & 0xff));
      }
      return *this;
    }
  }
  Payload& text(std::string_view text) {
    for (const char c : text) bytes_.push_back(static_cast<std::byte>(c));
    return *this;
  }
  Payload& zeros(std::size_t count) {
    bytes_.resize(bytes_.size() + count);
    return *this;
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

struct Case {
  const char* what;
  Payload payload;
  RejectReason reason;
};

template <class T>
void expect_refused(std::initializer_list<Case> cases) {
  for (const Case& test : cases) {
    const auto rejection = check(message_format<T>(), test.payload.bytes());
    ASSERT_TRUE(rejection) << test.what;
    EXPECT_EQ(rejection->reason, test.reason) << test.what << ": " << rejection->text;
  }
}

TEST(HostileWire, RefusesSonarMessages) {
  // A sound beginning, up to the length of the sensor's name.
  const auto begin = [](std::int64_t utime = 1, std::int64_t seq = 0) {
    return Payload(range_sonar_t::getHash()).put(utime).put(seq);
  };
  const auto named = [&] { return begin().put(std::int32_t{5}).text(std::string_view("port\0", 5)); };
  const auto one = [&](double range, std::int32_t label) {
    return named().put(std::int32_t{1}).put(range).put(label);
  };
  const auto quality = [&](double sigma, double confidence) {
    return one(1.0, -1).put(sigma).put(confidence);
  };
  const std::string long_name(65, 'a');
  expect_refused<range_sonar_t>({
      {"negative count", named().put(std::int32_t{-1}), RejectReason::bad_count},
      {"smallest count", named().put(kIntMin), RejectReason::bad_count},
      {"count 2^28", named().put(std::int32_t{1} << 28), RejectReason::bad_count},
      {"count 2^29 wraps its size", named().put(std::int32_t{1} << 29), RejectReason::bad_count},
      {"largest count", named().put(kIntMax), RejectReason::bad_count},
      {"one too many", named().put(range_sonar_t::MAX_ECHOES + 1), RejectReason::bad_count},
      {"count without elements", named().put(std::int32_t{64}), RejectReason::too_short},
      {"smallest text length", begin().put(kIntMin), RejectReason::bad_text},
      {"largest text length", begin().put(kIntMax), RejectReason::bad_text},
      {"text length -1", begin().put(std::int32_t{-1}), RejectReason::bad_text},
      {"text length 0", begin().put(std::int32_t{0}), RejectReason::bad_text},
      {"empty text", begin().put(std::int32_t{1}).put('\0'), RejectReason::bad_text},
      {"text too long", begin().put(std::int32_t{66}).text(long_name).put('\0'), RejectReason::bad_text},
      {"text longer than the message", begin().put(std::int32_t{60}).text("port"), RejectReason::too_short},
      {"text not terminated", begin().put(std::int32_t{4}).text("port").put(std::int32_t{0}),
       RejectReason::bad_text},
      {"zero inside the text",
       begin().put(std::int32_t{3}).text(std::string_view("a\0\0", 3)).put(std::int32_t{0}),
       RejectReason::bad_text},
      {"control character",
       begin().put(std::int32_t{3}).text(std::string_view("a\n\0", 3)).put(std::int32_t{0}),
       RejectReason::bad_text},
      {"range NaN", one(kNan, -1), RejectReason::not_finite},
      {"range infinite", one(kInf, -1), RejectReason::not_finite},
      {"range negative", one(-0.001, -1), RejectReason::out_of_range},
      {"range huge", one(1e300, -1), RejectReason::out_of_range},
      {"label -2", one(1.0, -2), RejectReason::out_of_range},
      {"no quality", one(1.0, -1), RejectReason::too_short},
      {"sigma negative", quality(-0.1, 1.0), RejectReason::out_of_range},
      {"sigma NaN", quality(kNan, 1.0), RejectReason::not_finite},
      {"confidence in percent", quality(0.1, 95.0), RejectReason::out_of_range},
      {"confidence NaN", quality(0.1, kNan), RejectReason::not_finite},
      {"last time", begin(std::numeric_limits<std::int64_t>::max()), RejectReason::out_of_range},
      {"counter negative", begin(0, -1), RejectReason::out_of_range},
  });
}

TEST(HostileWire, RefusesSubmaps) {
  submap_t empty{};
  empty.total = 3;
  const auto up_to_total = [&] { return Payload::cut(empty, 12); };
  const auto counted = [&](std::int32_t count) { return Payload::cut(empty, 4).put(count); };
  // One feature up to its covariance.
  const auto one = [&](std::int8_t kind = 1) {
    return counted(1).put(std::int32_t{7}).put(kind).put(std::int8_t{1}).put(std::int32_t{5}).zeros(8 * 8);
  };
  expect_refused<submap_t>({
      {"negative total", up_to_total().put(std::int32_t{-1}), RejectReason::bad_count},
      {"negative first", up_to_total().put(std::int32_t{3}).put(std::int32_t{-1}),
       RejectReason::out_of_range},
      {"negative count", counted(-1), RejectReason::bad_count},
      {"smallest count", counted(kIntMin), RejectReason::bad_count},
      {"largest count", counted(kIntMax), RejectReason::bad_count},
      {"more than there are", counted(4).zeros(4 * 98), RejectReason::bad_count},
      {"one too many",
       up_to_total().put(kIntMax).put(std::int32_t{0}).put(submap_t::MAX_FEATURES + 1).zeros(257 * 98),
       RejectReason::bad_count},
      {"count without elements", counted(3), RejectReason::too_short},
      {"elements without covariances", counted(3).zeros(3 * 74), RejectReason::too_short},
      {"half a covariance", one().put(1.0).put(0.0), RejectReason::too_short},
      {"unknown kind", one(6).zeros(3 * 8), RejectReason::out_of_range},
      {"negative kind", one(-1).zeros(3 * 8), RejectReason::out_of_range},
      {"covariance NaN", one().put(1.0).put(kNan).put(1.0), RejectReason::not_finite},
      {"covariance infinite", one().put(kInf).put(0.0).put(1.0), RejectReason::not_finite},
      {"negative variance", one().put(-0.1).put(0.0).put(1.0), RejectReason::not_covariance},
      {"correlation above 1", one().put(1.0).put(1.1).put(1.0), RejectReason::not_covariance},
      {"correlation with what is known", one().put(0.0).put(0.1).put(1.0), RejectReason::not_covariance},
      {"trailing byte", one().zeros(3 * 8 + 1), RejectReason::trailing_bytes},
  });
}

TEST(HostileWire, RefusesSubmapGraphs) {
  submap_graph_t empty{};
  empty.total = 2;
  const auto counted = [&](std::int32_t submaps) { return Payload::cut(empty, 8).put(submaps); };
  const auto linked = [&](std::int32_t links) { return counted(2).zeros(2 * 80).put(links); };
  expect_refused<submap_graph_t>({
      {"negative count", counted(-1), RejectReason::bad_count},
      {"largest count", counted(kIntMax), RejectReason::bad_count},
      {"more than there are", counted(3).zeros(3 * 80), RejectReason::bad_count},
      {"count without elements", counted(2), RejectReason::too_short},
      {"no second count", counted(2).zeros(2 * 80), RejectReason::too_short},
      {"negative second count", linked(-1), RejectReason::bad_count},
      {"smallest second count", linked(kIntMin), RejectReason::bad_count},
      {"second count 2^29 wraps its size", linked(1 << 29), RejectReason::bad_count},
      {"one link too many", linked(submap_graph_t::MAX_LINKS + 1).zeros(257 * 80), RejectReason::bad_count},
      {"links without elements", linked(submap_graph_t::MAX_LINKS), RejectReason::too_short},
      {"as many links as submaps, in bytes for fewer", linked(2).zeros(80), RejectReason::too_short},
      {"more links than submaps, and a byte", linked(3).zeros(3 * 80 + 1), RejectReason::trailing_bytes},
      {"covariance of a link", linked(1).zeros(32).put(1.0).put(0.9).put(-0.9).put(1.0).put(0.9).put(1.0),
       RejectReason::not_covariance},
  });
}

TEST(HostileWire, RefusesMapChanges) {
  const auto counted = [](std::int32_t count) { return Payload::cut(map_changes_t{}, 4).put(count); };
  const auto one = [&](std::int32_t feature, std::int8_t reason, std::int32_t into) {
    return counted(1).put(feature).put(reason).put(into);
  };
  ASSERT_FALSE(check(message_format<map_changes_t>(), one(7, map_changes_t::JOINED, 3).bytes()));
  expect_refused<map_changes_t>({
      {"negative count", counted(-1), RejectReason::bad_count},
      {"smallest count", counted(kIntMin), RejectReason::bad_count},
      {"largest count", counted(kIntMax), RejectReason::bad_count},
      {"count 2^29 wraps its size", counted(1 << 29), RejectReason::bad_count},
      {"one too many", counted(map_changes_t::MAX_CHANGES + 1).zeros(1025 * 9), RejectReason::bad_count},
      {"count without elements", counted(map_changes_t::MAX_CHANGES), RejectReason::too_short},
      {"without the ones that stay", counted(2).zeros(2 * 5), RejectReason::too_short},
      {"feature -2", one(-2, 0, -1), RejectReason::out_of_range},
      {"unknown reason", one(7, 3, -1), RejectReason::out_of_range},
      {"negative reason", one(7, -1, -1), RejectReason::out_of_range},
      {"into -2", one(7, 2, -2), RejectReason::out_of_range},
      {"trailing byte", one(7, 2, 3).zeros(1), RejectReason::trailing_bytes},
  });
}

TEST(HostileWire, RefusesHealth) {
  const slam_health_t empty{};
  const auto streams = [&](std::int32_t count) { return Payload::cut(empty, 8).put(count); };
  const auto first_of_two = [&] { return streams(2).put(std::int32_t{2}).text(std::string_view("a\0", 2)); };
  const auto reasons = [&](std::int32_t count) { return Payload::cut(empty, 4).put(count); };
  const std::string long_name(slam_health_t::MAX_NAME + 1, 'a');
  expect_refused<slam_health_t>({
      {"negative count", streams(-1), RejectReason::bad_count},
      {"one too many", streams(slam_health_t::MAX_STREAMS + 1).zeros(65 * 80), RejectReason::bad_count},
      {"count without elements", streams(slam_health_t::MAX_STREAMS), RejectReason::too_short},
      {"first text with smallest length", streams(2).put(kIntMin), RejectReason::bad_text},
      {"second text missing", first_of_two(), RejectReason::too_short},
      {"second text with half a length", first_of_two().put(std::int16_t{0}), RejectReason::too_short},
      {"second text with smallest length", first_of_two().put(kIntMin), RejectReason::bad_text},
      {"second text with largest length", first_of_two().put(kIntMax), RejectReason::bad_text},
      {"second text with length 0", first_of_two().put(std::int32_t{0}), RejectReason::bad_text},
      {"second text empty", first_of_two().put(std::int32_t{1}).zeros(1), RejectReason::bad_text},
      {"second text not terminated", first_of_two().put(std::int32_t{2}).text("bc").zeros(8),
       RejectReason::bad_text},
      {"second text longer than the message", first_of_two().put(std::int32_t{100}).text("b"),
       RejectReason::too_short},
      {"second text too long", first_of_two().put(std::int32_t{130}).text(long_name).zeros(1),
       RejectReason::bad_text},
      {"texts without the other arrays", first_of_two().put(std::int32_t{2}).text("b").zeros(1),
       RejectReason::too_short},
      {"negative second count", reasons(-1), RejectReason::bad_count},
      {"largest second count", reasons(kIntMax), RejectReason::bad_count},
      {"reasons without elements", reasons(slam_health_t::MAX_REASONS), RejectReason::too_short},
      {"reason empty", reasons(1).put(std::int32_t{1}).zeros(9), RejectReason::bad_text},
      {"negative number of refused", reasons(1).put(std::int32_t{2}).text("a").zeros(1).put(std::int64_t{-1}),
       RejectReason::out_of_range},
  });
}

TEST(HostileWire, RefusesCommands) {
  const auto of_kind = [](std::int8_t kind) {
    return Payload(slam_command_t::getHash()).put(std::int64_t{1}).put(std::int64_t{0}).put(kind);
  };
  const auto named = [&](std::int32_t length) { return of_kind(slam_command_t::SAVE_MAP).put(length); };
  const auto at = [&](double x, double x_sigma) {
    return named(1).zeros(1).put(x).put(0.0).put(0.0).put(x_sigma).zeros(2 * 8);
  };
  expect_refused<slam_command_t>({
      {"unknown kind", of_kind(slam_command_t::RELOCALIZE + 1), RejectReason::out_of_range},
      {"negative kind", of_kind(-128), RejectReason::out_of_range},
      {"name of length 0", named(0), RejectReason::bad_text},
      {"name of smallest length", named(kIntMin), RejectReason::bad_text},
      {"name too long", named(66).text(std::string(65, 'a')).zeros(1 + 6 * 8), RejectReason::bad_text},
      {"name with control character", named(2).text("\n").zeros(1 + 6 * 8), RejectReason::bad_text},
      {"place NaN", at(kNan, 0.1), RejectReason::not_finite},
      {"place out of this world", at(1e9, 0.1), RejectReason::out_of_range},
      {"negative sigma", at(0.0, -0.1), RejectReason::out_of_range},
      {"trailing byte", at(0.0, 0.1).zeros(1), RejectReason::trailing_bytes},
  });
}

}  // namespace
}  // namespace leadline::app
