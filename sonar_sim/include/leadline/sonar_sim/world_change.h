/// @file
/// Objects that are taken away, and others that are put there, while the vehicle is under way.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "leadline/core/options.h"
#include "leadline/sonar_sim/noise.h"

namespace leadline {

/// Which objects go is drawn from those that are there by then.
struct WorldChange {
  double time = 0.0;  ///< [s], since the beginning
  int removed = 0;
  int added = 0;
};

/// The list `changes`. @param objects that are there before the first one.
void visit(OptionVisitor& visitor, std::vector<WorldChange>& changes, int objects);

/// @return @p count of the indices @p among, each once. Precondition: there are so many.
std::vector<std::size_t> draw(Noise& noise, std::vector<std::size_t> among, int count);

/// Makes the changes: what is there before them has its lifetime ended, what comes its beginning.
/// @param epoch [us], utime of the beginning.
/// @param objects each with a `life`.
/// @param add called as add(c, i) for each object i that change c adds; appends it to @p objects.
/// Precondition: the changes are valid.
template <class Objects, class Add>
void apply(std::span<const WorldChange> changes, std::uint64_t seed, std::int64_t epoch, Objects& objects,
           const Add& add) {
  Noise noise(seed, "objects taken away");
  for (std::size_t c = 0; c < changes.size(); ++c) {
    const std::int64_t utime = epoch + std::llround(changes[c].time * 1e6);
    std::vector<std::size_t> there;
    for (std::size_t i = 0; i < objects.size(); ++i)
      if (objects[i].life.contains(utime)) there.push_back(i);
    for (const std::size_t i : draw(noise, there, changes[c].removed)) objects[i].life.until = utime;
    for (int i = 0; i < changes[c].added; ++i) {
      add(c, i);
      objects.back().life.from = utime;
    }
  }
}

}  // namespace leadline
