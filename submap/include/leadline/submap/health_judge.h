/// @file
/// Whether the estimator is doing well, by its own innovations: no truth is needed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "leadline/submap/range_watch.h"
#include "leadline/vehicle/input_watch.h"
#include "leadline/vehicle/reading_gate.h"

namespace leadline {

enum class Standing : std::int8_t {
  ok,
  degraded,  ///< a channel is not what it should be; the estimate goes on without it
  lost       ///< the estimate itself is doubted
};

/// What is wrong with a channel.
struct Finding {
  enum class Kind : std::int8_t {
    none,
    wide,           ///< innovations far larger than expected; figure: mean NIS by degree of freedom
    refused,        ///< readings outside the gate; figure: NIS of the last one
    repeats,        ///< a value over and over; figure: how often so far
    silent,         ///< nothing comes any more; figure: [s]
    tiny_sigma,     ///< it brings a standard deviation that is not to be believed; figure: that
    beginning,      ///< the first readings were far from the configured beginning; figure: how far
    conflict,       ///< readings are refused, and the map does not support the estimate either; figure: NIS
    doubted,        ///< it was believed against the estimate; figure: by how much
    input_refused,  ///< an input far beyond all others; figure: how many so far
    input_silent,   ///< inputs have ended; figure: [s]
    input_lost,     ///< increments are missing; figure: how many so far
    stays,          ///< a sonar says one range wherever the vehicle goes; figure: it [m]
    deaf,           ///< a sonar hears nothing of what is there; figure: pings in a row
    unmet           ///< what the map says is there is not heard; figure: misses more than hits of late
  };
  Kind kind = Kind::none;
  int channel = -1;  ///< ReadingChannel, or kReadingChannels and more: sensors in their order; -1: none
  double figure = 0.0;
};

Standing standing_of(Finding::Kind kind);

/// The innovations of a channel, the latest.
///
/// Alarms follow from chi-square alone. With n innovations of NIS sum s, the variance of the innovations is
/// at least s / q times the expected one, q the quantile that right ones stay below but in one of a million
/// windows. From four times on, errors twice as large as told, the window is wide.
class InnovationWindow {
 public:
  static constexpr int kSize = 32;

  /// @param whitened residual over its standard deviation; of more than one degree of freedom the root of
  /// NIS.
  void note(double whitened, int dof);

  int size() const { return size_; }
  /// By degree of freedom, 1 expected; 0 if there are none.
  double nis() const { return dof_ > 0 ? sum_ / dof_ : 0.0; }
  bool is_wide() const;
  /// Correlation of neighbours, of innovations with one degree of freedom: 0 if they are white, near 1 where
  /// a channel has a bias.
  double lag1() const;

 private:
  struct Entry {
    double whitened = 0.0;
    int dof = 0;
  };
  std::array<Entry, kSize> entries_;
  int next_ = 0, size_ = 0, dof_ = 0;
  double sum_ = 0.0;
};

/// Judges all channels after every step. No member allocates after construction.
class HealthJudge {
 public:
  explicit HealthJudge(std::size_t sensors);

  struct Step {
    double dt = 0.0;  ///< [s], since the last one
    std::span<const ReadingGate> gates;
    const InputWatch* inputs = nullptr;
    std::span<const RangeWatch> ranges = {};  ///< by sensor, or none
  };

  /// A ping that should have met a confirmed feature.
  struct Meeting {
    enum class Fate : std::int8_t {
      met,
      missed,  ///< it heard what lies behind
      unheard  ///< it heard nothing at all
    };
    std::size_t sensor = 0;
    Fate fate = Fate::met;
    int feature = 0;         ///< id
    double travelled = 0.0;  ///< [m] by the vehicle so far
  };

  /// A reading or a sighting has come. @param tiny its own standard deviation, if that is not believed;
  /// else 0.
  void note_sigma(std::size_t channel, double tiny) { channels_[channel].tiny_sigma = tiny; }
  /// A sighting of what is in the map or may be. @param matched to a feature.
  void note_sighting(bool matched);
  /// It was matched. @param nis normalized innovation squared.
  void note_match(std::size_t sensor, double nis, int dof);
  /// It has heard something, whatever that is.
  void note_return(std::size_t sensor);
  void note_meeting(const Meeting& meeting);
  /// All of the step has been noted.
  void judge(const Step& step);

  /// The estimate begins anew: what was wrong with it says nothing any more. What was counted stays.
  void restart();

  Standing standing() const { return standing_; }
  /// What the map says is there is not heard.
  bool is_map_unmet() const;
  /// A sensor is silent where it should hear several features, and nothing else contradicts the map: that it
  /// is dead is likelier than that none of them is there.
  bool is_deaf(std::size_t sensor) const;
  /// Share of the latest sightings that the map explains.
  double supported() const { return supported_; }
  /// The estimate is wrong by nobody knows what.
  bool is_estimate_wrong() const { return wrong_; }
  /// What is wrong, the worst first.
  std::span<const Finding> findings() const { return {findings_.data(), found_}; }

  /// Figures of a channel, numbered as in Finding.
  struct Figures {
    std::int64_t judged = 0;
    double nis = 0.0;  ///< by degree of freedom, over all
  };
  std::size_t channels() const { return channels_.size(); }
  Figures figures(std::size_t channel) const;
  const InnovationWindow& window(std::size_t channel) const { return channels_[channel].window; }

 private:
  struct Channel {
    InnovationWindow window;
    std::int64_t judged = 0;
    double sum = 0.0, dof = 0.0;
    double since = 0.0;     ///< [s] since the last reading
    double interval = 0.0;  ///< [s] usual between two
    int refused_in_a_row = 0;
    std::uint8_t refused = 0;  ///< one bit for each of the last 8
    double refused_nis = 0.0;
    double tiny_sigma = 0.0;   ///< that the last reading brought, if it was not believed; else 0
    double beginning = 0.0;    ///< how far the first were, if they were; else 0
    double doubted = 0.0;      ///< how far those were that were last believed against the estimate
    double doubted_for = 0.0;  ///< [s] for which that is told still
    int unheard = 0;           ///< pings in a row that should have met something and heard nothing at all
    double unheard_from = 0.0, unheard_to = 0.0;  ///< [m], travelled at the first and at the last of them
    int unheard_first = 0;                        ///< id of what the first should have met
    bool are_several = false;                     ///< whether another should have met something else
    int others = 0;  ///< pings of other sensors meanwhile that have met the map, over those that have not
  };

  std::size_t sensors() const { return channels_.size() - kReadingChannels; }
  void take(Channel& channel, const ReadingGate& gate, double dt);
  void find_in_reading(int index, const ReadingGate& gate);
  void find_in_sensor(std::size_t sensor, std::span<const RangeWatch> ranges);
  void find_in_inputs(const InputWatch& inputs, double dt);
  void add(Finding::Kind kind, int channel, double figure);

  std::vector<Channel> channels_;
  std::vector<Finding> findings_;  // room for all that there may be, so that copies have it, too
  std::size_t found_ = 0;          // of them in use
  Standing standing_ = Standing::ok;
  bool wrong_ = false;
  double supported_ = 0.0;  // share of matches among the latest sightings
  double unmet_ = 0.0;      // log likelihood ratio that the map is not met, of a test one after the other
  InputWatch::Counts inputs_;
  double input_refused_for_ = 0.0, input_lost_for_ = 0.0;  // [s] for which that is told still
};

}  // namespace leadline
