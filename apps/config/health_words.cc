#include "apps/config/health_words.h"

#include <fmt/format.h>

#include <algorithm>

namespace leadline::app {
namespace {

constexpr int kReadings = static_cast<int>(kReadingChannels);

/// A figure in the unit of a channel.
std::string with_unit(double figure, int channel) {
  if (channel >= kReadings) return fmt::format("{:.3g} m", figure);
  switch (static_cast<ReadingChannel>(channel)) {
    case ReadingChannel::heading:
      return fmt::format("{:.3g} deg", to_degrees(figure));
    case ReadingChannel::yaw_rate:
      return fmt::format("{:.3g} deg/s", to_degrees(figure));
    case ReadingChannel::speed:
    case ReadingChannel::surge:
    case ReadingChannel::sway:
      break;
  }
  return fmt::format("{:.3g} m/s", figure);
}

std::string said(const Finding& finding) {
  using enum Finding::Kind;
  const auto& [kind, channel, figure] = finding;
  switch (kind) {
    case wide:
      return fmt::format("NIS {:.3g}, 1 expected: {}", figure,
                         channel < kReadings ? "unit, mount or sigma?" : "sigma, mount or association?");
    case refused:
      return fmt::format("refused, NIS {:.4g}, 1 expected: unit, mount or a disturbance?", figure);
    case conflict:
      return fmt::format(
          "refused, NIS {:.4g}, 1 expected, and no map supports the estimate: unit, mount, or lost?", figure);
    case repeats:
      return fmt::format("one value {:.0f} times over: frozen, or out of reach?", figure + 1.0);
    case silent:
      return fmt::format("silent for {:.0f} s", figure);
    case tiny_sigma:
      return fmt::format(
          "brings a standard deviation of {}, not believed, the configured one is used: never set?",
          with_unit(figure, channel));
    case beginning:
      return fmt::format("its first readings were {} from vehicle.initial: unit, convention, or initial?",
                         with_unit(figure, channel));
    case doubted:
      return fmt::format("believed against the estimate, which was {} off", with_unit(figure, channel));
    case input_refused:
      return fmt::format("{:.0f} refused so far, far beyond all others", figure);
    case input_silent:
      return fmt::format("silent for {:.0f} s, the vehicle's motion is not known", figure);
    case input_lost:
      return fmt::format("{:.0f} increments lost so far", figure);
    case stays:
      return fmt::format("says {:.3g} m wherever the vehicle goes, not used: stuck, or out of reach?",
                         figure);
    case deaf:
      return fmt::format("heard nothing at {:.0f} pings in a row, unlike before: dead, or nothing there?",
                         figure);
    case unmet:
      return "what it says is there is not heard: the estimate is lost";
    case none:
      break;
  }
  return {};
}

std::string words_of(const Place& place) {
  const auto& [X, P] = place.X_WV;
  return fmt::format("({:.1f}, {:.1f}) m, {:.0f} deg by {:.4g} %", X.x, X.y, to_degrees(X.heading),
                     100.0 * place.probability);
}

}  // namespace

std::string channel_name(int channel, std::span<const Sensor> sensors, std::string_view prefix) {
  constexpr std::string_view kNames[] = {"HEADING", "SPEED", "BODY_VELOCITY/surge", "BODY_VELOCITY/sway",
                                         "YAW_RATE"};
  if (channel < 0) return {};
  if (channel < kReadings) return fmt::format("{}{}", prefix, kNames[channel]);
  const Sensor& sensor = sensors[static_cast<std::size_t>(channel - kReadings)];
  return fmt::format("{}{}/{}", prefix,
                     sensor.kind == Sensor::Kind::range_sonar ? "RANGE_SONAR" : "RANGE_BEARING", sensor.name);
}

std::string sentence(const Finding& finding, std::span<const Sensor> sensors, std::string_view prefix) {
  const std::string channel = finding.channel >= 0 ? channel_name(finding.channel, sensors, prefix)
                              : finding.kind == Finding::Kind::unmet ? "map"
                                                                     : "input";
  return fmt::format("{}: {}", channel, said(finding));
}

std::string places_in_words(const Slam& slam) {
  constexpr std::size_t kMost = 3;
  const std::optional<PlaceAnswer>& answer = slam.places();
  const bool is_nothing =
      !answer || answer->places.empty() || answer->verdict == PlaceAnswer::Verdict::nothing;
  if (!slam.is_looking())
    return is_nothing ? "place: found" : "place: found at " + words_of(answer->places.front());
  std::string words = "place: not known, looked for in the map";
  if (is_nothing) return words + ": nothing there is like what is heard so far";
  for (std::size_t i = 0; i < std::min(kMost, answer->places.size()); ++i)
    words += (i == 0 ? "; may be at " : ", ") + words_of(answer->places[i]);
  return words;
}

std::vector<std::string> health_complaints(const Slam& slam, std::string_view prefix) {
  std::vector<std::string> complaints;
  if (slam.is_looking()) complaints.push_back(places_in_words(slam));
  for (const Finding& finding : slam.judge().findings())
    complaints.push_back(sentence(finding, slam.options().sensors, prefix));
  return complaints;
}

std::string_view name(Standing standing) {
  switch (standing) {
    case Standing::ok:
      return "ok";
    case Standing::degraded:
      return "degraded";
    case Standing::lost:
      break;
  }
  return "lost";
}

}  // namespace leadline::app
