/// @file
/// Recordings that are equal to the last bit.
#pragma once

#include <gmock/gmock.h>

#include <bit>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// All that is in a recording, one line an item, doubles by their bits.
inline std::vector<std::string> lines(const Recording& recording) {
  std::vector<std::string> lines;
  std::ostringstream line;
  const auto put = [&](auto value) {
    if constexpr (std::is_same_v<decltype(value), double>) {
      line << ' ' << value << '/' << std::hex << std::bit_cast<std::uint64_t>(value) << std::dec;
    } else {
      line << ' ' << value;
    }
  };
  const auto put_all = [&](const char* what, auto... values) {
    line.str(what);
    line.seekp(0, std::ios::end);
    (put(values), ...);
    lines.push_back(line.str());
  };
  for (const Instant& instant : recording.instants) {
    put_all("instant", instant.utime);
    if (const auto* in = std::get_if<VelocityInput>(&instant.input))
      put_all("velocity", in->speed, in->yaw_rate);
    if (const auto* in = std::get_if<AckermannInput>(&instant.input))
      put_all("ackermann", in->speed, in->steering);
    if (const auto* in = std::get_if<OdometryInput>(&instant.input))
      put_all("odometry", in->dx, in->dy, in->dheading);
    if (instant.heading) put_all("heading", instant.heading->value, instant.heading->sigma);
    if (instant.speed) put_all("speed", instant.speed->value, instant.speed->sigma);
    if (instant.velocity) {
      const auto& [surge, sway] = *instant.velocity;
      put_all("velocity", surge.value, surge.sigma, sway.value, sway.sigma);
    }
    if (instant.yaw_rate) put_all("yaw rate", instant.yaw_rate->value, instant.yaw_rate->sigma);
    for (const Sighting& s : instant.sightings)
      put_all("sighting", s.sensor, s.range, s.bearing, s.label, s.sigma, s.confidence);
    for (const int sensor : instant.silent) put_all("silent", sensor);
  }
  for (const Truth& truth : recording.truth) {
    put_all("truth", truth.utime, truth.x, truth.y);
    if (truth.heading) put_all("true heading", *truth.heading);
    if (truth.speed) put_all("true speed", *truth.speed);
  }
  for (const TrueFeature& f : recording.map) {
    put_all(f.kind == TargetKind::wall ? "wall" : "point", f.label, f.x, f.y, f.rho, f.alpha, f.life.from,
            f.life.until);
  }
  return lines;
}

MATCHER_P(IsRecording, expected, "is the same recording") {
  return ::testing::ExplainMatchResult(::testing::ElementsAreArray(lines(expected)), lines(arg),
                                       result_listener);
}

}  // namespace leadline::app
