#include "apps/wire/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "apps/support/overloaded.h"
#include "leadline/core/angle.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline::app {
namespace {

constexpr std::int8_t kPoint = truth_map_t::POINT, kWall = truth_map_t::WALL, kAdded = truth_map_t::ADDED,
                      kGone = truth_map_t::GONE;  // generated without definition

std::int8_t kind_of(const TrueFeature& feature, std::int64_t utime) {
  return static_cast<std::int8_t>((feature.kind == TargetKind::wall ? kWall : kPoint) +
                                  (feature.life.from != Lifetime{}.from ? kAdded : 0) +
                                  (feature.life.until <= utime ? kGone : 0));
}

Lifetime life_of(int kind, std::int64_t utime) {
  Lifetime life;
  if ((kind & kAdded) != 0) life.from = utime;
  if ((kind & kGone) != 0) life.until = utime;
  return life;
}

range_sonar_t current(range_sonar_plain_t plain) {
  const std::size_t count = plain.range.size();
  return {plain.utime,
          plain.seq,
          std::move(plain.sensor),
          plain.count,
          std::move(plain.range),
          std::move(plain.label),
          std::vector<double>(count, 0.0),
          std::vector<double>(count, Sighting::kNoConfidence)};
}
template <class T>
T current(T message) {
  return message;
}

template <class T>
std::variant<Message, Rejection> receive_message(Bytes bytes) {
  auto received = receive<T>(bytes);
  if (auto* rejection = std::get_if<Rejection>(&received)) return std::move(*rejection);
  return Message(current(std::move(std::get<T>(received))));
}

std::variant<Message, Rejection> receive_sonar(Bytes bytes) {
  return is_of(message_format<range_sonar_plain_t>(), bytes) ? receive_message<range_sonar_plain_t>(bytes)
                                                             : receive_message<range_sonar_t>(bytes);
}

template <class T>
constexpr Receiver kReceiver = std::is_same_v<T, range_sonar_t> ? receive_sonar : receive_message<T>;

template <class... Ts>
Receiver find_receiver(std::string_view channel, std::type_identity<std::variant<Ts...>>) {
  Receiver receiver = nullptr;
  (void)((message_format<Ts>().channel == channel && (receiver = kReceiver<Ts>)) || ...);
  return receiver;
}

template <class... Ts>
const MessageFormat* find_format(Bytes bytes, std::type_identity<std::variant<Ts...>>) {
  const MessageFormat* format = nullptr;
  (void)((is_of(message_format<Ts>(), bytes) && (format = &message_format<Ts>())) || ...);
  return format;
}

void put(const velocity_t& m, Instant& instant) { instant.input = VelocityInput{m.speed, m.yaw_rate}; }
void put(const ackermann_t& m, Instant& instant) { instant.input = AckermannInput{m.speed, m.steering}; }
void put(const odometry_t& m, Instant& instant) {
  instant.input = OdometryInput{m.dx, m.dy, m.dheading, m.seq};
}
/// A reading that claims to be no surer than a configuration may. @param unit one of its unit's [SI].
Reading reading_of(double value, double sigma, double unit = 1.0) {
  return {value, sigma > 0.0 ? std::max(sigma, kLeastSigma * unit) : sigma};
}

constexpr double kDegree = from_degrees(1.0);
void put(const heading_t& m, Instant& instant) { instant.heading = reading_of(m.heading, m.sigma, kDegree); }
void put(const speed_t& m, Instant& instant) { instant.speed = reading_of(m.speed, m.sigma); }
void put(const yaw_rate_t& m, Instant& instant) {
  instant.yaw_rate = reading_of(m.yaw_rate, m.sigma, kDegree);
}
void put(const body_velocity_t& m, Instant& instant) {
  instant.velocity = BodyVelocity{reading_of(m.surge, m.surge_sigma), reading_of(m.sway, m.sway_sigma)};
}

Sensor::Kind kind_of(const range_sonar_t&) { return Sensor::Kind::range_sonar; }
Sensor::Kind kind_of(const range_bearing_t&) { return Sensor::Kind::range_bearing; }

double bearing_of(const range_sonar_t&, std::size_t) { return 0.0; }
double bearing_of(const range_bearing_t& message, std::size_t i) { return message.bearing[i]; }

void take_quality(const range_sonar_t& message, std::size_t i, Sighting& sighting) {
  sighting.sigma = message.sigma[i];
  if (message.confidence[i] >= 0.0) sighting.confidence = message.confidence[i];
}
void take_quality(const range_bearing_t&, std::size_t, Sighting&) {}

// Motion and readings.
template <class T>
Content reading(const T& message) {
  Instant instant;
  instant.utime = message.utime;
  put(message, instant);
  return instant;
}

// What a sensor saw.
template <class T>
Content scan(const T& message, std::span<const Sensor> sensors) {
  const auto found = std::ranges::find_if(sensors, [&](const Sensor& sensor) {
    return sensor.name == message.sensor && sensor.kind == kind_of(message);
  });
  if (found == sensors.end()) {
    return Rejection{RejectReason::unknown_sensor,
                     fmt::format("{}: no sensor of this kind is named '{}' in the configuration",
                                 T::getTypeName(), message.sensor)};
  }
  const auto sensor = static_cast<int>(found - sensors.begin());
  Instant instant;
  instant.utime = message.utime;
  for (std::size_t i = 0; i < message.range.size(); ++i) {
    instant.sightings.push_back({sensor, message.range[i], bearing_of(message, i), message.label[i]});
    take_quality(message, i, instant.sightings.back());
  }
  if (instant.sightings.empty()) instant.silent.push_back(sensor);
  return instant;
}

Content truth(const truth_t& message) {
  Truth truth;
  truth.utime = message.utime;
  truth.x = message.x;
  truth.y = message.y;
  if (message.heading_known != 0) truth.heading = message.heading;
  if (message.speed_known != 0) truth.speed = message.speed;
  return truth;
}

Content features(const truth_map_t& message) {
  std::vector<TrueFeature> map;
  for (std::size_t i = 0; i < message.label.size(); ++i) {
    map.push_back({.label = message.label[i],
                   .kind = (message.kind[i] & kWall) != 0 ? TargetKind::wall : TargetKind::point,
                   .x = message.x[i],
                   .y = message.y[i],
                   .rho = message.rho[i],
                   .alpha = message.alpha[i],
                   .life = life_of(message.kind[i], message.utime)});
  }
  return map;
}

void add_target(const Sighting& sighting, range_sonar_t& message) {
  message.range.push_back(sighting.range);
  message.label.push_back(sighting.label);
  message.sigma.push_back(sighting.sigma);
  message.confidence.push_back(sighting.confidence);
}

void add_target(const Sighting& sighting, range_bearing_t& message) {
  message.range.push_back(sighting.range);
  message.bearing.push_back(sighting.bearing);
  message.label.push_back(sighting.label);
}

// The scan of sensor number `index`.
template <class T>
Message scan_message(const Instant& instant, const Sensor& sensor, std::size_t index) {
  T message{};
  message.utime = instant.utime;
  message.sensor = sensor.name;
  for (const Sighting& sighting : instant.sightings) {
    if (sighting.sensor == static_cast<int>(index)) add_target(sighting, message);
  }
  message.count = static_cast<std::int32_t>(message.range.size());
  return message;
}

}  // namespace

Receiver receiver_of(std::string_view channel, std::string_view prefix) {
  if (!channel.starts_with(prefix)) return nullptr;
  return find_receiver(channel.substr(prefix.size()), std::type_identity<Message>{});
}

const MessageFormat* format_of(Bytes bytes) {
  if (is_of(message_format<range_sonar_plain_t>(), bytes)) return &message_format<range_sonar_plain_t>();
  return find_format(bytes, std::type_identity<EveryMessage>{});
}

Content content(const Message& message, std::span<const Sensor> sensors) {
  const Overloaded visitor{
      [](const auto& m) { return reading(m); },
      [&](const range_sonar_t& m) { return scan(m, sensors); },
      [&](const range_bearing_t& m) { return scan(m, sensors); },
      [](const truth_t& m) { return truth(m); },
      [](const truth_map_t& m) { return features(m); },
  };
  return std::visit(visitor, message);
}

std::vector<Message> to_messages(const Instant& instant, std::span<const Sensor> sensors) {
  std::vector<Message> messages;
  const std::int64_t utime = instant.utime;
  const Overloaded add_input{
      [](std::monostate) {},
      [&](const VelocityInput& input) {
        messages.emplace_back(velocity_t{utime, 0, input.speed, input.yaw_rate});
      },
      [&](const AckermannInput& input) {
        messages.emplace_back(ackermann_t{utime, 0, input.speed, input.steering});
      },
      [&](const OdometryInput& input) {
        messages.emplace_back(odometry_t{utime, 0, input.dx, input.dy, input.dheading});
      },
  };
  std::visit(add_input, instant.input);
  if (instant.heading)
    messages.emplace_back(heading_t{utime, 0, instant.heading->value, instant.heading->sigma});
  if (instant.speed) messages.emplace_back(speed_t{utime, 0, instant.speed->value, instant.speed->sigma});
  if (instant.velocity) {
    const auto& [surge, sway] = *instant.velocity;
    messages.emplace_back(body_velocity_t{utime, 0, surge.value, sway.value, surge.sigma, sway.sigma});
  }
  if (instant.yaw_rate)
    messages.emplace_back(yaw_rate_t{utime, 0, instant.yaw_rate->value, instant.yaw_rate->sigma});

  std::vector<bool> pinged(sensors.size());
  const auto note_ping = [&](int sensor) {
    if (sensor < 0 || sensor >= static_cast<int>(sensors.size())) {
      throw std::invalid_argument(
          fmt::format("the instant has sensor {}, but there are {} sensors", sensor, sensors.size()));
    }
    pinged[static_cast<std::size_t>(sensor)] = true;
  };
  for (const Sighting& sighting : instant.sightings) note_ping(sighting.sensor);
  for (const int sensor : instant.silent) note_ping(sensor);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (!pinged[i]) continue;
    messages.push_back(sensors[i].kind == Sensor::Kind::range_sonar
                           ? scan_message<range_sonar_t>(instant, sensors[i], i)
                           : scan_message<range_bearing_t>(instant, sensors[i], i));
  }
  return messages;
}

Message to_message(const Truth& truth) {
  return truth_t{truth.utime,
                 0,
                 truth.x,
                 truth.y,
                 truth.heading.has_value(),
                 truth.heading.value_or(0.0),
                 truth.speed.has_value(),
                 truth.speed.value_or(0.0)};
}

std::vector<Message> to_messages(std::span<const TrueFeature> map, std::int64_t utime) {
  std::vector<Message> messages;
  while (!map.empty()) {
    const auto part = map.first(std::min<std::size_t>(map.size(), truth_map_t::MAX_FEATURES));
    map = map.subspan(part.size());
    truth_map_t message{};
    message.utime = utime;
    message.count = static_cast<std::int32_t>(part.size());
    for (const TrueFeature& feature : part) {
      message.label.push_back(feature.label);
      message.kind.push_back(kind_of(feature, utime));
      message.x.push_back(feature.x);
      message.y.push_back(feature.y);
      message.rho.push_back(feature.rho);
      message.alpha.push_back(feature.alpha);
    }
    messages.emplace_back(std::move(message));
  }
  return messages;
}

}  // namespace leadline::app
